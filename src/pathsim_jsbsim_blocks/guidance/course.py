"""Holds of a course over the ground: waypoints, arcs, holding patterns."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

from .._core.callers import warn_user
from .._core.checks import heading, integer, must_be, number, one_of, optional, positive, refuse
from .._core.parameters import parameter
from .._core.ports import numbered
from .._core.units import GRAVITY, KNOT
from ..axes.earth import ned_to_geodetic
from ..axes.navigation import (
    Arc,
    CrossTrack,
    GreatCircle,
    Place,
    arc_about,
    circle_through,
    distance,
    great_circle,
    latitude_longitude,
    motion,
    place,
)
from ..control.controller import Authority, Hold, authority_limits, fill
from ..control.gain_tables import slowest
from ..control.gains import Gains
from ..control.loops import LateralState, wrap
from ..control.pid import clip
from ..errors import ParameterError

__all__ = ["CourseHold"]

SMOOTHING = 2.0  # time constant of drift angle and ground speed, s
# crossover of the heading loop over that of the cross-track loop; 4 would be critically damped
SEPARATION = 3.5
_SHARPEST = 120.0  # deg, limits the lead of a turn, which grows without bound towards 180 deg
# part of the maximum bank that a holding pattern may require; the rest corrects its errors
_HOLDING_BANK = 0.8


class _Ground(NamedTuple):
    """Motion over the ground; the course is the heading plus a smoothed drift angle.

    The drift angle is filtered, not the course: it changes little in a turn, so a lag does no harm.
    """

    position: Place | None = None
    drift: float = 0.0
    speed: float = 0.0
    valid: bool = False

    def next(self, position: Place, psi: float, gain: float, T: float) -> _Ground:
        if self.position is None:
            return _Ground(position)
        north, east = motion(self.position, position)
        speed = math.hypot(north, east) / T
        if speed == 0.0:
            return self._replace(position=position)
        drift = wrap(math.degrees(math.atan2(east, north)) - psi)
        if self.valid:
            drift = wrap(self.drift + gain * wrap(drift - self.drift))
            speed = self.speed + gain * (speed - self.speed)
        return _Ground(position, drift, speed, True)


class CourseState(NamedTuple):
    """State of a `CourseHold`; fields are None until they are computed."""

    ground: _Ground = _Ground()
    initial: float | None = None  # course at engagement, deg
    leg: int | None = None
    direct: GreatCircle | None = None  # leg 0, from the position at engagement
    radius: float | None = None  # of a holding pattern widened in the wind, ft
    lateral: LateralState = LateralState()


@fill
@dataclass(eq=False, repr=False)
class CourseHold(Hold):
    """Holds the course over the ground, or flies along waypoints, with the ailerons.

    .. math::
        \\chi_\\mathrm{cmd} &= \\chi_\\mathrm{leg} - \\arctan\\frac{d}{\\tau V_g}, \\quad
        e = \\mathrm{wrap}(\\chi_\\mathrm{cmd} - \\chi) \\\\
        \\phi_\\mathrm{cmd} &= K_p e + K_i \\int e \\, dt, \\quad
        |\\phi_\\mathrm{cmd}| \\le \\phi_\\mathrm{max}

    with the cross-track error d, the ground speed V_g, the course over the ground chi, and the roll
    loop of ``RollHold`` inside, sampled at T. The ground track is measured, so no wind data are
    needed.

    Leg 0 leads from the position at engagement to the first waypoint, leg k from waypoint k to the
    next, along a great circle or an arc. A turn begins before its waypoint, so that it ends on the
    next leg (fly-by; with ``vt`` connected it allows for the wind), or at its waypoint
    (``fly_over``). The last leg continues beyond its end or into a holding pattern, which has the
    next four legs: turn, outbound, turn, inbound.

    While off, the block keeps its leg; leg 0 then starts at the position of the next engagement. To
    fly with an ``Autopilot``, connect ``phi_cmd`` to its ``phi_ref`` and set ``roll_mode`` to 1.

    Parameters
    ----------
    gains : str or dict
        as in ``HeadingHold``
    chi_ref : float, optional
        course to hold in deg from true north, without waypoints; default: the value at engagement
    waypoints : list of (float, float), optional
        geodetic latitude and longitude of each, deg
    leg : int
        active leg at the start; 1 captures the line from the first to the second waypoint
    lookahead : float, optional
        time constant tau of the cross-track error in s; default 3.5 times that of the heading loop,
        V_g / (g Kp)
    intercept : float
        maximum intercept angle of a leg, deg
    %(bank)s
    %(T)s
    fly_over : list of int, optional
        numbers of the waypoints, from 1 on, at which the turn begins only when they are passed
    arcs : dict, optional
        {leg: (latitude, longitude, "left" or "right")}: the leg is an arc about that point, which
        is equally far from both ends. The required bank must be less than ``bank_max``: it is
        checked at the minimum airspeed of the gains; if the ground speed in flight requires more,
        the block warns once
    holding : (float, str, float, float), optional
        holding pattern at the last waypoint, not around a pole: inbound course in deg, "left" or
        "right" turns, their radius (limited as in ``arcs``) and the length of the straight legs in
        ft. With ``vt`` connected, a radius that requires more than 0.8 of ``bank_max`` with the
        wind from behind is widened at the waypoint; the block warns once

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude in deg
    psi, phi, p
        true heading and roll angle in deg, roll rate in deg/s
    chi_ref
        deg, added to the parameter; ignored along waypoints
    %(ail_off)s
    %(vc)s
    vt
        true airspeed in ft/s; if not connected (0), turns begin as in still air, and a holding
        pattern is not widened

    Outputs
    -------
    %(aileron)s
    chi
        course over the ground in deg, [0, 360); the heading at the first sample
    chi_cmd
        commanded course, deg, [0, 360)
    across
        cross-track error in ft, positive to the right of the leg; 0 without waypoints
    to_go
        distance along the leg to its waypoint in ft, negative beyond the last; 0 without waypoints
    leg
        number of the active leg

    %(raises)s
    """

    gains: Gains = "c172p"
    chi_ref: float | None = parameter(None, optional, of=heading)
    waypoints: list[tuple[float, float]] | None = None
    leg: int = parameter(0, integer, low=0)
    lookahead: float | None = parameter(None, optional, above=0.0)
    intercept: float = parameter(45.0, number, above=0.0, high=90.0)
    bank_max: float = parameter(25.0, number, above=0.0, high=80.0)
    authority: Authority = parameter(1.0, authority_limits)
    T: float = parameter(1 / 120, positive)
    fly_over: list[int] | None = None
    arcs: dict[int, tuple[float, float, str]] | None = None
    holding: tuple[float, str, float, float] | None = None

    measured = ("lat", "lon", "psi", "phi", "p")
    commands = {"aileron": "off"}
    input_port_labels = numbered("lat lon psi phi p chi_ref off ail_sat vc vt")
    output_port_labels = numbered("aileron phi_cmd chi chi_cmd across to_go leg")

    def build(self) -> None:
        T, c = self.clock.period, self._checked
        self._chi_ref = c.chi_ref
        self._route = _Route(self.waypoints, self.leg, self.fly_over, self.arcs, self.holding)
        if self._route.waypoints and self._chi_ref is not None:
            refuse(
                "chi_ref",
                self.chi_ref,
                "set chi_ref or waypoints, not both: along waypoints the legs give the course",
            )
        self.heading, self.roll = self.lateral_loops()
        self._refuse_tight_arcs()
        self._widened: dict[float, _Route] = {}
        self._gain = -math.expm1(-T / SMOOTHING)
        self._centripetal = GRAVITY * math.tan(math.radians(c.bank_max))

    START = CourseState()
    _warned_of_bank = _warned_of_radius = False

    def law(self, u: list[float], state: CourseState) -> tuple[list[float], CourseState]:
        lat, lon, psi, phi, p, chi_ref, off, ail_sat, vc, vt = u[:10]
        ground, initial, leg, direct, radius, lateral = state
        route = self._route_of(radius)
        leg = route.start if leg is None else leg
        position = place(lat, lon)
        ground = ground.next(position, psi, self._gain, self.clock.period)
        self.retune(vc)
        chi = (psi + ground.drift) % 360.0
        # the course is the difference of two positions, so the first sample has none
        engaged = not off and ground.valid

        offset = to_go = bend = 0.0
        if route.waypoints:
            start = leg
            leg, direct, track = self._along(route, position, chi, ground, vt, leg, direct, engaged)
            if start != leg == route.last + 1 and vt:  # the start of the pattern, each time round
                radius = self._radius_in_wind(route, ground, vt, chi)
            offset, to_go = track.across, track.to_go
            tau = self._checked.lookahead or SEPARATION * self.heading.lag(ground.speed)
            closing = math.degrees(math.atan2(offset, max(tau * ground.speed, 1.0)))
            limit = self._checked.intercept
            target = track.course - clip(closing, -limit, limit)
            bend = route.bank(leg, ground)
            if engaged and abs(bend) > self._checked.bank_max and not self._warned_of_bank:
                self._warn_of_bank(bend, leg, ground.speed)
        else:
            initial = initial if engaged and initial is not None else chi
            target = (initial if self._chi_ref is None else self._chi_ref) + chi_ref
        if not engaged:
            initial = None

        bank, heading = self.heading.sample(lateral.heading, chi, (target, 0.0), not engaged)
        bank, keeps = clip(bank + bend, -self._checked.bank_max, self._checked.bank_max), False
        if not ground.valid:
            bank, keeps = self.roll.towards(lateral.roll, phi, (None, 0.0))
        aileron, phi_cmd, roll = self.roll.sample(
            lateral.roll, phi, p, bank, keeps, ail_sat, off != 0.0
        )
        chi_cmd = target % 360.0 if engaged else chi
        return (
            [aileron, phi_cmd, chi, chi_cmd, offset, to_go, float(leg)],
            CourseState(ground, initial, leg, direct, radius, LateralState(heading, roll)),
        )

    def _refuse_tight_arcs(self) -> None:
        """Refuse radii that require more than the maximum bank at all airspeeds of the gains."""
        speed, bank_max = slowest(self.gains), self._checked.bank_max
        for leg, arc in enumerate(self._route.legs, 1):
            if speed is None or not isinstance(arc, Arc):
                continue
            bank = math.degrees(math.atan2(speed**2, GRAVITY * arc.radius))
            if bank > bank_max:
                name = "arcs" if leg <= self._route.last else "holding"
                minimum = speed**2 / (GRAVITY * math.tan(math.radians(bank_max)))
                refuse(
                    name,
                    getattr(self, name),
                    f"{name}: a radius of {arc.radius:.0f} ft requires {bank:.0f} deg of bank at "
                    f"{speed / KNOT:.0f} kt true, the minimum of the gains; with bank_max "
                    f"{bank_max:g} the minimum radius is {minimum:.0f} ft",
                )

    def _warn_of_bank(self, bank: float, leg: int, speed: float) -> None:
        """Warn once if the wind makes an arc too tight."""
        self._warned_of_bank = True
        warn_user(
            f"CourseHold: the arc of leg {leg} requires {abs(bank):.0f} deg of bank at "
            f"{speed / KNOT:.0f} kt over the ground, more than bank_max "
            f"{self._checked.bank_max:g}: the aircraft drifts off it"
        )

    def _route_of(self, radius: float | None) -> _Route:
        """The route with a holding pattern of this radius in ft, or None for its own."""
        if radius is None:
            return self._route
        if radius not in self._widened:
            assert self.holding is not None
            course, side, _, length = self.holding
            route = self.waypoints, self.leg, self.fly_over, self.arcs
            self._widened = {radius: _Route(*route, (course, side, radius, length))}
        return self._widened[radius]

    def _radius_in_wind(
        self, route: _Route, ground: _Ground, vt: float, chi: float
    ) -> float | None:
        """Radius in ft that a holding pattern needs in this wind, None if its own suffices."""
        north, east = _wind(ground, vt, chi)
        speed = vt + math.hypot(north, east)
        bank = _HOLDING_BANK * self._checked.bank_max
        minimum = speed**2 / (GRAVITY * math.tan(math.radians(bank)))
        plain, present = (r.legs[r.last] for r in (self._route, route))
        assert isinstance(plain, Arc)
        assert isinstance(present, Arc)
        if minimum <= present.radius:
            return None if present is plain else present.radius
        if not self._warned_of_radius:
            self._warned_of_radius = True
            warn_user(
                f"CourseHold: the holding pattern is widened from {plain.radius:.0f} to "
                f"{minimum:.0f} ft: at {speed / KNOT:.0f} kt over the ground its own radius "
                f"requires more than {bank:g} deg of bank, {_HOLDING_BANK:g} of bank_max"
            )
        return minimum

    def _along(
        self,
        route: _Route,
        position: Place,
        chi: float,
        ground: _Ground,
        vt: float,
        leg: int,
        direct: GreatCircle | None,
        engaged: bool,
    ) -> tuple[int, GreatCircle | None, CrossTrack]:
        """Active leg, leg 0 once engaged, and the aircraft's position along the active one."""
        leg = min(leg, len(route.legs))
        if leg == 0:
            first = route.waypoints[0]
            direct = direct if engaged and direct else circle_through(position, first)
            if direct is None and route.legs:
                leg = 1
        circle = route.legs[leg - 1] if leg else direct
        if circle is None:  # at the only waypoint
            return leg, None, CrossTrack(0.0, 0.0, chi)
        track = circle.track_at(position)
        next_leg = route.after(leg)
        if (
            engaged
            and next_leg
            and track.to_go <= self._ahead(route, ground, vt, leg, next_leg, track.course)
        ):
            leg = next_leg
            track = route.legs[leg - 1].track_at(position)
        return leg, direct, track

    def _ahead(
        self, route: _Route, ground: _Ground, vt: float, leg: int, next_leg: int, course: float
    ) -> float:
        """Distance before a waypoint at which the turn begins, ft.

        The turn is flown at the maximum bank and the true airspeed, drifts with the wind, and ends
        on the next leg; the distance of half the time to roll in and out is added.
        """
        bank_max = self._checked.bank_max
        if leg + 1 in route.fly_over:
            return 0.0
        speed, drift = ground.speed, ground.drift if vt else 0.0
        vt, turn = vt or speed, wrap(route.courses[next_leg - 1] - course)
        side, turn = math.copysign(1.0, turn), min(abs(turn), _SHARPEST)
        chi, new = math.radians(course), math.radians(course + side * turn)
        heading = chi - math.radians(drift)
        north, east = _wind(ground._replace(drift=drift), vt, course)
        # the heading with which the wind is corrected for on the next leg
        aside = east * math.cos(new) - north * math.sin(new)
        new_heading = new - math.asin(min(max(aside / max(vt, 1.0), -1.0), 1.0))
        radius = vt * vt / self._centripetal
        seconds = max(side * math.radians(wrap(math.degrees(new_heading - heading))), 0.0)
        seconds *= radius / max(vt, 1.0)
        north = side * radius * (math.sin(new_heading) - math.sin(heading)) + north * seconds
        east = side * radius * (math.cos(heading) - math.cos(new_heading)) + east * seconds
        ends = (north * math.sin(new) - east * math.cos(new)) * side
        lead = min(turn / bank_max, 1.0) * (bank_max / self._roll + self.heading.lag(speed))
        lead += abs(route.bank(next_leg, ground) - route.bank(leg, ground)) / self._roll
        return ends / max(math.sin(math.radians(turn)), 1e-3) + lead * speed / 2

    @property
    def _roll(self) -> float:
        """Maximum rate of the bank reference, deg/s."""
        return self.roll.ramp


def _wind(ground: _Ground, vt: float, chi: float) -> tuple[float, float]:
    """Wind to the north and east in ft/s: velocity over the ground less that through the air."""
    course, heading = math.radians(chi), math.radians(chi - ground.drift)
    north = ground.speed * math.cos(course) - vt * math.cos(heading)
    east = ground.speed * math.sin(course) - vt * math.sin(heading)
    return north, east


class _Route:
    """Waypoints, the legs between them and of the holding pattern, and their courses."""

    def __init__(self, waypoints: Any, leg: Any, fly_over: Any, arcs: Any, holding: Any):
        points = waypoints if waypoints is not None else []
        if hasattr(points, "tolist"):
            points = points.tolist()
        if not isinstance(points, (list, tuple)) or (waypoints is not None and not points):
            must_be("waypoints", waypoints, "a list of (latitude, longitude) in deg")
        try:
            self.waypoints = [place(*latitude_longitude("waypoints", p)) for p in points]
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
            # the pattern may be entered from any course, so no turn is anticipated
            self.fly_over.add(self.last + 1)
        self.courses = [
            leg.track_at(start).course for leg, start in zip(self.legs, starts, strict=True)
        ]
        self.start = integer("leg", leg, low=0)
        if self.start > self.last:
            refuse(
                "leg",
                leg,
                f"leg must be at most {self.last}: {len(points)} waypoints have no leg "
                f"{self.start}",
            )

    def after(self, leg: int) -> int:
        """The leg after another, or 0 at the end. The holding pattern repeats."""
        if leg < len(self.legs):
            return leg + 1
        return self.last + 1 if len(self.legs) > self.last else 0

    def bank(self, leg: int, ground: _Ground) -> float:
        """Bank in deg required by the curvature of a leg at a ground speed."""
        arc = self.legs[leg - 1] if leg else None
        if not isinstance(arc, Arc):
            return 0.0
        pull = ground.speed**2 / (GRAVITY * arc.radius * math.cos(math.radians(ground.drift)))
        return arc.side * math.degrees(math.atan(pull))

    @staticmethod
    def _arc(arcs: Any, about: Any, first: Place, last: Place) -> Arc:
        if not isinstance(about, (list, tuple)) or len(about) != 3:
            refuse("arcs", arcs, f"an arc is (latitude, longitude, side), not {about!r}")
        centre = place(*latitude_longitude("arcs", about[:2]))
        arc = arc_about(centre, first, last, _side("arcs", about[2]))
        off = distance(centre, first) - arc.radius
        if abs(off) > 0.01 * arc.radius:
            refuse("arcs", arcs, f"the centre of an arc is {off:.0f} ft further from its start")
        return arc

    def _pattern(self, holding: Any, points: Any) -> list[Place]:
        """Add the legs of the holding pattern; returns their starting points."""
        if not isinstance(holding, (list, tuple)) or len(holding) != 4 or not points:
            refuse(
                "holding",
                holding,
                "holding must be (course in deg, side, radius in ft, length in ft) with waypoints, "
                f"not {holding!r}",
            )
        course, side = heading("holding", holding[0]), _side("holding", holding[1])
        radius = number("holding", holding[2], above=0.0)
        length = number("holding", holding[3], above=0.0)

        fix, (lat, lon) = self.waypoints[-1], points[-1]
        pole = place(math.copysign(90.0, lat), 0.0)
        if distance(fix, pole) <= math.hypot(2 * radius, length):
            refuse("holding", holding, f"the holding pattern at {lat:g} deg reaches the pole")
        c, s = math.cos(math.radians(course)), math.sin(math.radians(course))

        def corner(forward: float, aside: float) -> Place:
            right = side * aside
            north, east = forward * c - right * s, forward * s + right * c
            return place(*map(float, ned_to_geodetic(north, east, 0.0, lat, lon)[:2]))

        abeam = corner(0.0, 2 * radius)
        outbound, back = corner(-length, 2 * radius), corner(-length, 0.0)
        for leg in (
            arc_about(corner(0.0, radius), fix, abeam, side),
            circle_through(abeam, outbound),
            arc_about(corner(-length, radius), outbound, back, side),
            circle_through(back, fix),
        ):
            assert leg is not None
            self.legs.append(leg)
        return [fix, abeam, outbound, back]


def _side(parameter: str, value: Any) -> float:
    return {"left": -1.0, "right": 1.0}[one_of(parameter, value, ("left", "right"))]


def _numbered(parameter: str, value: Any, last: int) -> dict[int, Any]:
    """A dict whose keys are numbers of legs or waypoints; empty for None."""
    if value is not None and not isinstance(value, dict):
        refuse(parameter, value, f"{parameter} must have numbers from 1 to {last}, not {value!r}")
    for key in value or {}:
        if integer(parameter, key, low=1) > last:
            refuse(parameter, value, f"{parameter}: number {key!r} must be from 1 to {last}")
    return value or {}
