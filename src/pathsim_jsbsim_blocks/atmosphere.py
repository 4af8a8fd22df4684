"""The International Standard Atmosphere: plain functions, and the block ``ISAtmosphere``.

Floats in give floats out, computed with ``math``; arrays give arrays, computed with numpy.
Units are SI. The standard holds from -5 km to 80 km; what lies beyond is extrapolated, see ``isa``.

References
----------
ICAO Doc 7488/3 (1993) = ISO 2533:1975. The US Standard Atmosphere 1976 is the same up to 80 km
but for its gas constant, 287.05307 J/(kg K), which changes the pressure by up to 8e-6.
"""

from __future__ import annotations

import math
import warnings
from bisect import bisect_right
from collections import namedtuple
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pathsim_flight.atmosphere as flight
from pathsim.blocks import Function

from .checks import finite, number, one_of
from .errors import FlightError, ParameterError

G0 = 9.80665  # m/s2, standard acceleration of free fall
R = 287.05287  # J/(kg K), specific gas constant of dry air
GAMMA = 1.4  # ratio of specific heats
T0 = 288.15  # K, temperature at sea level
P0 = 101325.0  # Pa, pressure at sea level
A0 = (GAMMA * R * T0) ** 0.5  # m/s, speed of sound at sea level: 340.293988
EARTH_RADIUS = 6_356_766.0  # m, nominal; relates geometric and geopotential altitude
SUTHERLAND_BETA = 1.458e-6  # kg/(m s K^0.5)
SUTHERLAND_S = 110.4  # K

ALTITUDE_KINDS = ("geometric", "geopotential")


class Layer(NamedTuple):
    """A layer of the atmosphere: temperature is linear in geopotential altitude."""

    base: float  # m, geopotential
    temperature: float  # K at the base
    pressure: float  # Pa at the base
    lapse_rate: float  # K/m, positive where it gets warmer upwards
    exponent: float  # of the pressure: -G0/(R lapse_rate); isothermal: -G0/(R temperature) in 1/m


def _layers() -> tuple[Layer, ...]:
    # Bases in km, lapse rates in K/km. The lowest layer also holds below sea level. The standard
    # ends at 80 km. Its last layer goes on to 84.852 km in the US Standard Atmosphere 1976;
    # isothermal from there, so that no extrapolation runs out of temperature.
    table = ((0, -6.5), (11, 0), (20, 1), (32, 2.8), (47, 0), (51, -2.8), (71, -2), (84.852, 0))
    pressure, temperature = P0, T0
    layers: list[Layer] = []
    for km, lapse_rate in table:
        if layers:
            pressure, temperature = _in_layer(layers[-1], 1000.0 * km)
            temperature = round(temperature, 6)  # 216.65 as in the standard, not 216.6499...98
        exponent = -G0 / (R * (lapse_rate / 1000 or temperature))
        layers.append(Layer(1000.0 * km, temperature, pressure, lapse_rate / 1000, exponent))
    return tuple(layers)


def _in_layer(layer: Layer, altitude: float) -> tuple[float, float]:
    """Pressure and temperature at a geopotential altitude of that layer."""
    base, temperature, pressure, lapse_rate, exponent = layer
    if lapse_rate:
        t = temperature + lapse_rate * (altitude - base)
        return pressure * (t / temperature) ** exponent, t
    return pressure * math.exp(exponent * (altitude - base)), temperature


LAYERS = _layers()
_TOPS = tuple(layer.base for layer in LAYERS[1:])
_COLUMNS = np.array(LAYERS).T


def _in_layers(altitude: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """As ``_in_layer``, for an array of altitudes, each in its own layer."""
    pressures, temperatures = np.empty(altitude.shape), np.empty(altitude.shape)
    flat = altitude.ravel(), pressures.ravel(), temperatures.ravel()
    for start in range(0, altitude.size, 16384):  # pieces that stay in cache: twice as fast
        h, p, t = (x[start:start + 16384] for x in flat)
        layer = np.searchsorted(_TOPS, h, side="right")
        base, temperature, pressure, lapse_rate, exponent = (x[layer] for x in _COLUMNS)
        t[:] = temperature + lapse_rate * (h - base)
        p[:] = pressure * np.exp(
            exponent * np.where(lapse_rate, np.log(t / temperature), h - base))
    return pressures, temperatures


def geopotential_altitude(geometric: Any) -> Any:
    """Geopotential altitude in m of a geometric altitude in m above mean sea level.

    ``H = r0 h / (r0 + h)`` with r0 = 6356.766 km.

    Raises
    ------
    ParameterError
        for what is not a finite number, and at or below the Earth's centre
    """
    (h,) = finite(geometric_altitude=geometric)
    if not np.all(h > -EARTH_RADIUS):
        raise ParameterError(
            f"the altitude must be above the Earth's centre at {-EARTH_RADIUS:g} m, "
            f"not {np.min(h):g} m", parameter="altitude", value=geometric)
    return EARTH_RADIUS * h / (EARTH_RADIUS + h)


def geometric_altitude(geopotential: Any) -> Any:
    """Geometric altitude in m above mean sea level of a geopotential altitude in m.

    ``h = r0 H / (r0 - H)`` with r0 = 6356.766 km, the geopotential altitude at infinity.

    Raises
    ------
    ParameterError
        for what is not a finite number, and from r0 upwards
    """
    (altitude,) = finite(geopotential_altitude=geopotential)
    if not np.all(altitude < EARTH_RADIUS):
        raise ParameterError(
            f"a geopotential altitude is below {EARTH_RADIUS:g} m, not {np.max(altitude):g} m",
            parameter="altitude", value=geopotential)
    return EARTH_RADIUS * altitude / (EARTH_RADIUS - altitude)


# The standard's range in m, in both kinds. -5000 m is inside as either.
LIMITS = {
    "geometric": (-5000.0, geometric_altitude(80_000.0)),
    "geopotential": (geopotential_altitude(-5000.0), 80_000.0),
}


class Air(namedtuple("Air", ["pressure", "temperature"])):
    """Static pressure and temperature of dry air, and what follows from them.

    ``isa(altitude)`` gives the air of the standard atmosphere. ``Air(pressure, temperature)``
    is any other air: that around a JSBSim aircraft (``atmosphere/P-psf`` * 47.880259,
    ``atmosphere/T-R`` / 1.8), or a measurement.

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
        for values that are not positive and finite, and for shapes that do not fit
    """

    __slots__ = ()

    def __new__(cls, pressure: Any, temperature: Any) -> Air:
        pressure, temperature = finite(pressure=pressure, temperature=temperature)
        for parameter, x in (("pressure", pressure), ("temperature", temperature)):
            if not np.all(x > 0):
                raise ParameterError(f"{parameter} must be positive, not {np.min(x):g}",
                                     parameter=parameter, value=x)
        return _air((pressure, temperature))

    @property
    def density(self) -> Any:
        return self.pressure / (R * self.temperature)

    @property
    def speed_of_sound(self) -> Any:
        return (GAMMA * R * self.temperature) ** 0.5

    @property
    def viscosity(self) -> Any:
        t = self.temperature
        return SUTHERLAND_BETA * t * t ** 0.5 / (t + SUTHERLAND_S)


_air = partial(tuple.__new__, Air)  # an Air whose values are known to be good


def isa(altitude: Any, temp_deviation: Any = 0.0, altitude_kind: str = "geometric") -> Air:
    """Air of the International Standard Atmosphere at an altitude.

    The temperature deviation shifts the temperature and leaves the pressure as it is: the
    convention of performance manuals, whose altitude is pressure altitude. JSBSim's
    ``atmosphere/delta-T`` is another one: it integrates the pressure again.

    Parameters
    ----------
    altitude : float or array
        m above mean sea level; valid from -5 km to 80 km. Extrapolated beyond: downwards and up
        to 84.852 km with the last lapse rate, isothermal from there.
    temp_deviation : float or array
        K, added to the standard temperature
    altitude_kind : str
        "geometric" (height) or "geopotential"

    Returns
    -------
    Air
        with ``pressure``, ``temperature``, ``density``, ``speed_of_sound``, ``viscosity``

    Raises
    ------
    ParameterError
        for what is not a finite number, for shapes that do not fit, for an altitude below the
        Earth's centre, and for a deviation that leaves no positive temperature

    Examples
    --------
    >>> round(isa(11_000.0).density, 6)
    0.364801
    """
    altitude, temp_deviation = finite(altitude=altitude, temp_deviation=temp_deviation)
    if one_of("altitude_kind", altitude_kind, ALTITUDE_KINDS) == "geometric":
        altitude = geopotential_altitude(altitude)
    if isinstance(altitude, float):
        pressure, temperature = _in_layer(LAYERS[bisect_right(_TOPS, altitude)], altitude)
    else:
        pressure, temperature = _in_layers(altitude)
    return Air(pressure, temperature + temp_deviation)


def pressure_altitude(pressure: Any, altitude_kind: str = "geometric") -> Any:
    """Altitude in m at which the standard atmosphere has that static pressure in Pa.

    The inverse of ``isa(altitude).pressure``. Flight levels, and pressure altitude by its
    definition, are of the kind "geopotential".

    Raises
    ------
    ParameterError
        for what is not a finite, positive number
    """
    return _altitude_of("pressure", pressure, altitude_kind)


def density_altitude(density: Any, altitude_kind: str = "geometric") -> Any:
    """Altitude in m at which the standard atmosphere has that density in kg/m3.

    The inverse of ``isa(altitude).density``. At a pressure altitude and a temperature deviation
    it is ``density_altitude(isa(altitude, temp_deviation).density)``.

    Raises
    ------
    ParameterError
        for what is not a finite, positive number
    """
    return _altitude_of("density", density, altitude_kind)


def _altitude_of(quantity: str, value: Any, altitude_kind: str) -> Any:
    one_of("altitude_kind", altitude_kind, ALTITUDE_KINDS)
    (x,) = finite(**{quantity: value})
    if not np.all(x > 0):
        raise ParameterError(f"{quantity} must be positive, not {np.min(x):g}",
                             parameter=quantity, value=value)
    base, temperature, pressure, lapse_rate, exponent = _COLUMNS
    at_base = pressure
    if quantity == "density":  # falls as T^(exponent - 1), and as the pressure if isothermal
        at_base = _air((pressure, temperature)).density
        exponent = np.where(lapse_rate, exponent - 1, exponent)
    i = np.searchsorted(-at_base[1:], np.negative(x), side="right")
    power = np.log(x / at_base[i]) / exponent[i]
    with np.errstate(divide="ignore", invalid="ignore"):  # the isothermal branch of the next line
        altitude = base[i] + np.where(
            lapse_rate[i], temperature[i] * np.expm1(power) / lapse_rate[i], power)
    altitude = altitude if np.ndim(x) else float(altitude)
    return geometric_altitude(altitude) if altitude_kind == "geometric" else altitude
