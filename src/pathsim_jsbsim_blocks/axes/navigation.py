"""Great circles over the Earth's surface: distance, course and cross-track error.

Angles are in degrees, north and east positive, courses clockwise from true north; lengths are in
feet along the surface of JSBSim's ellipsoid, at height 0. A great circle is the plane section
through both points and the centre of the Earth. On the ellipsoid this is not quite the geodesic:
they differ by less than 1 ft between points 20 nmi apart, and by less than 300 ft at 500 nmi.

All values are plain numbers, not arrays, because controllers compute them at every sample.

References
----------
Gade: A Non-singular Horizontal Position Representation, J. Navigation 63 (2010); its vectors are
used here from the centre of the Earth.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from .._core.checks import must_be, number, refuse
from .earth import SEMI_MAJOR_AXIS, SEMI_MINOR_AXIS

Vector = tuple[float, float, float]

_A2, _B2 = SEMI_MAJOR_AXIS**2, SEMI_MINOR_AXIS**2
# ft; two points closer than this, or opposite to within it, define no circle
_NEAR = 0.1


class Place(NamedTuple):
    """A point of the surface: ECEF coordinates in ft, and unit vectors north and east there."""

    position: Vector
    north: Vector
    east: Vector


class CrossTrack(NamedTuple):
    """Position of a point relative to a great circle.

    ``across`` is the distance from the circle in ft, positive to the right, ``to_go`` the distance
    along it to its end in ft, negative beyond, ``course`` that of the circle abeam the point, deg
    in [0, 360).
    """

    across: float
    to_go: float
    course: float


class GreatCircle(NamedTuple):
    """The great circle from one point through another, built by `great_circle`.

    ``left``, ``end`` and ``forward`` are unit vectors in ECEF axes: normal to the circle, to its
    end, and along it at the end. ``length`` is the distance between the points in ft.
    """

    left: Vector
    end: Vector
    forward: Vector
    length: float

    def track(self, point: tuple[float, float]) -> CrossTrack:
        """Position of a point with latitude and longitude in deg; lengths within 0.03 %.

        Raises
        ------
        ParameterError
            for values that are not two numbers, and a latitude beyond 90 deg
        """
        return self.track_at(place(*latitude_longitude("point", point)))

    def track_at(self, at: Place) -> CrossTrack:
        """As `track`, for a place."""
        p = at.position
        radius = math.sqrt(_dot(p, p))
        across = -radius * math.asin(_dot(p, self.left) / radius)
        to_go = radius * math.atan2(-_dot(p, self.forward), _dot(p, self.end))
        return CrossTrack(across, to_go, _course(_cross(self.left, p), at))


class Arc(NamedTuple):
    """An arc of a circle about a point, with the interface of `GreatCircle`."""

    centre: Place
    radius: float  # ft, some tens of nautical miles at most
    end: float  # bearing from the centre to the end, deg
    extent: float  # angle of the arc, deg in (0, 360)
    side: float  # 1 turns right, -1 left

    def track_at(self, at: Place) -> CrossTrack:
        """Distance from the arc, distance along it to the end, and course."""
        bearing = bearing_from(self.centre, at)
        angle = self.side * (self.end - bearing) % 360.0
        # of the rest of the circle, half counts as beyond the end and half as before the start
        if angle > 180.0 + self.extent / 2:
            angle -= 360.0
        across = self.side * (self.radius - distance(self.centre, at))
        course = (bearing + self.side * 90.0) % 360.0
        return CrossTrack(across, self.radius * math.radians(angle), course)


def arc_about(centre: Place, first: Place, last: Place, side: float) -> Arc:
    """The arc about ``centre`` from ``first`` to ``last``, with the radius of ``last``."""
    end = bearing_from(centre, last)
    extent = side * (end - bearing_from(centre, first)) % 360.0
    return Arc(centre, distance(centre, last), end, extent, side)


def bearing_from(centre: Place, to: Place) -> float:
    """Bearing in deg from one place to a nearby one."""
    d = tuple(b - a for a, b in zip(centre.position, to.position, strict=True))
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
        for values that are not two numbers, a latitude beyond 90 deg, and points that coincide or
        lie opposite each other

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
    """The great circle between two places; None if they coincide or lie opposite each other."""
    normal = _cross(first.position, last.position)
    area = math.sqrt(_dot(normal, normal))
    if area < _NEAR * SEMI_MINOR_AXIS:
        return None
    normal = _scaled(normal, 1.0 / area)
    end = _scaled(last.position, 1.0 / math.sqrt(_dot(last.position, last.position)))
    return GreatCircle(normal, end, _cross(normal, end), distance(first, last))


def line_to(end: Place, course: float) -> GreatCircle:
    """The great circle that reaches a place on a course in deg; its length is 0."""
    chi = math.radians(course)
    north, east = _scaled(end.north, math.cos(chi)), _scaled(end.east, math.sin(chi))
    forward = (north[0] + east[0], north[1] + east[1], north[2] + east[2])
    up = _scaled(end.position, 1.0 / math.hypot(*end.position))
    normal = _cross(up, forward)
    normal = _scaled(normal, 1.0 / math.hypot(*normal))
    return GreatCircle(normal, up, _cross(normal, up), 0.0)


def distance(a: Place, b: Place) -> float:
    """Distance over the surface in ft, within 0.01 % of the geodesic's up to 1000 nmi."""
    chord = math.dist(a.position, b.position)
    # of the circle whose radius is the mean distance of both from the Earth's centre
    diameter = math.hypot(*a.position) + math.hypot(*b.position)
    return diameter * math.asin(min(chord / diameter, 1.0))


def motion(start: Place, end: Place) -> tuple[float, float]:
    """North and east distance in ft between two nearby places."""
    d = tuple(b - a for a, b in zip(start.position, end.position, strict=True))
    return _dot(d, end.north), _dot(d, end.east)


def latitude_longitude(parameter: str, value: Any) -> tuple[float, float]:
    """Latitude and longitude, checked."""
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        must_be(parameter, value, "a latitude and a longitude in deg")
    lat, lon = value
    return (
        number(f"{parameter}: latitude", lat, low=-90.0, high=90.0),
        number(f"{parameter}: longitude", lon, low=-360.0, high=360.0),
    )


def _course(direction: tuple[float, ...], at: Place) -> float:
    return math.degrees(math.atan2(_dot(direction, at.east), _dot(direction, at.north))) % 360.0


def _dot(a: Any, b: Any) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    (x, y, z), (u, v, w) = a, b
    return y * w - z * v, z * u - x * w, x * v - y * u


def _scaled(a: Vector, factor: float) -> Vector:
    return a[0] * factor, a[1] * factor, a[2] * factor
