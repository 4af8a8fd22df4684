"""Axes of the Earth: geodetic coordinates, Earth-centred axes and the local tangent plane.

====  =======================  =================================================================
axes  origin                   x, y, z
====  =======================  =================================================================
ECI   centre of the Earth      in the equator, fixed to the stars; z to the north pole
ECEF  centre of the Earth      prime meridian, 90 deg east, north pole; they turn with the Earth
NED   any point of reference   north, east, down; parallel to the ground at that point
====  =======================  =================================================================

Latitudes ``lat`` are geodetic, in [-90, 90] deg, longitudes ``lon`` in deg, north and east
positive; lengths are in feet. The ellipsoid is JSBSim's: WGS84 with semi-axes rounded in feet,
within 0.06 mm of the standard. The height ``h`` is normal to it, JSBSim's
``position/geod-alt-ft``; its ``position/h-sl-ft`` lies along the Earth's radius and is 0.03 ft more
at 5000 ft in mid-latitudes.
NED coordinates are those of the tangent plane at the reference ``lat0, lon0, h0``.

All arguments of a call broadcast to one shape, which the results have, and NaN gives NaN. A
ParameterError is raised for values that are not real numbers, shapes that do not broadcast, a
latitude beyond 90 deg, and a point deep inside the Earth.

References
----------
JSBSim Reference Manual, Concepts, Frames of Reference.
NIMA TR8350.2, World Geodetic System 1984, 3rd ed., 2000.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from .._core.checks import arrays, refuse
from .aircraft import Components, Values, turn

SEMI_MAJOR_AXIS = 20925646.32546  # ft, JSBSim 1.3.3
SEMI_MINOR_AXIS = 20855486.5951  # ft, JSBSim 1.3.3


@cache
def _ellipsoid() -> Any:
    from pymap3d import Ellipsoid

    # pymap3d works in the unit of the ellipsoid
    return Ellipsoid(SEMI_MAJOR_AXIS, SEMI_MINOR_AXIS, name="WGS84 of JSBSim, ft")


def _check_latitude(parameter: str, lat: Any) -> None:
    if np.any(np.abs(lat) > 90.0):
        refuse(parameter, lat, f"{parameter} must lie in [-90, 90] deg, not {lat}")


def geodetic_to_ecef(lat: Values, lon: Values, h: Values) -> Components:
    """Earth-centred, Earth-fixed coordinates x, y, z (ft) of a geodetic position (deg, ft).

    With N = a^2 / sqrt(a^2 cos^2 lat + b^2 sin^2 lat): x = (N + h) cos lat cos lon,
    y = (N + h) cos lat sin lon, z = (N b^2 / a^2 + h) sin lat
    """
    from pymap3d import geodetic2ecef

    lat, lon, h = arrays(lat=lat, lon=lon, h=h)
    _check_latitude("lat", lat)
    return geodetic2ecef(lat, lon, h, _ellipsoid())


def ecef_to_geodetic(x: Values, y: Values, z: Values) -> Components:
    """Geodetic position (deg, ft) of a point in Earth-centred, Earth-fixed coordinates (ft).

    The inverse of `geodetic_to_ecef`, with a longitude in [-180, 180] deg, to 1e-7 ft up to 100,000
    ft and to 1e-5 ft up to 330,000 ft; the error grows from there, to 0.005 ft at 2,000,000 ft.
    R.-J. You: Transformation of Cartesian to Geodetic Coordinates without Iterations, J. Surveying
    Engineering 126 (2000).
    """
    from pymap3d import ecef2geodetic

    x, y, z = arrays(x=x, y=y, z=z)
    radius = np.sqrt(x * x + y * y + z * z)
    if np.any(radius < 0.98 * SEMI_MINOR_AXIS):
        why = "x, y, z must lie near or above the ground, some 20.9e6 ft from the centre of the "
        refuse("x, y, z", (x, y, z), f"{why}Earth, not at {np.min(radius):g} ft")
    return ecef2geodetic(x, y, z, _ellipsoid())


def ecef_to_ned(
    x: Values, y: Values, z: Values, lat0: Values, lon0: Values, h0: Values = 0.0
) -> Components:
    """Position of a point in Earth-centred coordinates, north, east, down of a reference (ft).

    The ground is 1 ft below the tangent plane at a distance of 6500 ft; this grows with the square
    of the distance.
    """
    from pymap3d import ecef2ned

    x, y, z, lat0, lon0, h0 = arrays(x=x, y=y, z=z, lat0=lat0, lon0=lon0, h0=h0)
    _check_latitude("lat0", lat0)
    return ecef2ned(x, y, z, lat0, lon0, h0, _ellipsoid())


def ned_to_ecef(
    north: Values, east: Values, down: Values, lat0: Values, lon0: Values, h0: Values = 0.0
) -> Components:
    """Earth-centred coordinates (ft) of a point north, east and down of a reference."""
    from pymap3d import ned2ecef

    north, east, down, lat0, lon0, h0 = arrays(
        north=north, east=east, down=down, lat0=lat0, lon0=lon0, h0=h0
    )
    _check_latitude("lat0", lat0)
    return ned2ecef(north, east, down, lat0, lon0, h0, _ellipsoid())


def geodetic_to_ned(
    lat: Values, lon: Values, h: Values, lat0: Values, lon0: Values, h0: Values = 0.0
) -> Components:
    """Geodetic position (deg, ft) as north, east and down of a reference (ft)."""
    return ecef_to_ned(*geodetic_to_ecef(lat, lon, h), lat0, lon0, h0)


def ned_to_geodetic(
    north: Values, east: Values, down: Values, lat0: Values, lon0: Values, h0: Values = 0.0
) -> Components:
    """Geodetic position (deg, ft) of a point north, east and down of a reference (ft)."""
    return ecef_to_geodetic(*ned_to_ecef(north, east, down, lat0, lon0, h0))


def ecef_vector_to_ned(x: Values, y: Values, z: Values, lat: Values, lon: Values) -> Components:
    """Turn a vector, such as a velocity, from Earth-centred to the NED axes at ``lat, lon``."""
    x, y, z, lat, lon = arrays(x=x, y=y, z=z, lat=lat, lon=lon)
    _check_latitude("lat", lat)
    outward, east = turn(x, y, lon)
    up, north = turn(outward, z, lat)
    return north, east, -up


def ned_vector_to_ecef(
    north: Values, east: Values, down: Values, lat: Values, lon: Values
) -> Components:
    """Turn a vector from local NED to Earth-centred axes: inverse of `ecef_vector_to_ned`."""
    north, east, down, lat, lon = arrays(north=north, east=east, down=down, lat=lat, lon=lon)
    _check_latitude("lat", lat)
    outward, z = turn(-down, north, -lat)
    x, y = turn(outward, east, -lon)
    return x, y, z


def eci_to_ecef(x: Values, y: Values, z: Values, earth_angle: Values) -> Components:
    """Turn a vector from Earth-centred inertial to Earth-fixed axes, about the polar axis.

    ``earth_angle`` is the angle that the Earth has turned since the two axes coincided, deg:
    JSBSim's ``position/epa-rad``.
    """
    x, y, z, earth_angle = arrays(x=x, y=y, z=z, earth_angle=earth_angle)
    x, y = turn(x, y, earth_angle)
    return x, y, z


def ecef_to_eci(x: Values, y: Values, z: Values, earth_angle: Values) -> Components:
    """Turn a vector from Earth-fixed to Earth-centred inertial axes: inverse of `eci_to_ecef`."""
    x, y, z, earth_angle = arrays(x=x, y=y, z=z, earth_angle=earth_angle)
    x, y = turn(x, y, -earth_angle)
    return x, y, z
