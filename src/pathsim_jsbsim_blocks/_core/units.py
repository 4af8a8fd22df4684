"""Units by name, with exact factors to SI.

The foot, the pound, the nautical mile and standard gravity are exact by definition; the others
follow from them (Thompson and Taylor, *Guide for the Use of the International System of Units*,
NIST Special Publication 811, 2008, appendix B).
"""

from __future__ import annotations

import math
from typing import Any

from .checks import did_you_mean, nearest, refuse

FOOT = 0.3048  # m
_MILE = 1852.0  # m, nautical
KNOT = _MILE / 3600 / FOOT  # ft/s
_POUND = 0.45359237  # kg
_GRAVITY = 9.80665  # m/s2
RHO0 = 0.0023769  # slug/ft3, standard air at sea level (US Standard Atmosphere, 1976)
GRAVITY = 32.174  # ft/s2, rounded as textbooks of flight dynamics have it
_POUND_FORCE = _POUND * _GRAVITY  # N
_SLUG = _POUND_FORCE / FOOT  # kg

# by dimension: unit, (factor, offset) with SI = factor * value + offset
UNITS: dict[str, dict[str, tuple[float, float]]] = {
    "length": {
        "m": (1.0, 0.0),
        "km": (1000.0, 0.0),
        "ft": (FOOT, 0.0),
        "in": (FOOT / 12, 0.0),
        "nmi": (_MILE, 0.0),
        "mi": (5280 * FOOT, 0.0),
    },
    "speed": {
        "m/s": (1.0, 0.0),
        "km/h": (1 / 3.6, 0.0),
        "kt": (_MILE / 3600, 0.0),
        "ft/s": (FOOT, 0.0),
        "ft/min": (FOOT / 60, 0.0),
        "mph": (5280 * FOOT / 3600, 0.0),
    },
    "acceleration": {
        "m/s2": (1.0, 0.0),
        "ft/s2": (FOOT, 0.0),
        "g": (_GRAVITY, 0.0),
    },
    "angle": {
        "rad": (1.0, 0.0),
        "deg": (math.pi / 180, 0.0),
    },
    "angular rate": {
        "rad/s": (1.0, 0.0),
        "deg/s": (math.pi / 180, 0.0),
        "rpm": (math.pi / 30, 0.0),
    },
    "mass": {
        "kg": (1.0, 0.0),
        "lb": (_POUND, 0.0),
        "slug": (_SLUG, 0.0),
    },
    "moment of inertia": {
        "kg*m2": (1.0, 0.0),
        "slug*ft2": (_SLUG * FOOT**2, 0.0),
    },
    "force": {
        "N": (1.0, 0.0),
        "kN": (1000.0, 0.0),
        "lbf": (_POUND_FORCE, 0.0),
    },
    "moment": {
        "N*m": (1.0, 0.0),
        "ft*lbf": (_POUND_FORCE * FOOT, 0.0),
    },
    "power": {
        "W": (1.0, 0.0),
        "kW": (1000.0, 0.0),
        "hp": (550 * _POUND_FORCE * FOOT, 0.0),
    },
    "pressure": {
        "Pa": (1.0, 0.0),
        "hPa": (100.0, 0.0),
        "psf": (_POUND_FORCE / FOOT**2, 0.0),
        "psi": (_POUND_FORCE / (FOOT / 12) ** 2, 0.0),
    },
    "density": {
        "kg/m3": (1.0, 0.0),
        "slug/ft3": (_SLUG / FOOT**3, 0.0),
    },
    "temperature": {
        "K": (1.0, 0.0),
        "degC": (1.0, 273.15),
        "degF": (5 / 9, 459.67 * 5 / 9),
        "degR": (5 / 9, 0.0),
    },
    "time": {
        "s": (1.0, 0.0),
        "min": (60.0, 0.0),
        "h": (3600.0, 0.0),
    },
}

_DIMENSION = {unit: dimension for dimension, units in UNITS.items() for unit in units}

# how others write them, for the message
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
    other = _ELSEWHERE.get(str(unit))
    refuse(
        parameter,
        unit,
        f"{parameter} must be a unit such as 'kt', 'ft' or 'm/s', not {unit!r}"
        + did_you_mean([other] if other else nearest(str(unit), _DIMENSION)),
    )


def conversion(source: str, target: str) -> tuple[float, float]:
    """Factor and offset that convert values from one unit to another.

    Raises
    ------
    ParameterError
        for an unknown unit, naming the nearest, and for units of different quantities
    """
    dimension, other = _known("source", source), _known("target", target)
    if dimension != other:
        refuse(
            "target",
            target,
            f"{source!r} is a unit of {dimension}, {target!r} one of {other}; units of {dimension} "
            f"are {', '.join(UNITS[dimension])}",
        )
    (a, b), (c, d) = UNITS[dimension][source], UNITS[dimension][target]
    return a / c, (b - d) / c
