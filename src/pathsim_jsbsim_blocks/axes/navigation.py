"""Great circles over the Earth's surface: distance, course and cross-track error.

Angles are in degrees, north and east positive, courses clockwise from true north; lengths are in
feet along the surface of JSBSim's ellipsoid, at height 0. A great circle is the plane section
through both points and the centre of the Earth. On the ellipsoid this is not quite the geodesic: it
runs less than 1 ft beside it between points 20 nmi apart, and less than 300 ft at 500 nmi.

Everything is a plain number here, not an array: a controller asks for it at every sample.

References
----------
Gade: A Non-singular Horizontal Position Representation, J. Navigation 63 (2010), whose vectors are
used, here from the centre of the Earth.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .._core.checks import must_be, number, refuse
from .earth import SEMI_MAJOR_AXIS, SEMI_MINOR_AXIS

Vector = tuple[float, float, float]

_A2, _B2 = SEMI_MAJOR_AXIS**2, SEMI_MINOR_AXIS**2
# ft: below this two points have no course between them, and opposite ones no single circle
_NEAR = 0.1


class Place(NamedTuple):
    """A point of the surface: ECEF coordinates in ft, and unit vectors north and east there."""

    position: Vector
    north: Vector
    east: Vector


class CrossTrack(NamedTuple):
    """Where a point is, seen from a great circle.

    ``across`` is the distance from the circle in ft, positive to the right of it, ``to_go`` that
    along it to its end in ft, negative beyond, ``course`` that of the circle abeam the point, deg
    in [0, 360).
    """

    across: float
    to_go: float
    course: float


class GreatCircle(NamedTuple):
    """The great circle from one point through another; `great_circle` makes it.

    ``left``, ``end`` and ``forward`` are unit vectors in ECEF axes: normal to the circle, to its
    end, along it there. ``length`` is the distance between the points in ft.
    """

    left: Vector
    end: Vector
    forward: Vector
    length: float

    def track(self, point: tuple[float, float]) -> CrossTrack:
        """Where a point is, given as its latitude and longitude in deg; lengths within 0.03 %.

        Raises
        ------
        ParameterError
            for what is not two numbers, and a latitude beyond 90 deg
        """
        return self.track_at(place(*latitude_longitude("point", point)))

    def track_at(self, here: Place) -> CrossTrack:
        """The same for a place."""
        p = here.position
        radius = math.sqrt(_dot(p, p))
        across = -radius * math.asin(_dot(p, self.left) / radius)
        to_go = radius * math.atan2(-_dot(p, self.forward), _dot(p, self.end))
        return CrossTrack(across, to_go, _course(_cross(self.left, p), here))


class Arc(NamedTuple):
    """An arc of a circle about a point; its track is one of `GreatCircle`."""

    centre: Place
    radius: float  # ft, some tens of nautical miles at most
    end: float  # bearing from the centre to the end, deg
    extent: float  # angle of the arc, deg in (0, 360)
    side: float  # 1 turns right, -1 left

    def track_at(self, here: Place) -> CrossTrack:
        """Distance from the arc, distance along it to the end, and course."""
        bearing = bearing_from(self.centre, here)
        angle = self.side * (self.end - bearing) % 360.0
        # the gap of the circle belongs half to the end and half to the start
        if angle > 180.0 + self.extent / 2:
            angle -= 360.0
        across = self.side * (self.radius - distance(self.centre, here))
        course = (bearing + self.side * 90.0) % 360.0
        return CrossTrack(across, self.radius * math.radians(angle), course)


def arc_about(centre: Place, first: Place, last: Place, side: float) -> Arc:
    """The arc from one place to another about a third, at its distance from the last."""
    end = bearing_from(centre, last)
    extent = side * (end - bearing_from(centre, first)) % 360.0
    return Arc(centre, distance(centre, last), end, extent, side)


def bearing_from(centre: Place, there: Place) -> float:
    """Bearing in deg from one place to another that is near it."""
    d = tuple(b - a for a, b in zip(centre.position, there.position, strict=True))
    return _course(d, centre)


def place(lat: float, lon: float) -> Place:
    """The point of the surface at a geodetic latitude and longitude, deg."""
    lat, lon = math.radians(lat), math.radians(lon)
    s, c, sin, cos = math.sin(lat), math.cos(lat), math.sin(lon), math.cos(lon)
    N = _A2 / math.sqrt(_A2 * c * c + _B2 * s * s)
    return Place(
        (N * c * cos, N * c * sin, N * _B2 / _A2 * s),
        (-s * cos, -s * sin, c),
        (-sin, cos, 0.0),
    )


def great_circle(start: Any, end: Any) -> GreatCircle:
    """The great circle from one point through another.

    Parameters
    ----------
    start, end : (float, float)
        geodetic latitude and longitude, deg

    Raises
    ------
    ParameterError
        for what is not two numbers, a latitude beyond 90 deg, and points that coincide or lie
        opposite each other

    Examples
    --------
    >>> leg = great_circle((0.0, 0.0), (0.0, 1.0))
    >>> track = leg.track((0.1, 0.5))
    >>> round(leg.length), round(track.across), round(track.to_go), round(track.course)
    (365221, -36278, 182611, 90)
    """
    first = place(*latitude_longitude("start", start))
    last = place(*latitude_longitude("end", end))
    circle = circle_through(first, last)
    if circle is None:
        why = f"there is no single great circle from {tuple(start)} to {tuple(end)}: "
        refuse("end", end, why + "they coincide or lie opposite each other")
    return circle


def circle_through(first: Place, last: Place) -> GreatCircle | None:
    """The same between two places; None if they coincide or lie opposite each other."""
    left = _cross(first.position, last.position)
    area = math.sqrt(_dot(left, left))
    if area < _NEAR * SEMI_MINOR_AXIS:
        return None
    left = _scaled(left, 1.0 / area)
    there = _scaled(last.position, 1.0 / math.sqrt(_dot(last.position, last.position)))
    return GreatCircle(left, there, _cross(left, there), distance(first, last))


def line_to(end: Place, course: float) -> GreatCircle:
    """The great circle that reaches a place on a course in deg; its length is 0."""
    chi = math.radians(course)
    north, east = _scaled(end.north, math.cos(chi)), _scaled(end.east, math.sin(chi))
    ahead = (north[0] + east[0], north[1] + east[1], north[2] + east[2])
    there = _scaled(end.position, 1.0 / math.hypot(*end.position))
    left = _cross(there, ahead)
    left = _scaled(left, 1.0 / math.hypot(*left))
    return GreatCircle(left, there, _cross(left, there), 0.0)


def distance(a: Place, b: Place) -> float:
    """Distance over the surface in ft, within 0.01 % of the geodesic's up to 1000 nmi."""
    chord = math.dist(a.position, b.position)
    # of the circle through both whose radius is their mean distance from the Earth's centre
    diameter = math.hypot(*a.position) + math.hypot(*b.position)
    return diameter * math.asin(min(chord / diameter, 1.0))


def motion(before: Place, now: Place) -> tuple[float, float]:
    """North and east distance in ft between two places that are near each other."""
    d = tuple(b - a for a, b in zip(before.position, now.position, strict=True))
    return _dot(d, now.north), _dot(d, now.east)


def latitude_longitude(parameter: str, value: Any) -> tuple[float, float]:
    """Latitude and longitude, checked."""
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        must_be(parameter, value, "a latitude and a longitude in deg")
    lat, lon = value
    return (
        number(f"{parameter}: latitude", lat, low=-90.0, high=90.0),
        number(f"{parameter}: longitude", lon, low=-360.0, high=360.0),
    )


def _course(direction: tuple[float, ...], here: Place) -> float:
    return math.degrees(math.atan2(_dot(direction, here.east), _dot(direction, here.north))) % 360.0


def _dot(a: Any, b: Any) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    (x, y, z), (u, v, w) = a, b
    return y * w - z * v, z * u - x * w, x * v - y * u


def _scaled(a: Vector, factor: float) -> Vector:
    return a[0] * factor, a[1] * factor, a[2] * factor
