"""Holds that act on the ailerons and the rudder: roll, heading, yaw damper."""

from __future__ import annotations

from dataclasses import dataclass

from ..._core.checks import heading, number, optional, positive
from ..._core.parameters import parameter
from ..._core.ports import numbered
from ..controller import Authority, Hold, ReferenceKind, authority_limits, fill, reference_kind
from ..gains import Gains
from ..loops import LateralState, ReferenceLoop, ReferenceState, YawLoop, YawState, attitude_loop

__all__ = ["HeadingHold", "RollHold", "YawDamper"]


@fill
@dataclass(eq=False, repr=False)
class RollHold(Hold):
    """Holds the roll angle with the ailerons; with ``phi_ref=0`` a wing leveller.

    .. math::
        \\delta_a = K_p (b \\, \\phi_\\mathrm{cmd} - \\phi)
        + K_i \\int (\\phi_\\mathrm{cmd} - \\phi) \\, dt - K_r p

    sampled at T. The reference phi_cmd starts at the roll angle at engagement and moves to
    ``phi_ref`` (parameter plus port) no faster than the gain table's ramp.

    Parameters
    ----------
    gains : str, AttitudeGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/deg), Ki (1/(deg s)), Kr (s/deg), b,
        ramp (deg/s)
    phi_ref : float, optional
        roll angle to hold in deg, right positive; default: the value at engagement
    authority : float or pair
        maximum aileron increment, of full travel
    %(T)s
    %(reference)s

    Inputs
    ------
    phi, p
        roll angle in deg, roll rate in deg/s
    phi_ref
        deg, added to the parameter
    %(ail_off)s
    %(vc)s

    Outputs
    -------
    aileron
        increment of the aileron command; positive rolls right
    phi_cmd
        reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = "c172p"
    phi_ref: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)

    measured = ("phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = {"phi": 0, "p": 1, "phi_ref": 2, "off": 3, "ail_sat": 4, "vc": 5}
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    START = ReferenceLoop.START

    def build(self) -> None:
        (gains,) = self.gains_of("roll")
        T, authority = self.clock.period, self._checked.authority
        self.roll = attitude_loop(T, gains, authority, carry=self.scheduled)
        self.follows(roll=self.roll)

    def law(self, u: list[float], state: ReferenceState) -> tuple[list[float], ReferenceState]:
        phi, p, phi_ref, off, ail_sat, vc = u[:6]
        self.retune(vc)
        target, keeps = self.roll.towards(state, phi, self.wanted("phi_ref", phi_ref))
        aileron, phi_cmd, state = self.roll.sample(
            state, phi, p, target, keeps, ail_sat, off != 0.0
        )
        return [aileron, phi_cmd], state


@fill
@dataclass(eq=False, repr=False)
class HeadingHold(Hold):
    """Holds the heading with the ailerons; turns through the smaller angle, also across north.

    .. math::
        e &= \\mathrm{wrap}(\\psi_\\mathrm{ref} - \\psi) \\\\
        \\phi_\\mathrm{cmd} &= \\phi_0 + K_p e + K_i \\int e \\, dt, \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the roll loop of ``RollHold`` inside, sampled at T. Engaged in a turn, it levels the wings
    and returns to the heading at engagement.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"heading": ..., "roll": ...}, each either the name of
        a table or numbers; heading: Kp (deg/deg), Ki (1/s), bank (phi_0, the bank of straight
        flight, deg); roll: as in ``RollHold``
    psi_ref : float, optional
        heading to hold in deg; default: the value at engagement
    %(bank)s
    %(T)s
    %(reference)s

    Inputs
    ------
    psi, phi, p
        heading and roll angle in deg, roll rate in deg/s
    psi_ref
        deg, added to the parameter
    %(ail_off)s
    %(vc)s
    vt
        true airspeed in ft/s, to estimate the bank of straight flight that the aircraft needs, for
        example after an engine failure; if not connected (0), it is that of the gains

    Outputs
    -------
    %(aileron)s

    %(raises)s
    """

    gains: Gains = "c172p"
    psi_ref: float | None = parameter(None, optional, of=heading)
    bank_max: float = parameter(25.0, number, above=0.0, high=80.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)

    measured = ("psi", "phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = numbered("psi phi p psi_ref off ail_sat vc vt")
    output_port_labels = {"aileron": 0, "phi_cmd": 1}

    START = LateralState()

    def build(self) -> None:
        self.heading, self.roll = self.lateral_loops()

    def law(self, u: list[float], state: LateralState) -> tuple[list[float], LateralState]:
        psi, phi, p, psi_ref, off, ail_sat, vc, vt = u[:8]
        self.retune(vc)
        idle, reference = off != 0.0, self.wanted("psi_ref", psi_ref)
        bank, heading = self.heading.sample(state.heading, psi, reference, idle, phi, vt)
        aileron, phi_cmd, roll = self.roll.sample(state.roll, phi, p, bank, False, ail_sat, idle)
        return [aileron, phi_cmd], LateralState(heading, roll)


@fill
@dataclass(eq=False, repr=False)
class YawDamper(Hold):
    """Damps the Dutch roll with the rudder and keeps the sideslip at 0.

    .. math::
        \\delta_r &= K \\, \\frac{\\tau s}{1 + \\tau s} \\, r
        - K_p \\beta - K_i \\int \\beta \\, dt \\\\
        &\\quad + K_\\mathrm{roll} \\, p + K_\\mathrm{bank} \\frac{180}{\\pi} \\sin \\phi

    sampled at T. The wash-out leaves steady turns unopposed. With the ports ``beta``, ``p`` and
    ``phi`` connected, turns are coordinated: the last two act before any sideslip has built up. The
    integral holds the rudder required by an engine failure.

    Parameters
    ----------
    gains : str, YawGains or dict
        name of a gain table ("c172p"; in "737" and "global5000", whose models have their own
        damper, K is 0), or numbers: K (s/deg), tau (s), Kp (1/deg), Ki (1/(deg s)), Kroll (s/deg),
        Kbank (1/deg, of the sine of the bank times 57.3); K, Kp and Ki are positive if positive
        rudder yaws the nose left
    authority : float or pair
        maximum rudder increment, of full travel
    %(T)s

    Inputs
    ------
    r
        yaw rate in deg/s
    off
        0 engaged; otherwise the rudder increment decays to 0 with tau
    beta
        angle of sideslip in deg; if not connected (0), the sideslip of an engine failure remains
    %(vc)s
    p, phi
        roll rate in deg/s, bank in deg; if not connected (0), they are not fed forward

    Outputs
    -------
    rudder
        increment of the rudder command; positive yaws the nose left on most models

    %(raises)s
    """

    gains: Gains = "c172p"
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)

    measured = ("r",)
    commands = {"rudder": "off"}
    input_port_labels = {"r": 0, "off": 1, "beta": 2, "vc": 3, "p": 4, "phi": 5}
    output_port_labels = {"rudder": 0}

    START = YawLoop.START

    def build(self) -> None:
        (gains,) = self.gains_of("yaw")
        self.yaw = YawLoop(self.clock.period, gains, self._checked.authority)
        self.follows(yaw=self.yaw)

    def law(self, u: list[float], state: YawState) -> tuple[list[float], YawState]:
        r, off, beta, vc, p, phi = u[:6]
        self.retune(vc)
        rudder, state = self.yaw.sample(state, r, off != 0.0, self.sensed("beta", beta), p, phi)
        return [rudder], state
