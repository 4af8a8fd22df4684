"""Holds of the altitude, the rate of climb, and the airspeed in a climb, with the elevator."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .._core.checks import number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from ..control.controller import Authority, ReferenceKind, authority_limits, reference_kind
from ..control.gains import Gains
from ..control.loops import ReferenceState
from .climb_loops import SpeedOnPitchLoop
from .hold import GuidedHold, fill
from .vertical import ClimbState, Motion, Vertical, VerticalState

__all__ = ["AltitudeHold", "SpeedOnPitchHold", "VerticalSpeedHold"]


@fill
@dataclass(eq=False, repr=False)
class AltitudeHold(GuidedHold):
    """Holds the altitude with the elevator, through rate-of-climb and pitch loops.

    .. math::
        \\dot h_\\mathrm{cmd} &= K_h (h_\\mathrm{ref} - h), \\quad
        |\\dot h_\\mathrm{cmd}| \\le \\dot h_\\mathrm{max} \\\\
        \\theta_\\mathrm{cmd} &= K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. It flies climbs and descents with the
    elevator alone: add an ``AirspeedHold`` for the airspeed. With ``alpha`` connected the angle of
    attack stays below its maximum, and with ``vc`` the airspeed above its minimum: a climb that the
    thrust cannot sustain is reduced or becomes a descent. Without these connections the aircraft
    may climb into a stall.

    Parameters
    ----------
    gains : str or dict
        name of a gain table ("c172p"), or {"altitude": ..., "pitch": ...}, each either the name
        of a table or numbers; altitude: Kh (1/s), Kp (deg/(ft/s)), Ki (deg/ft), hdot_max (ft/s),
        theta_max (deg); pitch: as in ``PitchHold``
    h_ref : float, optional
        altitude to hold in ft; default: the value at engagement
    hdot_max : float, optional
        maximum commanded rate of climb and descent, ft/s; default is the gain table's
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
        calibrated airspeed in kt, for gains that depend on it, and for the protection; if not
        connected (0), the gains are those of the table's nominal point, and the protection limits
        neither the airspeed nor the load factor
    alpha
        angle of attack in deg; if not connected (0), there is no stall protection

    Outputs
    -------
    %(elevator)s
    hdot_cmd
        commanded rate of climb, ft/s

    %(raises)s
    """

    gains: Gains = "c172p"
    h_ref: float | None = parameter(None, optional)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)
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
        allowed, guard = vertical.guard(state, now, vc, full_throttle=True)
        reference = self.wanted("h_ref", h_ref, h)
        target, hdot_cmd, altitude, _ = vertical.for_climb(
            state, now, allowed, reference=reference, idle=idle
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(state, now, allowed, target)
        return [elevator, theta_cmd, hdot_cmd], VerticalState(altitude, pitch, guard, cut)


class ClimbingState(NamedTuple):
    """State of a hold that climbs to an altitude."""

    vertical: VerticalState = Vertical.START
    climb: ClimbState = ClimbState()
    speed: ReferenceState = SpeedOnPitchLoop.START


@fill
@dataclass(eq=False, repr=False)
class VerticalSpeedHold(GuidedHold):
    """Holds the rate of climb with the elevator, until it captures an altitude.

    .. math::
        \\theta_\\mathrm{cmd} = K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt

    with the pitch loop of ``PitchHold`` inside, sampled at T. A commanded altitude towards which
    the rate of climb leads is captured once the law of ``AltitudeHold`` commands no more than that
    rate, and is held from then on. The protection is that of ``AltitudeHold``.

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
    reference: ReferenceKind = parameter("increment", reference_kind)
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
        allowed, guard = vertical.guard(before, now, vc, full_throttle=True)
        rate, reference = self.wanted("hdot_ref", hdot_ref), self.wanted("h_ref", h_ref, h)
        target, hdot_cmd, altitude, climb = vertical.for_climb(
            before,
            now,
            allowed,
            reference=reference,
            idle=idle,
            before=state.climb,
            mode=1.0,
            rate=rate,
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(before, now, allowed, target)
        outputs = [elevator, theta_cmd, hdot_cmd, float(climb.captured)]
        return outputs, ClimbingState(VerticalState(altitude, pitch, guard, cut), climb)


@fill
@dataclass(eq=False, repr=False)
class SpeedOnPitchHold(GuidedHold):
    """Holds the airspeed with the elevator, at any throttle, until it captures an altitude.

    .. math::
        \\dot h_\\mathrm{cmd} = \\dot h_0 - \\frac{V}{g} \\left[2 \\zeta \\omega e
        + \\omega^2 \\int e \\, dt\\right], \\quad e = V_\\mathrm{cmd} - V

    with the loops of ``VerticalSpeedHold`` inside, sampled at T. The throttle sets whether the
    aircraft climbs or descends, and how fast: full throttle climbs at the airspeed, idle descends.
    The frequency omega is 0.15 rad/s, the damping ratio zeta 0.9. An altitude is captured as by
    ``VerticalSpeedHold``; switch the throttle to an ``AirspeedHold`` then.

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
        airspeed reference on its ramp, kt

    %(raises)s
    """

    gains: Gains = "c172p"
    vc_ref: float | None = parameter(None, optional, above=0.0)
    h_ref: float | None = parameter(None, optional)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    reference: ReferenceKind = parameter("increment", reference_kind)
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
        allowed, guard = vertical.guard(before, now, vc, full_throttle=True)
        target, keeps = self.speed.loop.towards(state.speed, vc, self.wanted("vc_ref", vc_ref, vc))
        target = self.airspeed_within(allowed, target, vc)
        off = idle or state.climb.captured
        rate, vc_cmd, speed = self.speed.sample(
            state.speed, vc, h, hdot, target, keeps, before.altitude.cut, off
        )
        reference = self.wanted("h_ref", h_ref, h)
        target, hdot_cmd, altitude, climb = vertical.for_climb(
            before,
            now,
            allowed,
            reference=reference,
            idle=idle,
            before=state.climb,
            mode=1.0,
            rate=(rate, 0.0),
        )
        elevator, theta_cmd, pitch, cut = vertical.fly(before, now, allowed, target)
        outputs = [elevator, theta_cmd, hdot_cmd, float(climb.captured), vc_cmd]
        return outputs, ClimbingState(VerticalState(altitude, pitch, guard, cut), climb, speed)
