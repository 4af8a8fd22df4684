"""Airspeeds for limits, without compressibility if the error does not matter to them."""

from __future__ import annotations

import math

from .._core.units import KNOT

# ISA, troposphere: 1 / sqrt(density ratio) = (1 - L h)^-2.128, pressure ratio (1 - L h)^5.2559;
# tropopause at 36,089 ft, above it the pressure falls by 1/e in 20,806 ft
_LAPSE, _EXPONENT, _PRESSURE, _TROPOPAUSE, _SCALE = 6.8756e-6, -2.128, 5.2559, 36_089.0, 20_806.0
_SONIC = 661.479  # kt, at sea level


def true_airspeed(vc: float, h: float) -> float:
    """True airspeed in ft/s from calibrated airspeed (kt) and altitude (ft), for limits.

    Without compressibility and for ISA: 3 % high at Mach 0.5, 10 % at 0.8.
    """
    return vc * KNOT * (1.0 - _LAPSE * min(h, _TROPOPAUSE)) ** _EXPONENT


def fastest_airspeed(vmo: float, mmo: float, h: float) -> float:
    """The lower of two airspeeds in kt, one calibrated and one as a Mach number, for ISA."""
    pressure = (1.0 - _LAPSE * min(h, _TROPOPAUSE)) ** _PRESSURE
    pressure *= math.exp(-max(h - _TROPOPAUSE, 0.0) / _SCALE)
    impact = pressure * ((1.0 + 0.2 * mmo * mmo) ** 3.5 - 1.0)
    return min(vmo, _SONIC * (5.0 * ((1.0 + impact) ** (2.0 / 7.0) - 1.0)) ** 0.5)
