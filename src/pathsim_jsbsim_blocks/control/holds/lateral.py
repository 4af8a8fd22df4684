"""Holds that act on the ailerons and the rudder: roll, heading, yaw damper."""

from __future__ import annotations

from ..._core.tunable import TunableLaw
from ..controller import Authority, fill
from ..gains import Gains, loop_gains
from ..loops import (
    HeadingLoop,
    ReferenceLoop,
    State,
    WashoutLoop,
    limits,
    optional,
    roll_loop,
)

# the package and PathView export these names
__all__ = ["HeadingHold", "RollHold", "YawDamper"]


@fill
class RollHold(TunableLaw):
    """Holds the roll angle with the ailerons; with ``phi_ref=0`` a wing leveller.

    .. math::
        \\delta_a = K_p (b \\, \\phi_\\mathrm{cmd} - \\phi)
        + K_i \\int (\\phi_\\mathrm{cmd} - \\phi) \\, dt - K_r p

    sampled at T. The reference phi_cmd starts at the roll angle found at engagement and moves to
    ``phi_ref`` (parameter plus port) no faster than the gain table's ramp.

    Parameters
    ----------
    gains : str, AttitudeGains or dict
        "c172p", "737" or "global5000", or numbers: Kp (1/deg), Ki (1/(deg s)), Kr (s/deg), b,
        ramp (deg/s)
    phi_ref : float, optional
        roll angle to hold in deg, right positive; default: the value at engagement
    authority : float or pair
        largest aileron increment, of full travel
    %(T)s

    Inputs
    ------
    phi, p
        roll angle in deg, roll rate in deg/s
    phi_ref
        deg, added to the parameter
    off
        0 engaged; otherwise the ailerons are frozen
    ail_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel

    Outputs
    -------
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        reference on its ramp, deg

    %(raises)s
    """

    measured = ("phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = {"phi": 0, "p": 1, "phi_ref": 2, "off": 3, "ail_sat": 4}
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    def __init__(
        self,
        gains: Gains = "c172p",
        phi_ref: float | None = None,
        authority: Authority = 1.0,
        T: float = 1 / 120,
    ) -> None:
        super().__init__(T)
        self.gains = gains
        self.phi_ref = phi_ref
        self.authority = authority
        self.configure()

    def build(self) -> None:
        (gains,) = loop_gains(self.gains, "roll")
        self._phi_ref = optional("phi_ref", self.phi_ref)
        self._roll = roll_loop(self.clock.period, gains, limits("authority", self.authority))

    def initial_state(self) -> State:
        return ReferenceLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        phi, p, phi_ref, off, ail_sat = u[:5]
        aileron, phi_cmd, state = self._roll.sample(
            state, phi, p, self._phi_ref, phi_ref, ail_sat, off != 0.0
        )
        return [aileron, phi_cmd], state


@fill
class HeadingHold(TunableLaw):
    """Holds the heading with the ailerons; turns through the smaller angle, also across north.

    .. math::
        \\phi_\\mathrm{cmd} = K_p e + K_i \\int e \\, dt, \\quad
        e = \\mathrm{wrap}(\\psi_\\mathrm{ref} - \\psi), \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the roll loop of ``RollHold`` inside, sampled at T. Engaged in a turn, it levels the wings
    and returns to the heading found at engagement.

    Parameters
    ----------
    gains : str or dict
        "c172p", "737" or "global5000", or {"heading": ..., "roll": ...}, each either the name of
        a table or numbers; heading: Kp (deg/deg), Ki (1/s); roll: as in ``RollHold``
    psi_ref : float, optional
        heading to hold in deg; default: the value at engagement
    bank_max : float
        largest bank reference in deg
    authority : float or pair
        largest aileron increment, of full travel
    %(T)s

    Inputs
    ------
    psi, phi, p
        heading and roll angle in deg, roll rate in deg/s
    psi_ref
        deg, added to the parameter
    off
        0 engaged; otherwise the ailerons are frozen
    ail_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel

    Outputs
    -------
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        bank reference on its ramp, deg

    %(raises)s
    """

    measured = ("psi", "phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = {"psi": 0, "phi": 1, "p": 2, "psi_ref": 3, "off": 4, "ail_sat": 5}
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    def __init__(
        self,
        gains: Gains = "c172p",
        psi_ref: float | None = None,
        bank_max: float = 25.0,
        authority: Authority = 1.0,
        T: float = 1 / 120,
    ) -> None:
        super().__init__(T)
        self.gains = gains
        self.psi_ref = psi_ref
        self.bank_max = bank_max
        self.authority = authority
        self.configure()

    def build(self) -> None:
        heading, roll = loop_gains(self.gains, "heading", "roll")
        self._psi_ref = optional("psi_ref", self.psi_ref)
        self._heading = HeadingLoop(self.clock.period, heading, self.bank_max)
        self._roll = roll_loop(self.clock.period, roll, limits("authority", self.authority))

    def initial_state(self) -> State:
        return HeadingLoop.START, ReferenceLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        psi, phi, p, psi_ref, off, ail_sat = u[:6]
        heading, roll = state
        target = None
        if off:
            heading = HeadingLoop.START
        else:
            target, heading = self._heading.sample(heading, psi, self._psi_ref, psi_ref)
        aileron, phi_cmd, roll = self._roll.sample(roll, phi, p, target, 0.0, ail_sat, off != 0.0)
        return [aileron, phi_cmd], (heading, roll)


@fill
class YawDamper(TunableLaw):
    """Damps the Dutch roll with the rudder; a wash-out leaves steady turns unopposed.

    .. math::
        \\delta_r = K \\, \\frac{\\tau s}{1 + \\tau s} \\, r

    sampled at T.

    Parameters
    ----------
    gains : str, YawGains or dict
        "c172p", "737" or "global5000" (the last two models have their own damper: 0), or numbers:
        K (s/deg), positive where positive rudder yaws the nose left, and tau (s)
    authority : float or pair
        largest rudder increment, of full travel
    %(T)s

    Inputs
    ------
    r
        yaw rate in deg/s
    off
        0 engaged; otherwise the rudder increment decays to 0 with tau

    Outputs
    -------
    rudder
        increment of the rudder command; positive yaws the nose left on most models

    %(raises)s
    """

    measured = ("r",)
    commands = {"rudder": "off"}
    input_port_labels = {"r": 0, "off": 1}
    output_port_labels = {"rudder": 0}

    def __init__(
        self,
        gains: Gains = "c172p",
        authority: Authority = 1.0,
        T: float = 1 / 120,
    ) -> None:
        super().__init__(T)
        self.gains = gains
        self.authority = authority
        self.configure()

    def build(self) -> None:
        (gains,) = loop_gains(self.gains, "yaw")
        self._yaw = WashoutLoop(self.clock.period, gains, limits("authority", self.authority))

    def initial_state(self) -> State:
        return WashoutLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        rudder, state = self._yaw.sample(state, u[0], u[1] != 0.0)
        return [rudder], state
