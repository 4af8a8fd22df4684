"""Holds that follow a path over the ground: course, waypoints, glide slope."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, NamedTuple

from ..._core.checks import flag, number, one_of, optional, positive, refuse, whole
from ..._core.parameters import parameter
from ..._core.ports import numbered
from ..._core.units import GRAVITY
from ...axes.navigation import (
    Arc,
    GreatCircle,
    Place,
    Track,
    arc_about,
    beside,
    circle_through,
    distance,
    great_circle,
    motion,
    place_unchecked,
    point,
)
from ...errors import ParameterError
from ..channels import Lateral, Vertical
from ..controller import Authority, Hold, authority_limits, fill
from ..gains import Gains
from ..loops import AltitudeLoop, AltitudeState, Reference
from ..receivers import above_path
from ..signals import flat, larger, limit, select, wrap

# the package and PathView export these names
__all__ = ["CourseHold", "GlideslopeHold"]

SMOOTHING = 2.0  # s, time constant of drift angle and ground speed
# crossover of the heading loop over that of the loop around it; 4 would be critically damped
SEPARATION = 3.5
_SHARPEST = 120.0  # deg: turns beyond are not begun earlier than this one
_CAPTURE = 0.35  # deg above the glide path: half of full scale on an ILS indicator


class _Ground(NamedTuple):
    """Motion over the ground; the course is the heading plus a smoothed drift angle."""

    here: Place | None = None
    drift: float = 0.0
    speed: float = 0.0
    known: bool = False

    def next(self, here: Place, psi: float, share: float, T: float) -> _Ground:
        if self.here is None:
            return _Ground(here)
        north, east = motion(self.here, here)
        speed = math.hypot(north, east) / T
        if speed == 0.0:
            return self._replace(here=here)
        drift = wrap(math.degrees(math.atan2(east, north)) - psi)
        if not self.known:
            return _Ground(here, drift, speed, True)
        return _Ground(
            here,
            wrap(self.drift + share * wrap(drift - self.drift)),
            self.speed + share * (speed - self.speed),
            True,
        )


@fill
class CourseHold(Hold):
    """Holds the course over the ground, or flies along waypoints, with the ailerons.

    .. math::
        \\chi_\\mathrm{cmd} &= \\chi_\\mathrm{leg} - \\arctan\\frac{d}{\\tau V_g}, \\quad
        e = \\mathrm{wrap}(\\chi_\\mathrm{cmd} - \\chi) \\\\
        \\phi_\\mathrm{cmd} &= K_p e + K_i \\int e \\, dt, \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the cross-track error d, the ground speed V_g, the course over the ground chi, and the roll
    loop of ``RollHold`` inside, sampled at T. The ground track is measured, so that a wind is
    corrected for without being known.

    Leg 0 leads from the position found at engagement to the first waypoint, leg k from waypoint k
    to the next, along a great circle or an arc. A turn begins before its waypoint, so that it ends
    on the next leg (fly-by), and with the port ``vt`` wired the wind is allowed for; or at its
    waypoint (``fly_over``). The last leg is flown on beyond its end, or into a holding pattern,
    whose legs are the four that follow: turn, outbound, turn, inbound.

    While it is off, the block keeps its leg; leg 0 then starts at the position of the next
    engagement. To fly with an ``Autopilot``, wire ``phi_cmd`` to its ``phi_ref``, with
    ``roll_mode`` at 1.

    Parameters
    ----------
    gains : str or dict
        as in ``HeadingHold``
    chi_ref : float, optional
        course to hold in deg from true north, without waypoints; default: the value at engagement
    waypoints : list of (float, float), optional
        geodetic latitude and longitude of each, deg
    leg : int
        leg that is active at the start; 1 captures the line from the first to the second waypoint
    lookahead : float, optional
        time constant tau of the cross-track error in s; default 3.5 times that of the heading loop,
        V_g / (g Kp)
    intercept : float
        largest angle at which it closes on a leg, deg
    %(bank)s
    %(T)s
    fly_over : list of int, optional
        numbers of the waypoints, from 1 on, that are passed before the turn begins
    arcs : dict, optional
        {leg: (latitude, longitude, "left" or "right")}: the leg is an arc about that point, which
        is equally far from both ends. The bank that it takes must be less than ``bank_max``
    holding : (float, str, float, float), optional
        the pattern that is held at the last waypoint: inbound course in deg, "left" or "right"
        turns, their radius and the length of the straight legs in ft

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude in deg
    psi, phi, p
        true heading and roll angle in deg, roll rate in deg/s
    chi_ref
        deg, added to the parameter; without meaning along waypoints
    %(ail_off)s
    %(vc)s
    vt
        true airspeed in ft/s; without a wire (0) turns are begun as in still air

    Outputs
    -------
    %(aileron)s
    chi
        course over the ground in deg, [0, 360); the heading at the first sample
    chi_cmd
        course demanded, deg, [0, 360)
    across
        cross-track error in ft, positive to the right of the leg; 0 without waypoints
    to_go
        distance along the leg to its waypoint in ft, negative beyond the last; 0 without waypoints
    leg
        number of the active leg

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    chi_ref: float | None = parameter(None, optional)
    waypoints: list[tuple[float, float]] | None = parameter(None)
    leg: int = parameter(0, whole, low=0)
    lookahead: float | None = parameter(None, optional, above=0.0)
    intercept: float = parameter(45.0, number, above=0.0, high=90.0)
    bank_max: float = parameter(25.0, number, above=0.0, high=80.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    fly_over: list[int] | None = parameter(None)
    arcs: dict[int, tuple[float, float, str]] | None = parameter(None)
    holding: tuple[float, str, float, float] | None = parameter(None)

    measured = ("lat", "lon", "psi", "phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = numbered("lat lon psi phi p chi_ref off ail_sat vc vt")
    output_port_labels = numbered("aileron phi_cmd chi chi_cmd across to_go leg")

    def build(self) -> None:
        T, c = self.clock.period, self.checked
        self._chi_ref = c.chi_ref
        self._route = _Route(self.waypoints, self.leg, self.fly_over, self.arcs, self.holding)
        if self._route.waypoints and self._chi_ref is not None:
            refuse(
                "chi_ref",
                self.chi_ref,
                "give a course or waypoints, not both: along waypoints the course is that of the "
                "leg",
            )
        self.loops = self.lateral_loops()
        self._share = -math.expm1(-T / SMOOTHING)
        self._centripetal = GRAVITY * math.tan(math.radians(c.bank_max))

    START = Lateral.START

    def initial_state(self) -> tuple[Any, ...]:
        return _Ground(), None, None, None, flat(self.START)

    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        lat, lon, psi, phi, p, chi_ref, off, ail_sat, vc, vt = u[:10]
        ground, found, leg, direct, lateral = state
        leg = self._route.start if leg is None else leg
        here = place_unchecked(lat, lon)
        ground = ground.next(here, psi, self._share, self.clock.period)
        gains = self.gains_at(vc)
        if gains:
            self.follow(gains)
        chi = (psi + ground.drift) % 360.0
        # the course is known from the second sample on
        engaged = not off and ground.known

        across = to_go = bend = 0.0
        if self._route.waypoints:
            leg, direct, track = self._along(here, chi, ground, vt, leg, direct, engaged)
            across, to_go = track.across, track.to_go
            tau = self.checked.lookahead or SEPARATION * self.loops["heading"].lag(ground.speed)
            closing = math.degrees(math.atan2(across, max(tau * ground.speed, 1.0)))
            most = self.checked.intercept
            target = track.course - min(max(closing, -most), most)
            bend = self._route.bank(leg, ground)
        else:
            found = found if engaged and found is not None else chi
            target = (found if self._chi_ref is None else self._chi_ref) + chi_ref
        if not engaged:
            found = None
        flown = [chi, phi, p, target, bend, float(not ground.known), off, ail_sat, *gains]
        (aileron, phi_cmd), lateral = self.flown(flown, lateral, None, len(flown))
        return (
            [aileron, phi_cmd, chi, target % 360.0 if engaged else chi, across, to_go, float(leg)],
            (ground, found, leg, direct, lateral),
        )

    def channels(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        chi, phi, p, target, bend, unknown, off, ail_sat = u
        off, unknown = off != 0.0, unknown != 0.0
        lateral = Lateral(self.loops, state, chi, phi, p, off, ail_sat)
        wanted = lateral.for_heading(Reference(target), idle=off | unknown) + bend
        wanted = limit(wanted, -self.checked.bank_max, self.checked.bank_max)
        found, keeps = lateral.roll.towards(state.roll, phi, Reference())
        *outputs, state = lateral.fly(select(unknown, found, wanted), select(unknown, keeps, False))
        return outputs, state

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        super().load_checkpoint(prefix, json_data, npz)
        # what was saved are tuples without names
        for i, (y, state) in self.clock.results.items():
            (here, *others), found, leg, direct, *loops = state
            ground = _Ground(here and Place(*here), *others)
            direct = direct and GreatCircle(*direct)
            self.clock.results[i] = y, (ground, found, leg, direct, *loops)

    def _along(
        self,
        here: Place,
        chi: float,
        ground: _Ground,
        vt: float,
        leg: int,
        direct: GreatCircle | None,
        engaged: bool,
    ) -> tuple[int, GreatCircle | None, Track]:
        """Active leg, leg 0 once it is engaged, and where the aircraft is on the active one."""
        route = self._route
        leg = min(leg, len(route.legs))
        if leg == 0:
            first = route.waypoints[0]
            direct = direct if engaged and direct else circle_through(here, first)
            if direct is None and route.legs:
                leg = 1
        circle = route.legs[leg - 1] if leg else direct
        if circle is None:  # at the only waypoint
            return leg, None, Track(0.0, 0.0, chi)
        track = circle.track(here)
        after = route.after(leg)
        if engaged and after and track.to_go <= self._ahead(ground, vt, leg, after, track.course):
            leg = after
            track = route.legs[leg - 1].track(here)
        return leg, direct, track

    def _ahead(self, ground: _Ground, vt: float, leg: int, after: int, course: float) -> float:
        """Distance before a waypoint at which the turn begins, ft.

        A turn at the largest bank and the true airspeed, carried along by the wind, ends on the
        next leg; rolling into it and out of it takes time.
        """
        route, most = self._route, self.checked.bank_max
        if leg + 1 in route.fly_over:
            return 0.0
        speed, drift = ground.speed, ground.drift if vt else 0.0
        vt, turn = vt or speed, wrap(route.courses[after - 1] - course)
        side, turn = math.copysign(1.0, turn), min(abs(turn), _SHARPEST)
        chi, new = math.radians(course), math.radians(course + side * turn)
        heading = chi - math.radians(drift)
        north = speed * math.cos(chi) - vt * math.cos(heading)
        east = speed * math.sin(chi) - vt * math.sin(heading)
        # the heading on the next leg
        aside = east * math.cos(new) - north * math.sin(new)
        settled = new - math.asin(min(max(aside / max(vt, 1.0), -1.0), 1.0))
        radius = vt * vt / self._centripetal
        seconds = max(side * math.radians(wrap(math.degrees(settled - heading))), 0.0)
        seconds *= radius / max(vt, 1.0)
        north = side * radius * (math.sin(settled) - math.sin(heading)) + north * seconds
        east = side * radius * (math.cos(heading) - math.cos(settled)) + east * seconds
        ends = (north * math.sin(new) - east * math.cos(new)) * side
        lead = min(turn / most, 1.0) * (most / self._roll + self.loops["heading"].lag(speed))
        lead += abs(route.bank(after, ground) - route.bank(leg, ground)) / self._roll
        return ends / max(math.sin(math.radians(turn)), 1e-3) + lead * speed / 2

    @property
    def _roll(self) -> float:
        """Largest rate of the bank reference, deg/s."""
        return self.loops["roll"].ramp


class _Route:
    """Waypoints, the legs between them and of the holding pattern, and their courses."""

    def __init__(self, waypoints: Any, leg: Any, fly_over: Any, arcs: Any, holding: Any):
        points = waypoints if waypoints is not None else []
        if hasattr(points, "tolist"):
            points = points.tolist()
        if not isinstance(points, (list, tuple)) or (waypoints is not None and not points):
            refuse(
                "waypoints",
                waypoints,
                f"waypoints must be a list of (latitude, longitude) in deg, not {waypoints!r}",
            )
        try:
            self.waypoints = [place_unchecked(*point("waypoints", p)) for p in points]
            circles = [great_circle(a, b) for a, b in pairwise(points)]
        except ParameterError as error:
            refuse("waypoints", waypoints, str(error))
        self.last = len(circles)
        self.legs: list[GreatCircle | Arc] = [*circles]
        for k, about in _numbered("arcs", arcs, self.last).items():
            self.legs[k - 1] = self._arc(arcs, about, *self.waypoints[k - 1 : k + 1])
        starts = self.waypoints[: self.last]
        over = dict.fromkeys(fly_over) if isinstance(fly_over, (list, tuple)) else fly_over
        self.fly_over = set(_numbered("fly_over", over, len(points)))
        if holding is not None:
            corners = self._pattern(holding, points)
            starts += corners
            # the first time, from any course
            self.fly_over.add(self.last + 1)
        self.courses = [leg.track(here).course for leg, here in zip(self.legs, starts, strict=True)]
        self.start = whole("leg", leg, low=0)
        if self.start > self.last:
            refuse(
                "leg",
                leg,
                f"leg must be at most {self.last}: {len(points)} waypoints have no leg "
                f"{self.start}",
            )

    def after(self, leg: int) -> int:
        """The leg after one; 0 for none. The holding pattern is flown again."""
        if leg < len(self.legs):
            return leg + 1
        return self.last + 1 if len(self.legs) > self.last else 0

    def bank(self, leg: int, ground: _Ground) -> float:
        """Bank in deg that the curvature of a leg takes at a ground speed."""
        arc = self.legs[leg - 1] if leg else None
        if not isinstance(arc, Arc):
            return 0.0
        pull = ground.speed**2 / (GRAVITY * arc.radius * math.cos(math.radians(ground.drift)))
        return arc.side * math.degrees(math.atan(pull))

    @staticmethod
    def _arc(arcs: Any, about: Any, first: Place, last: Place) -> Arc:
        if not isinstance(about, (list, tuple)) or len(about) != 3:
            refuse("arcs", arcs, f"an arc is (latitude, longitude, side), not {about!r}")
        centre = place_unchecked(*point("arcs", about[:2]))
        arc = arc_about(centre, first, last, _side("arcs", about[2]))
        off = distance(centre, first) - arc.radius
        if abs(off) > 0.01 * arc.radius:
            refuse("arcs", arcs, f"the centre of an arc is {off:.0f} ft further from its start")
        return arc

    def _pattern(self, holding: Any, points: Any) -> list[Place]:
        """Add the legs of the holding pattern; the places where they begin."""
        if not isinstance(holding, (list, tuple)) or len(holding) != 4 or not points:
            refuse(
                "holding",
                holding,
                "holding takes waypoints and is (course in deg, side, radius in ft, length in ft), "
                f"not {holding!r}",
            )
        course, side = number("holding", holding[0]), _side("holding", holding[1])
        radius = number("holding", holding[2], above=0.0)
        length = number("holding", holding[3], above=0.0)

        def corner(ahead: float, right: float) -> Place:
            return place_unchecked(*beside(points[-1], course, ahead, side * right))

        fix, abeam = self.waypoints[-1], corner(0.0, 2 * radius)
        away, back = corner(-length, 2 * radius), corner(-length, 0.0)
        for leg in (
            arc_about(corner(0.0, radius), fix, abeam, side),
            circle_through(abeam, away),
            arc_about(corner(-length, radius), away, back, side),
            circle_through(back, fix),
        ):
            assert leg is not None
            self.legs.append(leg)
        return [fix, abeam, away, back]


def _side(parameter: str, value: Any) -> float:
    return {"left": -1.0, "right": 1.0}[one_of(parameter, value, ("left", "right"))]


def _numbered(parameter: str, value: Any, last: int) -> dict[int, Any]:
    """A dict whose keys are numbers of legs or waypoints; empty for None."""
    if value is not None and not isinstance(value, dict):
        refuse(parameter, value, f"{parameter} must have numbers from 1 to {last}, not {value!r}")
    for key in value or {}:
        if whole(parameter, key, low=1) > last:
            refuse(parameter, value, f"{parameter}: there is no number {key!r}, only up to {last}")
    return value or {}


@fill
class GlideslopeHold(Hold):
    """Follows a glide path down to a runway with the elevator; captures it from below or above.

    .. math::
        \\dot h_\\mathrm{cmd} &= -V_c \\tan\\gamma - K_h \\, \\Delta h \\\\
        \\theta_\\mathrm{cmd} &= K_p (\\dot h_\\mathrm{cmd} - \\dot h)
        + K_i \\int (\\dot h_\\mathrm{cmd} - \\dot h) \\, dt \\\\
        \\theta_\\mathrm{min} &\\le \\theta_\\mathrm{cmd} \\le \\theta_\\mathrm{max}

    with the height Delta h above the path, the speed V_c of closing on the threshold, and the pitch
    loop of ``PitchHold`` inside, sampled at T. The path is a straight line at the angle gamma to
    the ground at the runway, which passes above the threshold; the Earth's surface falls away below
    it. Until it is captured, the altitude found at engagement is held. It is captured where it
    demands a lower rate of climb than the altitude does, on the way to the threshold and, unless
    ``from_above`` is set, not more than 0.35 deg above the path. There is no flare: that of
    ``FlareHold`` comes after it. With the port ``alpha`` wired it keeps the
    angle of attack below its limit; the lowest airspeed of the gain table is that of the clean
    aircraft and has no effect here.

    Parameters
    ----------
    gains : str or dict
        as in ``AltitudeHold``
    threshold : (float, float)
        geodetic latitude and longitude of the runway's threshold, deg
    elevation : float
        height of the threshold above sea level, ft
    angle : float
        glide path angle gamma in [0.1, 20], deg
    crossing_height : float
        height of the path above the threshold, ft
    hdot_max : float, optional
        largest correction of the rate of climb, ft/s, downwards; upwards it may be as large as the
        path's own rate of descent; default is the gain table's
    theta_min : float
        lowest pitch reference in deg
    theta_max : float, optional
        highest pitch reference in deg; default is the gain table's
    authority : float or pair
        largest elevator increment, of full travel
    %(T)s
    %(alpha_max)s
    from_above : bool
        capture the path from above too, at any height: it descends to it by ``hdot_max`` faster
        than the path does

    Inputs
    ------
    h, hdot
        altitude in ft, rate of climb in ft/s
    lat, lon
        geodetic latitude and longitude in deg
    theta, q
        pitch angle in deg, pitch rate in deg/s
    off
        0 engaged; otherwise the elevator is frozen
    elev_sat
        ``Aircraft`` output of that name, for anti-windup at the end of travel
    %(vc)s
    alpha
        angle of attack in deg; without a wire (0) there is no protection from the stall. The load
        factor is limited with ``vc`` wired only
    gs_deg, gs_ft, gs_dist
        outputs of a ``Glideslope`` receiver, whose angle is ``angle``. If ``gs_dist`` is wired they
        replace ``lat``, ``lon``, ``threshold``, ``elevation`` and ``crossing_height``

    Outputs
    -------
    elevator
        increment of the elevator command; positive is nose **down**
    theta_cmd
        pitch reference on its ramp, deg
    hdot_cmd
        rate of climb demanded, ft/s; 0 while off
    gs_deg
        deviation seen from the path's foot, deg, positive above the path
    gs_ft
        height above the path, ft
    dist
        distance to the threshold (with a receiver, to its station) in ft, negative beyond it once
        the path is captured
    captured
        1 from the capture on, otherwise 0

    %(raises)s
    """

    gains: Gains = parameter("c172p")
    threshold: tuple[float, float] = parameter((0.0, 0.0), point)
    elevation: float = parameter(0.0, number)
    angle: float = parameter(3.0, number, above=0.0, low=0.1, high=20.0)
    crossing_height: float = parameter(50.0, number, low=0.0, high=1e4)
    hdot_max: float | None = parameter(None, optional, above=0.0)
    theta_min: float = parameter(-10.0, number)
    theta_max: float | None = parameter(None, optional)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    alpha_max: float | None = parameter(None, optional)
    from_above: bool = parameter(False, flag)

    measured = ("h", "hdot", "lat", "lon", "theta", "q")
    commands = {"elevator": "off"}
    input_port_labels = numbered(
        "h hdot lat lon theta q off elev_sat vc alpha gs_deg gs_ft gs_dist"
    )
    output_port_labels = numbered("elevator theta_cmd hdot_cmd gs_deg gs_ft dist captured")

    def build(self) -> None:
        T, c = self.clock.period, self.checked
        self._threshold = place_unchecked(*c.threshold)
        self._slope = math.tan(math.radians(c.angle))
        self._foot = c.crossing_height / self._slope
        self._received = self.input_port_labels["gs_dist"]
        self.loops = self.vertical_loops()
        self._share = -math.expm1(-T / SMOOTHING)

    START = Vertical.START

    def initial_state(self) -> tuple[Any, ...]:
        # distance and speed of closing, None while unknown; captured; the vertical channel
        return None, None, 0.0, flat(self.START)

    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        h, hdot, lat, lon, theta, q, off, elev_sat, vc, alpha = u[:10]
        before, speed, captured, vertical = state
        received = self._received in self.inputs.wired
        if received:
            degrees, above, away = u[10:13]
        else:
            away = distance(place_unchecked(lat, lon), self._threshold)
        rate = 0.0 if before is None else (before - away) / self.clock.period
        if before is not None:
            speed = abs(rate) if speed is None else speed + self._share * (abs(rate) - speed)
        dist = -away if captured and rate < 0.0 else away
        if not received:
            height = h - self.checked.elevation
            degrees, above = above_path(height, dist + self._foot, self.checked.angle)

        flown = [h, hdot, theta, q, off, elev_sat, vc, alpha]
        flown += [above, speed or 0.0, rate, degrees, captured, *self.gains_at(vc, h)]
        (elevator, theta_cmd, hdot_cmd, captured), vertical = self.flown(
            flown, vertical, alpha != 0.0, len(flown)
        )
        return (
            [elevator, theta_cmd, hdot_cmd, degrees, above, dist, captured],
            (away, speed, captured, vertical),
        )

    def needed(self) -> tuple[str, ...]:
        received = self._received in self.inputs.wired
        return tuple(x for x in self.measured if not (received and x in ("lat", "lon")))

    def channels(self, u: list[Any], state: Any, form: Any) -> tuple[list[Any], Any]:
        h, hdot, theta, q, off, elev_sat, vc, alpha, above, speed, rate, degrees, captured = u
        off = off != 0.0
        vertical = Vertical(self.loops, form, state, theta, q, h, hdot, vc, alpha, off, elev_sat)
        # without the airspeed: its lowest is that of the clean aircraft
        vertical.guard(0.0, True)
        altitude, (found, climb) = vertical.altitude, state.altitude
        found = select(climb.engaged, found, h)
        level = altitude.climb_rate(found - h)
        # a limit of the correction below this would end in a descent short of the path
        sink = speed * self._slope
        most = larger(altitude.hdot_max, sink)
        descent = limit(-altitude.Kh * above, -altitude.hdot_max, most) - sink
        met = True if self.checked.from_above else degrees <= _CAPTURE
        # the speed is known once the distance has changed
        lower = (rate > 0.0) & (-altitude.Kh * above - sink <= level) & met
        captured = select(off, False, (captured != 0.0) | lower)
        hdot_cmd = select(captured, descent, level)
        reference = vertical.pitch.reference(state.pitch, theta)
        wanted, climb = altitude.climb(climb, hdot_cmd, hdot, reference, state.cut)
        vertical.state = vertical.state._replace(
            altitude=select(off, AltitudeLoop.START, AltitudeState(found, climb))
        )
        *outputs, state = vertical.fly(wanted)
        return [*outputs, select(off, 0.0, hdot_cmd), select(captured, 1.0, 0.0)], state
