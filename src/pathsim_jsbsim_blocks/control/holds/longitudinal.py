"""Holds that act on the elevator and the throttle: pitch, altitude, climb, airspeed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ..._core.checks import number, optional, positive
from ..._core.parameters import parameter
from ..._core.ports import numbered
from ..channels import ClimbState, Motion, Vertical, VerticalState
from ..controller import Authority, Hold, authority_limits, fill, reference_kind
from ..gains import Gains
from ..loops import (
    ReferenceLoop,
    ReferenceState,
    SpeedLoop,
    SpeedOnPitchLoop,
    attitude_loop,
)

__all__ = [
    "AirspeedHold",
    "AltitudeHold",
    "PitchHold",
    "SpeedOnPitchHold",
    "VerticalSpeedHold",
]


@fill
@dataclass(eq=False, repr=False)
class PitchHold(Hold):
    """Holds the pitch angle with the elevator.

    .. math::
        \\delta_e = -\\left[K_p (b \\, \\theta_\\mathrm{cmd} - \\theta)
        + K_i \\int (\\theta_\\mathrm{cmd} - \\theta) \\, dt - K_r q\\right]

    sampled at T. The reference theta_cmd starts at the pitch angle found at engagement and moves to
    ``theta_ref`` (parameter plus port) no faster than the gain table's ramp, so engagement is
    bumpless.

    Parameters
    ----------
    gains : str, AttitudeGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/deg), Ki (1/(deg s)), Kr (s/deg), b,
        ramp (deg/s)
    theta_ref : float, optional
        pitch angle to hold in deg; default: the value at engagement
    authority : float or pair
        largest elevator increment, of full travel
    %(T)s
    %(reference)s

    Inputs
    ------
    theta, q
        pitch angle in deg, pitch rate in deg/s
    theta_ref
        deg, added to the parameter
    %(elev_off)s
    %(vc)s

    Outputs
    -------
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        reference on its ramp, deg

    %(raises)s
    """

    gains: Gains = "c172p"
    theta_ref: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = {"theta": 0, "q": 1, "theta_ref": 2, "off": 3, "elev_sat": 4, "vc": 5}
    output_port_labels = {"elevator": 0, "theta_cmd": 1}

    START = ReferenceLoop.START

    def build(self) -> None:
        (gains,) = self.gains_of("pitch")
        T, authority = self.clock.period, self.checked.authority
        self.pitch = attitude_loop(T, gains, authority, -1.0, self.scheduled)
        self.follows(pitch=self.pitch)

    def law(self, u: list[float], state: ReferenceState) -> tuple[list[float], ReferenceState]:
        theta, q, theta_ref, off, elev_sat, vc = u[:6]
        self.retune(vc)
        wanted, keeps = self.pitch.towards(state, theta, self.wanted("theta_ref", theta_ref))
        elevator, theta_cmd, state = self.pitch.sample(
            state, theta, q, wanted, keeps, elev_sat, off != 0.0
        )
        return [elevator, theta_cmd], state


@fill
@dataclass(eq=False, repr=False)
class AltitudeHold(Hold):
    """Holds the altitude with the elevator, through rate-of-climb and pitch loops.

    .. math::
        \\dot h_\\mathrm{cmd} &= K_h (h_\\mathrm{ref} - h), \\quad
        |\\dot h_\\mathrm{cmd}| \\le \\dot h_\\mathrm{max} \\\\
        \\theta_\\mathrm{cmd} &= K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. It flies climbs and descents with the
    elevator alone: add an ``AirspeedHold`` for the airspeed. With the port ``alpha`` wired it keeps
    the angle of attack below its limit, and with ``vc`` the airspeed above its lowest: a climb that
    the thrust does not sustain is reduced, and becomes a descent. Without these wires it climbs
    into the stall.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"altitude": ..., "pitch": ...}, each either the name
        of a table or numbers; altitude: Kh (1/s), Kp (deg/(ft/s)), Ki (deg/ft), hdot_max (ft/s),
        theta_max (deg); pitch: as in ``PitchHold``
    h_ref : float, optional
        altitude to hold in ft; default: the value at engagement
    hdot_max : float, optional
        largest rate of climb and descent demanded, ft/s; default is the gain table's
    %(climb)s
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    %(level)s
    h_ref
        ft, added to the parameter
    %(elev_off)s
    vc
        calibrated airspeed in kt, for gains that depend on it, and for the protection; without a
        wire (0) the gains are those of the table's nominal point, and the protection limits neither
        the airspeed nor the load factor
    alpha
        angle of attack in deg; without a wire (0) there is no protection from the stall

    Outputs
    -------
    %(elevator)s
    hdot_cmd
        rate of climb demanded, ft/s

    %(raises)s
    """

    gains: Gains = "c172p"
    h_ref: float | None = parameter(None, optional)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)

    measured = ("h", "hdot", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered("h hdot theta q h_ref off elev_sat vc alpha")
    output_port_labels = {"elevator": 0, "theta_cmd": 1, "hdot_cmd": 2}

    START = Vertical.START

    def build(self) -> None:
        self.vertical = self.vertical_loops(*self.gains_of("altitude", "pitch", "envelope"))

    def law(self, u: list[float], state: VerticalState) -> tuple[list[float], VerticalState]:
        h, hdot, theta, q, h_ref, off, elev_sat, vc, alpha = u[:9]
        self.retune(vc, h)
        vertical, idle = self.vertical, off != 0.0
        now = Motion(theta, q, h, hdot, vc, alpha, idle, elev_sat)
        allowed, guard = vertical.guard(state, now, vc, True)
        reference = self.wanted("h_ref", h_ref, h)
        wanted, hdot_cmd, altitude, _ = vertical.for_climb(
            *(state, now, allowed, ClimbState(), 0.0), (None, 0.0), reference, idle
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(state, now, allowed, wanted)
        return [elevator, theta_cmd, hdot_cmd], VerticalState(altitude, pitch, guard, cut)


class ClimbingState(NamedTuple):
    """State of a hold that climbs to an altitude."""

    vertical: VerticalState = Vertical.START
    climb: ClimbState = ClimbState()
    speed: ReferenceState = SpeedOnPitchLoop.START


@fill
@dataclass(eq=False, repr=False)
class VerticalSpeedHold(Hold):
    """Holds the rate of climb with the elevator, until it captures an altitude.

    .. math::
        \\theta_\\mathrm{cmd} = K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. An altitude that is demanded, and
    towards which the rate of climb leads, is captured where the law of ``AltitudeHold`` asks for
    no more than that rate, and is held from then on. The protection is that of ``AltitudeHold``.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold``
    hdot_ref : float, optional
        rate of climb to hold, ft/s; default: the value at engagement
    %(capture)s
    %(climb)s
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    %(level)s
    hdot_ref, h_ref
        added to the parameters, ft/s and ft
    %(elev_off)s
    vc, alpha
        as in ``AltitudeHold``

    Outputs
    -------
    %(elevator)s
    %(climbing)s

    %(raises)s
    """

    gains: Gains = "c172p"
    hdot_ref: float | None = parameter(None, optional)
    h_ref: float | None = parameter(None, optional)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)

    measured = ("h", "hdot", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered("h hdot theta q hdot_ref h_ref off elev_sat vc alpha")
    output_port_labels = numbered("elevator theta_cmd hdot_cmd captured")

    START = ClimbingState()

    def build(self) -> None:
        self.vertical = self.vertical_loops(*self.gains_of("altitude", "pitch", "envelope"))

    def law(self, u: list[float], state: ClimbingState) -> tuple[list[float], ClimbingState]:
        h, hdot, theta, q, hdot_ref, h_ref, off, elev_sat, vc, alpha = u[:10]
        self.retune(vc, h)
        vertical, idle = self.vertical, off != 0.0
        now = Motion(theta, q, h, hdot, vc, alpha, idle, elev_sat)
        before = state.vertical
        allowed, guard = vertical.guard(before, now, vc, True)
        asked, reference = self.wanted("hdot_ref", hdot_ref), self.wanted("h_ref", h_ref, h)
        wanted, hdot_cmd, altitude, climb = vertical.for_climb(
            before, now, allowed, state.climb, 1.0, asked, reference, idle
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(before, now, allowed, wanted)
        outputs = [elevator, theta_cmd, hdot_cmd, float(climb.captured)]
        return outputs, ClimbingState(VerticalState(altitude, pitch, guard, cut), climb)


@fill
@dataclass(eq=False, repr=False)
class SpeedOnPitchHold(Hold):
    """Holds the airspeed with the elevator, at any throttle, until it captures an altitude.

    .. math::
        \\dot h_\\mathrm{cmd} = \\dot h_0 - \\frac{V}{g} \\left[2 \\zeta \\omega e
        + \\omega^2 \\int e \\, dt\\right], \\quad e = V_\\mathrm{cmd} - V

    with the loops of ``VerticalSpeedHold`` inside, sampled at T. The throttle sets whether the
    aircraft climbs or descends, and how fast: full throttle climbs at the airspeed, idle descends.
    The frequency omega is 0.15 rad/s, the damping zeta 0.9. An altitude on the way is captured as
    by ``VerticalSpeedHold``; let an ``AirspeedHold`` take over the throttle there.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold``, with those of ``AirspeedHold`` as "speed", whose ramp is used
    vc_ref : float, optional
        airspeed to hold, KCAS; default: the value at engagement
    %(capture)s
    %(climb)s
    %(T)s
    %(reference)s
    %(alpha_max)s

    Inputs
    ------
    vc
        calibrated airspeed in kt
    %(level)s
    vc_ref, h_ref
        added to the parameters, kt and ft
    %(elev_off)s
    alpha
        as in ``AltitudeHold``

    Outputs
    -------
    %(elevator)s
    %(climbing)s
    vc_cmd
        airspeed demanded on its ramp, kt

    %(raises)s
    """

    gains: Gains = "c172p"
    vc_ref: float | None = parameter(None, optional, above=0.0)
    h_ref: float | None = parameter(None, optional)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)

    measured = ("vc", "h", "hdot", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered("vc h hdot theta q vc_ref h_ref off elev_sat alpha")
    output_port_labels = numbered("elevator theta_cmd hdot_cmd captured vc_cmd")

    START = ClimbingState()

    def build(self) -> None:
        *gains, speed = self.gains_of("altitude", "pitch", "envelope", "speed")
        self.vertical = self.vertical_loops(*gains)
        altitude = self.vertical.altitude
        self.speed = SpeedOnPitchLoop(
            self.clock.period, speed.ramp, altitude.pid.low, altitude.theta_max
        )

    def law(self, u: list[float], state: ClimbingState) -> tuple[list[float], ClimbingState]:
        vc, h, hdot, theta, q, vc_ref, h_ref, off, elev_sat, alpha = u[:10]
        self.retune(vc, h)
        vertical, idle = self.vertical, off != 0.0
        now = Motion(theta, q, h, hdot, vc, alpha, idle, elev_sat)
        before = state.vertical
        allowed, guard = vertical.guard(before, now, vc, True)
        wanted, keeps = self.speed.loop.towards(state.speed, vc, self.wanted("vc_ref", vc_ref, vc))
        wanted = self.airspeed_within(allowed, wanted, vc)
        off = idle or state.climb.captured
        rate, vc_cmd, speed = self.speed.sample(
            state.speed, vc, h, hdot, wanted, keeps, before.altitude.cut, off
        )
        reference = self.wanted("h_ref", h_ref, h)
        wanted, hdot_cmd, altitude, climb = vertical.for_climb(
            before, now, allowed, state.climb, 1.0, (rate, 0.0), reference, idle
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(before, now, allowed, wanted)
        outputs = [elevator, theta_cmd, hdot_cmd, float(climb.captured), vc_cmd]
        return outputs, ClimbingState(VerticalState(altitude, pitch, guard, cut), climb, speed)


@fill
@dataclass(eq=False, repr=False)
class AirspeedHold(Hold):
    """Holds the calibrated airspeed with the throttle (autothrottle).

    .. math::
        \\delta_t = K_p (b V_\\mathrm{cmd} - V') + K_i \\int (V_\\mathrm{cmd} - V') \\, dt
        - K_d \\dot V' + K_c \\dot h

    sampled at T. The reference V_cmd starts at the airspeed found at engagement and moves to
    ``vc_ref`` (parameter plus port) no faster than the gain table's ramp. With the rate of climb
    connected, the extra throttle for a climb is fed forward. V' is the airspeed within the gain
    table's band about the reference; beyond, each further knot of error counts as 0.2 kt, so that
    gusts do not move the throttle from stop to stop.

    Parameters
    ----------
    gains : str, SpeedGains or dict
        name of a gain table ("c172p"), or numbers: Kp (1/kt), Ki (1/(kt s)), Kd (s/kt), Tf (s),
        b, ramp (kt/s), Kc (s/ft), band (kt)
    vc_ref : float, optional
        airspeed to hold, KCAS; default: the value at engagement
    authority : float or pair
        largest throttle increment, of full range
    %(T)s
    %(reference)s

    Inputs
    ------
    vc
        calibrated airspeed in kt
    hdot
        rate of climb in ft/s, fed forward
    vc_ref
        kt, added to the parameter
    off
        0 engaged; otherwise the throttle is frozen
    thr_sat
        ``Aircraft`` output of that name, for anti-windup at idle and full throttle

    Outputs
    -------
    throttle
        increment of the throttle command of every engine
    vc_cmd
        reference on its ramp, kt

    %(raises)s
    """

    gains: Gains = "c172p"
    vc_ref: float | None = parameter(None, optional, above=0.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: str = parameter("increment", reference_kind)

    measured = ("vc", "hdot")
    commands = {"throttle": "off"}
    input_port_labels = {"vc": 0, "hdot": 1, "vc_ref": 2, "off": 3, "thr_sat": 4}
    output_port_labels = {"throttle": 0, "vc_cmd": 1}

    START = SpeedLoop.START

    def build(self) -> None:
        (gains,) = self.gains_of("speed")
        self.speed = SpeedLoop(self.clock.period, gains, self.checked.authority, self.scheduled)
        self.follows(speed=self.speed)

    def law(self, u: list[float], state: ReferenceState) -> tuple[list[float], ReferenceState]:
        vc, hdot, vc_ref, off, thr_sat = u[:5]
        self.retune(vc)
        wanted, keeps = self.speed.loop.towards(state, vc, self.wanted("vc_ref", vc_ref, vc))
        throttle, vc_cmd, state = self.speed.sample(
            state, vc, hdot, wanted, keeps, thr_sat, off != 0.0
        )
        return [throttle, vc_cmd], state
