"""Units by name, with exact factors to SI.

The foot, the pound, the nautical mile and standard gravity are exact by definition; the others
follow from them (Thompson and Taylor, *Guide for the Use of the International System of Units*,
NIST Special Publication 811, 2008, appendix B).
"""

from __future__ import annotations

import math
from typing import Any

from .checks import arrays, did_you_mean, nearest, refuse

FOOT = 0.3048  # m
_MILE = 1852.0  # m, nautical
KNOT = _MILE / 3600 / FOOT  # ft/s
_POUND = 0.45359237  # kg
_GRAVITY = 9.80665  # m/s2
RHO0 = 0.0023769  # slug/ft3, standard air at sea level (US Standard Atmosphere, 1976)
GRAVITY = 32.174  # ft/s2, rounded as in textbooks of flight dynamics
_POUND_FORCE = _POUND * _GRAVITY  # N
_SLUG = _POUND_FORCE / FOOT  # kg

# by dimension: unit, and the factor to SI
UNITS: dict[str, dict[str, float]] = {
    "length": {
        "m": 1.0,
        "km": 1000.0,
        "ft": FOOT,
        "in": FOOT / 12,
        "nmi": _MILE,
        "mi": 5280 * FOOT,
    },
    "speed": {
        "m/s": 1.0,
        "km/h": 1 / 3.6,
        "kt": _MILE / 3600,
        "ft/s": FOOT,
        "ft/min": FOOT / 60,
        "mph": 5280 * FOOT / 3600,
    },
    "acceleration": {"m/s2": 1.0, "ft/s2": FOOT, "g": _GRAVITY},
    "angle": {"rad": 1.0, "deg": math.pi / 180},
    "angular rate": {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30},
    "mass": {"kg": 1.0, "lb": _POUND, "slug": _SLUG},
    "moment of inertia": {"kg*m2": 1.0, "slug*ft2": _SLUG * FOOT**2},
    "force": {"N": 1.0, "kN": 1000.0, "lbf": _POUND_FORCE},
    "moment": {"N*m": 1.0, "ft*lbf": _POUND_FORCE * FOOT},
    "power": {"W": 1.0, "kW": 1000.0, "hp": 550 * _POUND_FORCE * FOOT},
    "pressure": {
        "Pa": 1.0,
        "hPa": 100.0,
        "psf": _POUND_FORCE / FOOT**2,
        "psi": _POUND_FORCE / (FOOT / 12) ** 2,
    },
    "density": {"kg/m3": 1.0, "slug/ft3": _SLUG / FOOT**3},
    "temperature": {"K": 1.0, "degC": 1.0, "degF": 5 / 9, "degR": 5 / 9},
    "time": {"s": 1.0, "min": 60.0, "h": 3600.0},
}

# added to the scaled value to give K
_OFFSETS = {"degC": 273.15, "degF": 459.67 * 5 / 9}

_DIMENSION = {unit: dimension for dimension, units in UNITS.items() for unit in units}

# other spellings of units, for the error's suggestion
_ELSEWHERE = {
    "feet": "ft",
    "fpm": "ft/min",
    "fps": "ft/s",
    "kts": "kt",
    "KTAS": "kt",
    "KCAS": "kt",
    "lbs": "lb",
    "rad_sec": "rad/s",
    "R": "degR",
    "C": "degC",
    "F": "degF",
}


def _known(parameter: str, unit: Any) -> str:
    if isinstance(unit, str) and unit in _DIMENSION:
        return _DIMENSION[unit]
    synonym = _ELSEWHERE.get(str(unit))
    close = did_you_mean([synonym] if synonym else nearest(str(unit), _DIMENSION))
    why = f"{parameter} must be a unit such as 'kt', 'ft' or 'm/s', not {unit!r}{close}"
    refuse(parameter, unit, why)


def conversion(source: str, target: str) -> tuple[float, float]:
    """Factor and offset that convert values from one unit to another.

    Raises
    ------
    ParameterError
        for an unknown unit, naming the nearest, and for units of different quantities
    """
    dimension, quantity = _known("source", source), _known("target", target)
    units = UNITS[dimension]
    if dimension != quantity:
        why = f"{source!r} is a unit of {dimension}, {target!r} one of {quantity}; units of "
        refuse("target", target, f"{why}{dimension} are {', '.join(units)}")
    offset = _OFFSETS.get(source, 0.0) - _OFFSETS.get(target, 0.0)
    return units[source] / units[target], offset / units[target]


def convert(values: Any, source: str, target: str) -> Any:
    """Values in another unit: a number gives a float, an array or a list an array.

    Parameters
    ----------
    values : array_like
        in the source unit; NaN stays
    source, target : str
        units of one quantity, as in `UnitConversion`

    Raises
    ------
    ParameterError
        for values that are not real, an unknown unit, naming the nearest, and units of different
        quantities

    Examples
    --------
    >>> convert([0.0, 100.0], "degC", "degF").round(9).tolist()
    [32.0, 212.0]
    """
    factor, offset = conversion(source, target)
    (x,) = arrays(values=values)
    return factor * x + offset
