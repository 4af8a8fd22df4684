"""The International Standard Atmosphere: air at an altitude, and altitude in the air.

Floats in give floats out, computed with ``math``; arrays give arrays, computed with numpy.
Units are SI. The standard is valid from -5 km to 80 km and extrapolated beyond, see ``isa``.

References
----------
ICAO Doc 7488/3 (1993) = ISO 2533:1975. The US Standard Atmosphere 1976 is the same up to 80 km
except for its gas constant, 287.05307 J/(kg K), which changes the pressure by up to 8e-6.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import namedtuple
from functools import partial
from sys import float_info
from typing import Any, Literal, NamedTuple, get_args

import numpy as np

from .._core.checks import finite, one_of, refuse

G0 = 9.80665  # m/s2, standard acceleration of free fall
R = 287.05287  # J/(kg K), specific gas constant of dry air
GAMMA = 1.4  # ratio of specific heats
T0 = 288.15  # K, temperature at sea level
P0 = 101325.0  # Pa, pressure at sea level
A0 = (GAMMA * R * T0) ** 0.5  # m/s, speed of sound at sea level: 340.293988
EARTH_RADIUS = 6_356_766.0  # m, nominal; relates geometric and geopotential altitude
SUTHERLAND_BETA = 1.458e-6  # kg/(m s K^0.5)
SUTHERLAND_S = 110.4  # K

_MOST = float_info.max

# K/m: too small to change a temperature, so that isothermal layers need no formula of their own
ISOTHERMAL = 1e-20

AltitudeKind = Literal["geometric", "geopotential"]
ALTITUDE_KINDS = get_args(AltitudeKind)


class Layer(NamedTuple):
    """A layer of the atmosphere: temperature is linear in geopotential altitude."""

    base: float  # m, geopotential
    temperature: float  # K at the base
    pressure: float  # Pa at the base
    lapse_rate: float  # K/m, positive if the temperature increases upwards
    exponent: float  # of the pressure: -G0 / (R lapse_rate)


def _standard(layer: Any, h: Any, exp: Any, log1p: Any) -> tuple[Any, Any]:
    """Standard pressure in Pa, temperature in K at a geopotential altitude in its layer."""
    base, temperature, pressure, lapse_rate, exponent = layer
    warmer = lapse_rate * (h - base)
    return pressure * exp(exponent * log1p(warmer / temperature)), temperature + warmer


def _layers() -> list[Layer]:
    """The layers, each on top of the one before."""
    # km and K/km. The lowest also applies below sea level. The standard ends at 80 km; its last
    # layer extends to 84.852 km in the US Standard Atmosphere 1976. Isothermal above, so that the
    # extrapolated temperature stays positive.
    steps = [(0, -6.5), (11, 0), (20, 1), (32, 2.8), (47, 0), (51, -2.8), (71, -2), (84.852, 0)]
    layers: list[Layer] = []
    for km, kelvin_per_km in steps:
        base, lapse_rate, (pressure, t) = 1000.0 * km, kelvin_per_km / 1000 or ISOTHERMAL, (P0, T0)
        if layers:
            pressure, t = _standard(layers[-1], base, math.exp, math.log1p)
        temperature = round(t, 6)  # 216.65 as in the standard, not 216.6499...98
        layers.append(Layer(base, temperature, pressure, lapse_rate, -G0 / (R * lapse_rate)))
    return layers


LAYERS = _layers()
_COLUMNS = np.array(LAYERS).T.copy()  # contiguous rows: faster to take from
_TOPS = [layer.base for layer in LAYERS[1:]]  # of all layers but the last


def pressure_temperature(
    altitude: float, temp_deviation: float, geometric: bool
) -> tuple[float, float]:
    """Standard pressure in Pa, temperature in K at a finite altitude above the Earth's centre."""
    h = EARTH_RADIUS * altitude / (EARTH_RADIUS + altitude) if geometric else altitude
    pressure, t = _standard(LAYERS[bisect_right(_TOPS, h)], h, math.exp, math.log1p)
    t += temp_deviation
    if not 0.0 < t < math.inf:
        _refuse_deviation(temp_deviation, t)
    return pressure, t


def _of_array(altitude: Any, temp_deviation: Any, geometric: bool) -> tuple[Any, Any]:
    """As `pressure_temperature`, with an array of altitudes or deviations."""
    altitude = np.asarray(altitude)
    pressure, t = np.empty(altitude.shape), np.empty(altitude.shape)
    flat, tops = (altitude.ravel(), pressure.ravel(), t.ravel()), np.array(_TOPS)[:, np.newaxis]
    for start in range(0, altitude.size, 8192):  # pieces that stay in cache: twice as fast
        h, p, kelvin = (column[start : start + 8192] for column in flat)
        if geometric:
            h = EARTH_RADIUS * h / (EARTH_RADIUS + h)
        number = np.sum(h >= tops, axis=0)
        layer = [column.take(number) for column in _COLUMNS]
        p[:], kelvin[:] = _standard(layer, h, np.exp, np.log1p)
    t = t + temp_deviation
    if not lowest(t) > 0.0:
        _refuse_deviation(temp_deviation, lowest(t))
    return pressure[()], t


def _refuse_deviation(temp_deviation: Any, temperature: float) -> None:
    finite(temp_deviation=temp_deviation)
    why = f"temp_deviation must leave a positive temperature, not {temperature:g} K"
    refuse("temp_deviation", temp_deviation, why)


def lowest(x: Any) -> float:
    """The minimum of numbers; for an empty array the maximum float."""
    return float(x.min(initial=_MOST)) if isinstance(x, np.ndarray) else x


def positive_finite(**values: Any) -> list[Any]:
    """As ``finite``, for quantities that must be positive."""
    out = finite(**values)
    for (parameter, value), x in zip(values.items(), out, strict=True):
        if not lowest(x) > 0:
            refuse(parameter, value, f"{parameter} must be positive, not {lowest(x):g}")
    return out


def _refuse_altitude(altitude: Any) -> None:
    (h,) = finite(altitude=altitude)
    centre = f"the Earth's centre at {-EARTH_RADIUS:.0f} m"
    refuse("altitude", altitude, f"altitude must be above {centre}, not {lowest(h):g} m")


def geopotential_altitude(geometric: Any) -> Any:
    """Geopotential altitude in m of a geometric altitude in m above mean sea level.

    ``H = r0 h / (r0 + h)`` with r0 = 6356.766 km.

    Raises
    ------
    ParameterError
        if a value is not finite, or at or below the Earth's centre
    """
    (h,) = finite(altitude=geometric)
    if not lowest(h) > -EARTH_RADIUS:
        _refuse_altitude(geometric)
    return EARTH_RADIUS * h / (EARTH_RADIUS + h)


def geometric_altitude(geopotential: Any) -> Any:
    """Geometric altitude in m above mean sea level of a geopotential altitude in m.

    ``h = r0 H / (r0 - H)`` with r0 = 6356.766 km, the geopotential altitude at infinity.

    Raises
    ------
    ParameterError
        if a value is not finite, or not below r0
    """
    (h,) = finite(altitude=geopotential)
    if not lowest(-h) > -EARTH_RADIUS:
        why = f"a geopotential altitude is less than {EARTH_RADIUS:.0f} m, not {-lowest(-h):g} m"
        refuse("altitude", geopotential, why)
    return EARTH_RADIUS * h / (EARTH_RADIUS - h)


# range of the standard in m, for both kinds of altitude; -5000 m is within either
LIMITS = {
    "geometric": (-5000.0, geometric_altitude(80_000.0)),
    "geopotential": (geopotential_altitude(-5000.0), 80_000.0),
}


def viscosity(temperature: Any) -> Any:
    """Dynamic viscosity of air in Pa s at a temperature in K, by Sutherland's formula."""
    (temperature,) = positive_finite(temperature=temperature)
    return SUTHERLAND_BETA * temperature * temperature**0.5 / (temperature + SUTHERLAND_S)


class Air(namedtuple("Air", ["pressure", "temperature"])):
    """Static pressure and temperature of dry air, and the properties derived from them.

    ``isa(altitude)`` gives the air of the standard atmosphere. ``Air(pressure, temperature)`` is
    for any other air: a measurement, or the air around a JSBSim aircraft
    (``Air(fdm["atmosphere/P-psf"] * 47.880259, fdm["atmosphere/T-R"] / 1.8)``).

    Parameters
    ----------
    pressure : float or array
        static pressure in Pa, positive
    temperature : float or array
        static temperature in K, positive

    Attributes
    ----------
    density : float or array
        kg/m3, ``p / (R T)``
    speed_of_sound : float or array
        m/s, ``sqrt(gamma R T)``
    viscosity : float or array
        dynamic, in Pa s; Sutherland: ``1.458e-6 T^1.5 / (T + 110.4 K)``

    Raises
    ------
    ParameterError
        if a value is not positive and finite, or the shapes do not broadcast
    """

    __slots__ = ()

    def __new__(cls, pressure: Any, temperature: Any) -> Air:
        return unchecked_air(positive_finite(pressure=pressure, temperature=temperature))

    @property
    def density(self) -> Any:
        return self.pressure / (R * self.temperature)

    @property
    def speed_of_sound(self) -> Any:
        return (GAMMA * R * self.temperature) ** 0.5

    @property
    def viscosity(self) -> Any:
        return viscosity(self.temperature)


unchecked_air = partial(tuple.__new__, Air)  # skips the checks


def isa(altitude: Any, temp_deviation: Any = 0.0, altitude_kind: AltitudeKind = "geometric") -> Air:
    """Air of the International Standard Atmosphere at an altitude.

    The temperature deviation shifts the temperature but not the pressure. This is the convention
    of performance manuals, whose altitude is pressure altitude. JSBSim's ``atmosphere/delta-T``
    differs: it recomputes the pressure with the shifted temperature.

    Parameters
    ----------
    altitude : float or array
        m above mean sea level, valid from -5 km to 80 km; extrapolated with the last lapse rates
        beyond, from 84.852 km up isothermally
    temp_deviation : float or array
        K, added to the standard temperature
    altitude_kind : str
        "geometric" (height) or "geopotential", which a pilot's altimeter shows, set to 1013.25 hPa;
        at 11,000 m they are 19 m apart, 0.3 % of the pressure

    Returns
    -------
    Air
        ``pressure``, ``temperature``, ``density``, ``speed_of_sound``, ``viscosity``

    Raises
    ------
    ParameterError
        if a value is not finite, the shapes do not broadcast, the altitude is below the Earth's
        centre, or the temperature with its deviation is not positive

    Examples
    --------
    >>> round(isa(11_000.0).density, 6)
    0.364801
    """
    geometric = isinstance(altitude_kind, str) and altitude_kind == "geometric"
    if not geometric:
        one_of("altitude_kind", altitude_kind, ALTITUDE_KINDS)
    if type(altitude) is not float or type(temp_deviation) is not float:
        altitude, temp_deviation = finite(altitude=altitude, temp_deviation=temp_deviation)
    of_floats = isinstance(altitude, float) and isinstance(temp_deviation, float)
    if not -EARTH_RADIUS < (altitude if of_floats else lowest(altitude)) < math.inf:
        _refuse_altitude(altitude)
    air = pressure_temperature if of_floats else _of_array
    return unchecked_air(air(altitude, temp_deviation, geometric))


def pressure_altitude(pressure: Any, altitude_kind: AltitudeKind = "geometric") -> Any:
    """Altitude in m at which the standard atmosphere has the given static pressure in Pa.

    The inverse of ``isa(altitude).pressure``, and like that geometric by default. An altimeter and
    a flight level show the kind "geopotential":

    >>> round(pressure_altitude(22632.04))
    11019
    >>> round(pressure_altitude(22632.04, "geopotential"))
    11000

    Raises
    ------
    ParameterError
        if a value is not finite and positive
    """
    return _altitude_of("pressure", pressure, altitude_kind)


def density_altitude(density: Any, altitude_kind: AltitudeKind = "geometric") -> Any:
    """Altitude in m at which the standard atmosphere has the given density in kg/m3.

    The inverse of ``isa(altitude).density``. At a pressure altitude and a temperature deviation
    it is ``density_altitude(isa(altitude, temp_deviation).density)``.

    Raises
    ------
    ParameterError
        if a value is not finite and positive
    """
    return _altitude_of("density", density, altitude_kind)


def _altitude_of(quantity: str, value: Any, altitude_kind: AltitudeKind) -> Any:
    one_of("altitude_kind", altitude_kind, ALTITUDE_KINDS)
    (x,) = positive_finite(**{quantity: value})
    base, temperature, at_base, lapse_rate, exponent = _COLUMNS
    if quantity == "density":  # pressure over temperature
        at_base, exponent = at_base / (R * temperature), exponent - 1
    layer = np.searchsorted(-at_base[1:], np.negative(x), side="right")
    power = np.log(x / at_base[layer]) / exponent[layer]
    altitude = base[layer] + temperature[layer] * np.expm1(power) / lapse_rate[layer]
    if isinstance(x, float):
        altitude = float(altitude)
    return geometric_altitude(altitude) if altitude_kind == "geometric" else altitude
