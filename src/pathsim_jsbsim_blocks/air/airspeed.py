"""Conversions between calibrated, equivalent and true airspeed and Mach number.

Each takes a speed and the ambient air: ``cas_to_tas(120.0, isa(5000.0))`` in the
standard atmosphere, ``cas_to_tas(120.0, Air(pressure, temperature))`` in any other. Speeds are in
m/s. Floats in give floats out; arrays broadcast. A negative speed stays negative.

The impact pressure qc at a static pressure p is that of a pitot tube::

    M <= 1:  qc/p = (1 + 0.2 M^2)^3.5 - 1                  isentropic compression
    M > 1:   qc/p = 166.9216 M^7 / (7 M^2 - 1)^2.5 - 1     behind a normal shock (Rayleigh)

CAS is the speed that has the same qc at sea level, where M = CAS/a0 and p = p0. From Mach follow
EAS = M a0 sqrt(p/p0) and TAS = M a. The temperature enters only in TAS.

References
----------
Aiken, NACA Report 837 (1946); Olson, Aircraft Performance Flight Testing, AFFTC-TIH-99-01,
sections 4.6 to 4.8.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._core.checks import finite, must_be, refuse
from .atmosphere import A0, P0, Air, AltitudeKind, positive_finite, pressure_altitude

RAYLEIGH = 1.2**3.5 * (6 / 7) ** 2.5  # of qc/p + 1 = RAYLEIGH x (1 - 1/(7 x))^-2.5, x = M^2
SONIC = 1.2**3.5 - 1  # qc/p at Mach 1, in both formulas


def _impact_ratio(mach: Any) -> Any:
    """qc/p at Mach numbers of either sign."""
    return _either_side(mach * mach, 1.0, _isentropic, _rayleigh)


def _mach_number(ratio: Any) -> Any:
    """The positive Mach numbers at a qc/p."""
    return _either_side(ratio, SONIC, _isentropic_inverse, _rayleigh_inverse) ** 0.5


def _either_side(x: Any, limit: float, low: Any, high: Any) -> Any:
    """The values of ``low`` up to a limit, of ``high`` beyond."""
    if isinstance(x, float):
        return low(x, math) if x <= limit else high(x)
    y, supersonic = low(x, np), x > limit
    y[supersonic] = high(x[supersonic])
    return y


# expm1 and log1p, of math or numpy, keep all digits at low speed
def _isentropic(x: Any, m: Any) -> Any:
    return m.expm1(3.5 * m.log1p(0.2 * x))


def _isentropic_inverse(ratio: Any, m: Any) -> Any:
    return 5 * m.expm1(m.log1p(ratio) / 3.5)


def _rayleigh(x: Any) -> Any:
    return RAYLEIGH * x * (1 - 1 / (7 * x)) ** -2.5 - 1


def _rayleigh_inverse(ratio: Any) -> Any:
    """x = M^2 > 1 at a qc/p > SONIC: Newton's method, exact to rounding after four steps."""
    z = (ratio + 1) / RAYLEIGH
    b = z - 5 / 14  # x (1 - 1/(7 x))^-2.5 = x + 5/14 + (5/56)/x + ...
    x = (b + (b * b - 5 / 14) ** 0.5) / 2
    for _ in range(4):
        u = 1 - 1 / (7 * x)
        x = x - (x - z * u**2.5) * u / (1 - 0.5 / x)
    return x


def _at_other_pressure(mach: Any, ratio: Any) -> Any:
    """The Mach number with the impact pressure of ``mach`` at p divided by ``ratio``."""
    result = _mach_number(_impact_ratio(mach) * ratio)
    return (math if isinstance(result, float) else np).copysign(result, mach)


def _speed(parameter: str, value: Any, air: Air) -> Any:
    """``value`` as a finite float, or as a float array that broadcasts with the air."""
    if not isinstance(air, Air):
        must_be("air", air, "an Air: isa(altitude) or Air(pressure, temperature)")
    if type(value) is float and math.isfinite(value):
        return value
    return finite(**{parameter: value, **air._asdict()})[0]


def cas_to_mach(cas: Any, air: Air) -> Any:
    """Mach number at a calibrated airspeed in m/s."""
    return _at_other_pressure(_speed("cas", cas, air) / A0, P0 / air.pressure)


def cas_to_eas(cas: Any, air: Air) -> Any:
    """Equivalent airspeed in m/s at a calibrated airspeed in m/s."""
    return mach_to_eas(cas_to_mach(cas, air), air)


def cas_to_tas(cas: Any, air: Air) -> Any:
    """True airspeed in m/s at a calibrated airspeed in m/s."""
    return cas_to_mach(cas, air) * air.speed_of_sound


def eas_to_mach(eas: Any, air: Air) -> Any:
    """Mach number at an equivalent airspeed in m/s."""
    return _speed("eas", eas, air) / (A0 * (air.pressure / P0) ** 0.5)


def eas_to_cas(eas: Any, air: Air) -> Any:
    """Calibrated airspeed in m/s at an equivalent airspeed in m/s."""
    return mach_to_cas(eas_to_mach(eas, air), air)


def eas_to_tas(eas: Any, air: Air) -> Any:
    """True airspeed in m/s at an equivalent airspeed in m/s."""
    return eas_to_mach(eas, air) * air.speed_of_sound


def tas_to_mach(tas: Any, air: Air) -> Any:
    """Mach number at a true airspeed in m/s."""
    return _speed("tas", tas, air) / air.speed_of_sound


def tas_to_cas(tas: Any, air: Air) -> Any:
    """Calibrated airspeed in m/s at a true airspeed in m/s."""
    return mach_to_cas(tas_to_mach(tas, air), air)


def tas_to_eas(tas: Any, air: Air) -> Any:
    """Equivalent airspeed in m/s at a true airspeed in m/s."""
    return mach_to_eas(tas_to_mach(tas, air), air)


def mach_to_cas(mach: Any, air: Air) -> Any:
    """Calibrated airspeed in m/s at a Mach number."""
    return A0 * _at_other_pressure(_speed("mach", mach, air), air.pressure / P0)


def mach_to_eas(mach: Any, air: Air) -> Any:
    """Equivalent airspeed in m/s at a Mach number."""
    return _speed("mach", mach, air) * (A0 * (air.pressure / P0) ** 0.5)


def mach_to_tas(mach: Any, air: Air) -> Any:
    """True airspeed in m/s at a Mach number."""
    return _speed("mach", mach, air) * air.speed_of_sound


def impact_pressure(mach: Any, air: Air) -> Any:
    """Impact pressure in Pa, total behind the pitot tube's shock minus static, at a Mach number."""
    return _impact_ratio(_speed("mach", mach, air)) * air.pressure


def dynamic_pressure(mach: Any, air: Air) -> Any:
    """Dynamic pressure in Pa, ``0.7 p M^2 = rho TAS^2 / 2``, at a Mach number."""
    mach = _speed("mach", mach, air)
    return 0.7 * air.pressure * (mach * mach)


def crossover_altitude(cas: Any, mach: Any, altitude_kind: AltitudeKind = "geometric") -> Any:
    """Altitude in m at which a CAS in m/s and a Mach number are the same speed.

    A climb at constant CAS changes to constant Mach there: above, the CAS would exceed the Mach
    number. It depends on the pressure only; as a flight level it is of the kind "geopotential".

    Raises
    ------
    ParameterError
        if a value is not finite and positive, the shapes do not broadcast, or no pressure has both
        speeds
    """
    cas, mach = positive_finite(cas=cas, mach=mach)
    with np.errstate(all="ignore"):
        pressure = np.divide(P0 * _impact_ratio(cas / A0), _impact_ratio(mach))
    if not np.all(np.isfinite(pressure) & (pressure > 0.0)):
        refuse("mach", mach, f"no altitude has a CAS of {cas} m/s at Mach {mach}")
    return pressure_altitude(pressure, altitude_kind)
