"""Holds of an approach: course of a localizer, and glide path."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from .._core.checks import flag, heading, number, optional, positive
from .._core.parameters import parameter
from .._core.ports import numbered
from ..axes.navigation import distance, latitude_longitude, place
from ..control.controller import Authority, Hold, authority_limits
from ..control.gains import Gains
from ..control.loops import DEGREES, LateralState, wrap
from ..control.pid import clip
from .course import SEPARATION, SMOOTHING
from .hold import GuidedHold, fill
from .receivers import above_path
from .vertical import Motion, VerticalState

__all__ = ["GlideslopeHold", "LocalizerHold"]

SLOWEST = 30.0  # minimum speed as a divisor, ft/s
_FASTEST = 5000.0  # ft/s; a greater speed means that the receiver was tuned to another station
_AWAY = 135.0  # heading off the course beyond which the aircraft flies away, deg
_ON_COURSE = 5.0  # intercept angle that counts as on the course line, deg
_ON_GLIDE_PATH = 0.35  # deviation in deg: half of full scale on an ILS indicator
# height above the threshold below which the sink rate is limited, ft, and its maximum over the
# path's: a steep sink would begin the flare too fast
_LOW, _STEEPER = 300.0, 1.2


class BeamState(NamedTuple):
    """Motion relative to a localizer's course."""

    valid: bool = False
    ft: float = 0.0
    dist: float = 0.0
    aside: float = 0.0  # speed to the right of the course, ft/s, smoothed
    closure: float = 0.0  # speed towards the station, ft/s, smoothed

    def next(
        self, ft: float, dist: float, T: float, smoothing: float
    ) -> tuple[BeamState, float, float, bool]:
        """The next state, the measured speeds across and along the course, ft/s, and validity."""
        slip, closure = (ft - self.ft) / T, (self.dist - dist) / T
        if not self.valid or abs(closure) >= _FASTEST:
            return BeamState(True, ft, dist), slip, closure, False
        gain = -math.expm1(-T / smoothing) if self.closure else 1.0
        aside = self.aside + gain * (slip - self.aside)
        smooth = self.closure + gain * (closure - self.closure)
        return BeamState(True, ft, dist, aside, smooth), slip, closure, True


class LocalizerState(NamedTuple):
    """State of a `LocalizerHold`."""

    lateral: LateralState = LateralState()
    beam: BeamState = BeamState()
    drift: float = 0.0  # deg, smoothed
    heading: float = 0.0  # heading at engagement, deg
    captured: bool = False


@fill
@dataclass(eq=False, repr=False)
class LocalizerHold(Hold):
    """Captures the course of a localizer with the ailerons, and follows it.

    .. math::
        \\chi_\\mathrm{cmd} &= \\chi_\\mathrm{loc} - \\arctan\\frac{d}{\\tau V_g}, \\quad
        e = \\mathrm{wrap}(\\chi_\\mathrm{cmd} - \\chi) \\\\
        \\phi_\\mathrm{cmd} &= K_p e + K_i \\int e \\, dt, \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the distance d from the course line, the ground speed V_g and the course over the ground
    chi, which follow from the receiver's outputs, and the roll loop of ``RollHold`` inside, sampled
    at T. Until the capture it holds the heading at engagement. It captures when the law above would
    not turn further towards the course line, or would intercept it at less than 5 deg, but not on a
    heading away from the station, more than 135 deg off the course. The measured drift angle
    corrects for wind.

    Parameters
    ----------
    gains : str or dict
        as in ``HeadingHold``
    course : float
        true course of the localizer, deg
    lookahead : float, optional
        time constant tau of the distance in s; default 3.5 times that of the heading loop,
        V_g / (g Kp)
    intercept : float
        maximum intercept angle of the course line, deg
    %(bank)s
    %(T)s

    Inputs
    ------
    psi, phi, p
        true heading and roll angle in deg, roll rate in deg/s
    loc_ft, loc_dist
        outputs ``ft`` and ``dist`` of a ``Localizer``
    %(ail_off)s
    %(vc)s

    Outputs
    -------
    %(aileron)s
    chi_cmd
        commanded course, deg, [0, 360)
    captured
        1 from the capture on, otherwise 0

    %(raises)s
    """

    gains: Gains = "c172p"
    course: float = parameter(0.0, heading)
    lookahead: float | None = parameter(None, optional, above=0.0)
    intercept: float = parameter(45.0, number, above=0.0, high=80.0)
    bank_max: float = parameter(25.0, number, above=0.0, high=80.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)

    measured = ("psi", "phi", "p", "loc_ft", "loc_dist")
    commands = {"aileron": "off"}
    input_port_labels = numbered("psi phi p loc_ft loc_dist off ail_sat vc")
    output_port_labels = numbered("aileron phi_cmd chi_cmd captured")

    START = LocalizerState()

    def build(self) -> None:
        self.heading, self.roll = self.lateral_loops()
        self._gain = -math.expm1(-self.clock.period / SMOOTHING)

    def law(self, u: list[float], state: LocalizerState) -> tuple[list[float], LocalizerState]:
        psi, phi, p, ft, dist, off, ail_sat, vc = u[:8]
        self.retune(vc)
        idle, c = off != 0.0, self._checked
        beam, slip, towards, valid = state.beam.next(ft, dist, self.clock.period, SMOOTHING)
        drift = 0.0
        if valid:
            drift = wrap(c.course + DEGREES * math.atan(slip / max(towards, SLOWEST)) - psi)
            gain = self._gain if state.beam.closure else 1.0
            drift = wrap(state.drift + gain * wrap(drift - state.drift))
        chi = psi + drift
        speed = max(beam.closure, SLOWEST)
        tau = c.lookahead
        if tau is None:
            tau = max(SEPARATION * self.heading.lag(speed), 1.0)
        closing = clip(DEGREES * math.atan(ft / (tau * speed)), -c.intercept, c.intercept)
        angle = wrap(chi - c.course)
        turns_in = angle <= -closing if ft > 0.0 else angle >= -closing
        turns_in = (turns_in or abs(closing) < _ON_COURSE) and abs(wrap(psi - c.course)) < _AWAY
        captured = not idle and (state.captured or (valid and turns_in))

        initial = state.heading if state.lateral.heading.law.engaged else psi
        measured, target = (chi, c.course - closing) if captured else (psi, initial)
        bank, heading = self.heading.sample(state.lateral.heading, measured, (target, 0.0), idle)
        aileron, phi_cmd, roll = self.roll.sample(
            state.lateral.roll, phi, p, bank, False, ail_sat, idle
        )
        outputs = [aileron, phi_cmd, target % 360.0, float(captured)]
        lateral = LateralState(heading, roll)
        return outputs, LocalizerState(lateral, beam, drift, initial, captured)


class GlideslopeState(NamedTuple):
    """State of a `GlideslopeHold`; fields are None until they are computed."""

    dist: float | None = None  # ft
    speed: float | None = None  # closing speed, ft/s, smoothed
    captured: bool = False
    vertical: VerticalState = VerticalState()


@fill
@dataclass(eq=False, repr=False)
class GlideslopeHold(GuidedHold):
    """Follows a glide path down to a runway with the elevator; captures it from below or above.

    .. math::
        \\dot h_\\mathrm{cmd} &= -V_c \\tan\\gamma - K_h \\, \\Delta h \\\\
        \\theta_\\mathrm{cmd} &= K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt \\\\
        \\theta_\\mathrm{min} &\\le \\theta_\\mathrm{cmd} \\le \\theta_\\mathrm{max}

    with the height Delta h above the path, the closing speed V_c on the threshold, and the pitch
    loop of ``PitchHold`` inside, sampled at T. The path is a straight line at the angle gamma to
    the ground at the runway, which passes above the threshold; the Earth's surface curves away
    below it. Until the capture, the altitude at engagement is held. The path is captured on the way
    to the threshold when it commands a lower rate of climb than the altitude does and, unless
    ``from_above`` is set, at most 0.35 deg above the path. For the flare, connect a ``FlareHold``
    after it. With ``alpha`` and ``vc`` connected the angle of attack stays below its maximum and
    the airspeed above its minimum: a path that the thrust cannot sustain is left, with the nose
    down and ``captured`` 0. Below 300 ft above the threshold the commanded sink rate is at most 1.2
    times the path's, and at most ``sink_max``.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold``
    threshold : (float, float)
        geodetic latitude and longitude of the runway's threshold, deg
    elevation : float
        elevation of the threshold above sea level, ft
    angle : float
        glide path angle gamma in [0.1, 20], deg
    crossing_height : float
        height of the path above the threshold, ft
    hdot_max : float, optional
        maximum downward correction of the rate of climb, ft/s; upwards it may be as large as the
        path's own rate of descent; default is the gain table's
    %(climb)s
    %(T)s
    %(alpha_max)s
    from_above : bool
        capture the path from above too, at any height, with a sink rate ``hdot_max`` above the
        path's
    sink_max : float
        maximum sink rate below 300 ft, ft/s: that of the ``FlareHold`` after it

    Inputs
    ------
    h, hdot
        altitude in ft, rate of climb in ft/s
    lat, lon
        geodetic latitude and longitude in deg
    theta, q
        pitch angle in deg, pitch rate in deg/s
    %(elev_off)s
    %(vc)s
    alpha
        angle of attack in deg; if not connected (0), there is no stall protection. The load factor
        is limited only with ``vc`` connected
    gs_deg, gs_ft, gs_dist
        outputs of a ``Glideslope`` receiver, whose angle is ``angle``. If ``gs_dist`` is connected,
        they replace ``lat``, ``lon``, ``threshold``, ``elevation`` and ``crossing_height``

    Outputs
    -------
    %(elevator)s
    hdot_cmd
        commanded rate of climb, ft/s; 0 while off
    gs_deg
        angular deviation at the path's foot, deg, positive above the path
    gs_ft
        height above the path, ft
    dist
        distance to the threshold (with a receiver, to its station) in ft, negative beyond it once
        the path is captured
    captured
        1 from the capture on, 0 before it and when the path is left

    %(raises)s
    """

    gains: Gains = "c172p"
    threshold: tuple[float, float] = parameter((0.0, 0.0), latitude_longitude)
    elevation: float = parameter(0.0, number)
    angle: float = parameter(3.0, number, above=0.0, low=0.1, high=20.0)
    crossing_height: float = parameter(50.0, number, low=0.0, high=1e4)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number, low=-90.0, high=90.0)
    theta_max: float | None = parameter(None, optional, low=-90.0, high=90.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    alpha_max: float | None = parameter(None, optional, above=0.0, high=90.0)
    from_above: bool = parameter(False, flag)
    sink_max: float = parameter(math.inf, number, above=0.0, infinite=True)

    measured = ("h", "hdot", "lat", "lon", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered(
        "h hdot lat lon theta q off elev_sat vc alpha gs_deg gs_ft gs_dist"
    )
    output_port_labels = numbered("elevator theta_cmd hdot_cmd gs_deg gs_ft dist captured")

    START = GlideslopeState()

    def build(self) -> None:
        c = self._checked
        self._threshold = place(*c.threshold)
        self._slope = math.tan(math.radians(c.angle))
        self._foot = c.crossing_height / self._slope
        self.vertical = self.vertical_loops(*self.gains_of("altitude", "pitch", "envelope"))
        self._gain = -math.expm1(-self.clock.period / SMOOTHING)

    def law(self, u: list[float], state: GlideslopeState) -> tuple[list[float], GlideslopeState]:
        h, hdot, lat, lon, theta, q, off, elev_sat, vc, alpha, degrees, ft, slant = u[:13]
        self.retune(vc, h)
        receiver = "gs_dist" in self.inputs.wired
        if not receiver:
            slant = distance(place(lat, lon), self._threshold)
        speed, rate = state.speed, 0.0
        if state.dist is not None:
            rate = (state.dist - slant) / self.clock.period
            if abs(rate) > _FASTEST:
                speed = None
            else:
                speed = abs(rate) if speed is None else speed + self._gain * (abs(rate) - speed)
        dist = -slant if state.captured and rate < 0.0 else slant
        if receiver:
            height = ft + dist * self._slope
        else:
            height = h - self._checked.elevation
            degrees, ft = above_path(height, dist + self._foot, self._checked.angle)

        vertical, loops, idle = self.vertical, state.vertical, off != 0.0
        motion = Motion(theta, q, h, hdot, vc, self.sensed("alpha", alpha), idle, elev_sat)
        bounds, guard = vertical.guard(loops, motion, vc, full_throttle=True)
        initial, error = vertical.altitude.error(loops.altitude, h, (None, 0.0))
        level = vertical.altitude.climb_rate(error)
        descent, lower = self._descent(ft, speed or 0.0, level, height)
        # a rate of 0 means that the closing speed has not been measured yet
        meets = lower and rate > 0.0 and (self._checked.from_above or degrees <= _ON_GLIDE_PATH)
        # below a path that requires more thrust than available
        leaves = descent > bounds.climb_max and degrees < -_ON_GLIDE_PATH
        captured = not idle and (state.captured or meets)
        command = descent if captured else level
        target, hdot_cmd, altitude = vertical.at_rate(loops, motion, bounds, initial, command, idle)
        elevator, theta_cmd, pitch, cut = vertical.fly(loops, motion, bounds, target)
        return (
            [elevator, theta_cmd, hdot_cmd, degrees, ft, dist, float(captured and not leaves)],
            GlideslopeState(slant, speed, captured, VerticalState(altitude, pitch, guard, cut)),
        )

    def _descent(self, ft: float, speed: float, level: float, height: float) -> tuple[float, bool]:
        """Rate of climb that follows the path, ft/s, and whether it is at most ``level``."""
        altitude, sink = self.vertical.altitude, speed * self._slope
        # an upward correction limited to less than the sink could never fly level below the path
        highest = max(altitude.hdot_max, sink)
        correction = -altitude.Kh * ft
        rate = clip(correction, -altitude.hdot_max, highest) - sink
        if height < _LOW:
            rate = max(rate, -min(_STEEPER * sink, self._checked.sink_max))
        return rate, correction - sink <= level

    def _needed(self) -> tuple[str, ...]:
        # a receiver requires all three connections, and replaces the position
        receiver = "gs_deg", "gs_ft", "gs_dist"
        if self.inputs.wired.isdisjoint(receiver):
            return self.measured
        return (*(x for x in self.measured if x not in ("lat", "lon")), *receiver)
