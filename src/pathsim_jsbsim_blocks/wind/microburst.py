"""Microburst: the downburst of Oseguera and Bowles."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import numpy as np

from .._core.checks import finite, number
from .._core.function import NamedFunction
from .._core.parameters import parameter
from ..axes.earth import geodetic_to_ned

# height of the maximum outflow over the two height scales
_OUTER, _INNER = 0.22, 2.75
# maximum of (1 - exp(-x^2)) / (2 x), the variation of the outflow with the radius
_PEAK = 0.31908642

_length = partial(number, above=0.0, low=1.0, high=1e6)  # ft
_speed = partial(number, above=0.0, high=1e3)  # ft/s


def oseguera_bowles(
    north: Any,
    east: Any,
    h: Any,
    radius: float = 3000.0,
    outflow: float = 60.0,
    height: float = 150.0,
) -> tuple[Any, Any, Any]:
    """Velocity of the air in an axially symmetric downburst above flat ground.

    Oseguera and Bowles, NASA TM-100632. In the equations of `Microburst` w is positive upwards,
    z* = z_m / 0.22 and epsilon = z_m / 2.75. The flow conserves mass. The outflow has its maximum
    at r = 1.12 R and the height z_m; lambda follows from it.

    Parameters
    ----------
    north, east : float or array
        position from the centre, ft
    h : float or array
        height above the ground, ft
    radius : float
        radius R of the downdraft, ft
    outflow : float
        maximum horizontal velocity, ft/s
    height : float
        height z_m of the maximum horizontal velocity, ft

    Returns
    -------
    tuple of float or array
        velocity of the air north, east and down, ft/s

    Raises
    ------
    ParameterError
        for a radius or height outside [1, 1e6] ft, an outflow that is not positive or above
        1000 ft/s, and values that are not finite
    """
    north, east, h = finite(north=north, east=east, h=h)
    radius, height = _length("radius", radius), _length("height", height)
    outer, inner = height / _OUTER, height / _INNER
    scale = _speed("outflow", outflow) / (radius * _PEAK * (math.exp(-_OUTER) - math.exp(-_INNER)))
    z = np.maximum(h, 0.0)
    q = np.maximum((north * north + east * east) / radius**2, 1e-300)  # 0 / 0 at the centre
    spread = scale / 2 * -np.expm1(-q) / q * (np.exp(-z / outer) - np.exp(-z / inner))
    down = scale * np.exp(-q) * (inner * np.expm1(-z / inner) - outer * np.expm1(-z / outer))
    return spread * north, spread * east, down


@dataclass(eq=False, repr=False)
class Microburst(NamedFunction):
    """Downburst of Oseguera and Bowles at a point on the ground, for the aircraft's wind ports.

    .. math::
        u_r &= \\frac{\\lambda R^2}{2 r} \\left(1 - e^{-(r/R)^2}\\right)
        \\left(e^{-z/z^*} - e^{-z/\\epsilon}\\right) \\\\
        w &= -\\lambda e^{-(r/R)^2}
        \\left(z^* (1 - e^{-z/z^*}) - \\epsilon (1 - e^{-z/\\epsilon})\\right)

    A flight through it meets headwind, downdraft and tailwind in turn. The outflow has its maximum
    at r = 1.12 R. See ``wind.oseguera_bowles``.

    Parameters
    ----------
    lat0 : float
        geodetic latitude of the centre in [-89, 89], deg
    lon0 : float
        longitude of the centre, deg, east positive
    radius : float
        radius R of the downdraft, ft
    outflow : float
        maximum horizontal velocity, ft/s
    height : float
        height of the maximum horizontal velocity above the terrain, ft
    terrain : float
        elevation of the terrain above mean sea level, ft

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude, deg
    h
        altitude above mean sea level, ft

    Outputs
    -------
    north, east, down
        velocity of the air, ft/s

    Raises
    ------
    ParameterError
        for a radius or height outside [1, 1e6] ft, an outflow that is not positive or above
        1000 ft/s, a latitude out of its range, and values that are not finite

    References
    ----------
    Oseguera, Bowles: *A Simple, Analytic 3-Dimensional Downburst Model Based on Boundary Layer
    Stagnation Flow*, NASA TM-100632, 1988.
    """

    lat0: float = parameter(0.0, number, low=-89.0, high=89.0)
    lon0: float = parameter(0.0, number)
    radius: float = parameter(3000.0, _length)
    outflow: float = parameter(60.0, _speed)
    height: float = parameter(150.0, _length)
    terrain: float = parameter(0.0, number)

    is_wind = True
    input_port_labels = {"lat": 0, "lon": 1, "h": 2}
    output_port_labels = {"north": 0, "east": 1, "down": 2}
    # inputs that must be connected
    _places = ("lat", "lon", "h")

    def function(self, lat: float, lon: float, h: float) -> tuple[Any, Any, Any]:
        c = self._checked
        per_lat, per_lon = _feet_per_degree(c.lat0)
        return oseguera_bowles(
            per_lat * (lat - c.lat0),
            per_lon * math.remainder(lon - c.lon0, 360.0),
            h - c.terrain,
            c.radius,
            c.outflow,
            c.height,
        )


@cache
def _feet_per_degree(lat0: float) -> tuple[float, float]:
    """Feet per degree of latitude and per degree of longitude, at a latitude."""
    step = 0.01
    north = geodetic_to_ned(lat0 + step, 0.0, 0.0, lat0, 0.0, 0.0)[0]
    east = geodetic_to_ned(lat0, step, 0.0, lat0, 0.0, 0.0)[1]
    return float(north) / step, float(east) / step
