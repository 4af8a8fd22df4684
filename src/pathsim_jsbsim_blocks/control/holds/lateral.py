"""Holds that act on the ailerons and the rudder: roll, heading, yaw damper."""

from __future__ import annotations

from ..._core.checks import optional, positive
from ..._core.parameters import parameter
from ..controller import Authority, Hold, authority_limits, fill, reference_kind
from ..gains import Gains
from ..loops import (
    HeadingLoop,
    ReferenceLoop,
    State,
    YawLoop,
    roll_loop,
)

# the package and PathView export these names
__all__ = ["HeadingHold", "RollHold", "YawDamper"]


@fill
class RollHold(Hold):
    """Holds the roll angle with the ailerons; with ``phi_ref=0`` a wing leveller.

    .. math::
        \\delta_a = K_p (b \\, \\phi_\\mathrm{cmd} - \\phi)
        + K_i \\int (\\phi_\\mathrm{cmd} - \\phi) \\, dt - K_r p

    sampled at T. The reference phi_cmd starts at the roll angle found at engagement and moves to
    ``phi_ref`` (parameter plus port) no faster than the gain table's ramp.

    Parameters
    ----------
    gains : str, AttitudeGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/deg), Ki (1/(deg s)), Kr (s/deg), b,
        ramp (deg/s)
    phi_ref : float, optional
        roll angle to hold in deg, right positive; default: the value at engagement
    authority : float or pair
        largest aileron increment, of full travel
    %(T)s
    %(reference)s

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
    %(vc)s

    Outputs
    -------
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    phi_ref: float | None = parameter(None, optional)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = {"phi": 0, "p": 1, "phi_ref": 2, "off": 3, "ail_sat": 4, "vc": 5}
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    def build(self) -> None:
        (gains,) = self.gains_of("roll")
        self._phi_ref = self.checked.phi_ref
        self._roll = roll_loop(self.clock.period, gains, self.checked.authority, self._loop)

    def initial_state(self) -> State:
        return ReferenceLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        phi, p, phi_ref, off, ail_sat, vc = u[:6]
        target = self._phi_ref
        if self._absolute:
            target, phi_ref = self.target("phi_ref", phi_ref, target)
        if self._schedule is not None:
            self.follow(vc, roll=self._roll)
        aileron, phi_cmd, state = self._roll.sample(
            state, phi, p, target, phi_ref, ail_sat, off != 0.0
        )
        return [aileron, phi_cmd], state


@fill
class HeadingHold(Hold):
    """Holds the heading with the ailerons; turns through the smaller angle, also across north.

    .. math::
        \\phi_\\mathrm{cmd} = \\phi_0 + K_p e + K_i \\int e \\, dt, \\quad
        e = \\mathrm{wrap}(\\psi_\\mathrm{ref} - \\psi), \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the roll loop of ``RollHold`` inside, sampled at T. Engaged in a turn, it levels the wings
    and returns to the heading found at engagement.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"heading": ..., "roll": ...}, each either the name of
        a table or numbers; heading: Kp (deg/deg), Ki (1/s), bank (phi_0, the bank of straight
        flight, deg); roll: as in ``RollHold``
    psi_ref : float, optional
        heading to hold in deg; default: the value at engagement
    bank_max : float
        largest bank reference in deg
    authority : float or pair
        largest aileron increment, of full travel
    %(T)s
    %(reference)s

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
    %(vc)s

    Outputs
    -------
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        bank reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    psi_ref: float | None = parameter(None, optional)
    bank_max: float = parameter(25.0, positive)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("psi", "phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = {"psi": 0, "phi": 1, "p": 2, "psi_ref": 3, "off": 4, "ail_sat": 5, "vc": 6}
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    def build(self) -> None:
        heading, roll = self.gains_of("heading", "roll")
        self._psi_ref = self.checked.psi_ref
        self._heading = HeadingLoop(self.clock.period, heading, self.checked.bank_max)
        self._roll = roll_loop(self.clock.period, roll, self.checked.authority, self._loop)

    def initial_state(self) -> State:
        return HeadingLoop.START, ReferenceLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        psi, phi, p, psi_ref, off, ail_sat, vc = u[:7]
        heading, roll = state
        wanted = self._psi_ref
        if self._absolute:
            wanted, psi_ref = self.target("psi_ref", psi_ref, wanted)
        if self._schedule is not None:
            self.follow(vc, heading=self._heading, roll=self._roll)
        target = None
        if off:
            heading = HeadingLoop.START
        else:
            target, heading = self._heading.sample(heading, psi, wanted, psi_ref)
        aileron, phi_cmd, roll = self._roll.sample(roll, phi, p, target, 0.0, ail_sat, off != 0.0)
        return [aileron, phi_cmd], (heading, roll)


@fill
class YawDamper(Hold):
    """Damps the Dutch roll with the rudder and keeps the sideslip at 0.

    .. math::
        \\delta_r = K \\, \\frac{\\tau s}{1 + \\tau s} \\, r
        - K_p \\beta - K_i \\int \\beta \\, dt
        + K_\\mathrm{roll} \\, p + K_\\mathrm{bank} \\frac{180}{\\pi} \\sin \\phi

    sampled at T. The wash-out leaves steady turns unopposed. With the ports ``beta``, ``p`` and
    ``phi`` wired, turns are coordinated: the last two act before any sideslip has built up.

    Parameters
    ----------
    gains : str, YawGains or dict
        name of a gain table ("c172p"; in "737" and "global5000", whose models have their own
        damper, K is 0), or numbers: K (s/deg), tau (s), Kp (1/deg), Ki (1/(deg s)), Kroll (s/deg),
        Kbank (1/deg, of the sine of the bank times 57.3); K, Kp and Ki are positive where positive
        rudder yaws the nose left
    authority : float or pair
        largest rudder increment, of full travel
    %(T)s

    Inputs
    ------
    r
        yaw rate in deg/s
    off
        0 engaged; otherwise the rudder increment decays to 0 with tau
    beta
        angle of sideslip in deg; without a wire (0) it is not fed back
    %(vc)s
    p, phi
        roll rate in deg/s, bank in deg; without a wire (0) they are not fed forward

    Outputs
    -------
    rudder
        increment of the rudder command; positive yaws the nose left on most models

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)

    measured = ("r",)
    commands = {"rudder": "off"}
    input_port_labels = {"r": 0, "off": 1, "beta": 2, "vc": 3, "p": 4, "phi": 5}
    output_port_labels = {"rudder": 0}

    def build(self) -> None:
        (gains,) = self.gains_of("yaw")
        self._yaw = YawLoop(self.clock.period, gains, self.checked.authority)

    def initial_state(self) -> State:
        return YawLoop.START

    def law(self, u: list[float], state: State) -> tuple[list[float], State]:
        r, off, beta, vc, p, phi = u[:6]
        if self._schedule is not None:
            self.follow(vc, yaw=self._yaw)
        rudder, state = self._yaw.sample(state, r, off != 0.0, beta, p, phi)
        return [rudder], state
