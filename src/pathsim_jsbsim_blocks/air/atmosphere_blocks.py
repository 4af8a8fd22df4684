"""The block ISAtmosphere, and the base class that it shares with the airspeed blocks."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from math import sqrt
from typing import Any, Literal, get_args

from .._core.callers import warn_user
from .._core.checks import finite, one_of, refuse
from .._core.function import NamedFunction
from .._core.parameters import parameter
from .._core.pathsim_internals import values
from ..errors import FlightError, ParameterError
from . import pathsim_flight_types as flight
from .atmosphere import (
    A0,
    ALTITUDE_KINDS,
    EARTH_RADIUS,
    G0,
    GAMMA,
    LAYERS,
    LIMITS,
    P0,
    Air,
    AltitudeKind,
    R,
    pressure_temperature,
    unchecked_air,
    viscosity,
)

OutOfRange = Literal["extrapolate", "clamp", "error"]
OUT_OF_RANGE = get_args(OutOfRange)


@dataclass(eq=False, repr=False)
class AirDataBlock(NamedFunction):
    """Algebraic block with an ``altitude`` port and a rule for altitudes out of range.

    Subclasses define their ports and ``_eval``, which takes the inputs in the order of the ports.
    """

    altitude_kind: AltitudeKind = parameter("geometric", one_of, choices=ALTITUDE_KINDS)
    out_of_range: OutOfRange = parameter("extrapolate", one_of, choices=OUT_OF_RANGE)

    def _begin(self) -> None:
        super()._begin()
        self._warned = False

    def build(self) -> None:
        self._geometric = self.altitude_kind == "geometric"
        self._low, self._high = LIMITS[self.altitude_kind]

    def reset(self) -> None:
        super().reset()
        self._warned = False

    def update(self, t: Any) -> None:
        if self.op_alg.f0 is not None:  # linearized
            super().update(t)
            return
        try:  # Python floats, without the operator between: twice as fast
            self.outputs.update_from_array(self.function(*values(self.inputs)))
        except ParameterError as error:
            message = f"{type(self).__name__} at t = {t} s: {error}"
            raise FlightError(
                message, aircraft="", time=t, name=error.parameter, value=error.value
            ) from error

    def function(self, *inputs: float) -> Any:
        return self._eval(*inputs)  # type: ignore[attr-defined]  # of the subclass

    def _isa(self, altitude: float, temp_deviation: float = 0.0) -> Air:
        if not self._low <= altitude <= self._high:
            altitude = self._beyond(altitude)
        return unchecked_air(pressure_temperature(altitude, temp_deviation, self._geometric))

    def _beyond(self, altitude: float) -> float:
        """The altitude to use when the given one is outside the standard's range."""
        finite(altitude=altitude)
        if self.out_of_range == "clamp":
            return min(max(altitude, self._low), self._high)
        message = (
            f"{self.altitude_kind} altitude {altitude:g} m is outside of the standard "
            f"atmosphere's range, {self._low:.0f} m to {self._high:.0f} m"
        )
        if self.out_of_range == "error" or altitude <= -EARTH_RADIUS:
            refuse("altitude", altitude, message)
        if not self._warned:
            self._warned = True
            warn_user(f"{type(self).__name__}: {message}; extrapolated")
        return altitude


class ISAtmosphere(AirDataBlock, flight.ISAtmosphere):
    r"""International Standard Atmosphere (ICAO Doc 7488/3 = ISO 2533) at an altitude.

    .. math::

        T &= T_b + L (H - H_b), \qquad
        p = p_b \left(\frac{T}{T_b}\right)^{-g_0 / (R L)} \\
        \rho &= \frac{p}{R (T + \Delta T)}, \qquad
        a = \sqrt{\gamma R (T + \Delta T)}

    in each layer of the geopotential altitude ``H``. The temperature deviation shifts the
    temperature but not the pressure, the convention of performance manuals; JSBSim's
    ``atmosphere/delta-T`` recomputes the pressure too.

    Drop-in replacement for pathsim-flight's block of this name: same ports, units and ``_eval``,
    with the standard's exact constants, and viscosity as a fifth output. The plain function is
    ``pathsim_jsbsim_blocks.air.isa``.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height, as ``Aircraft`` gives it) or "geopotential"
        (what a pilot's altimeter shows, set to 1013.25 hPa). At 11,000 m they are 19 m apart: taken
        one for the other, the pressure is 0.3 % wrong
    out_of_range : str
        for an altitude beyond -5 km or 80 km: "extrapolate" (with one warning; with the last
        lapse rates, from 84.852 km up isothermally), "clamp" (to that limit) or "error"

    Inputs
    ------
    altitude
        above mean sea level, m
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    pressure
        static, Pa
    density
        kg/m3
    temperature
        static, K
    speed_of_sound
        m/s
    viscosity
        dynamic (Sutherland), Pa s

    Raises
    ------
    FlightError
        during the run, if an input is not finite, the temperature is not positive, the altitude
        is below the Earth's centre, or it is out of range and ``out_of_range`` is "error"
    """

    input_port_labels = {"altitude": 0, "temp_deviation": 1}
    output_port_labels = {
        "pressure": 0,
        "density": 1,
        "temperature": 2,
        "speed_of_sound": 3,
        "viscosity": 4,
    }

    R = R
    g0 = G0
    gamma = GAMMA
    r0 = EARTH_RADIUS
    StdSL_pressure = P0
    StdSL_speed_of_sound = A0
    atmosphere_bands = [
        flight.ISAtmosphere.AtmosphereBand(
            layer.base, upper.base, layer.temperature, layer.pressure, round(layer.lapse_rate, 9)
        )
        for layer, upper in pairwise(LAYERS)
    ]

    def _eval(self, altitude: float, temp_deviation: float = 0.0) -> tuple[float, ...]:
        if not self._low <= altitude <= self._high:
            altitude = self._beyond(altitude)
        pressure, temperature = pressure_temperature(altitude, temp_deviation, self._geometric)
        rt = R * temperature
        return pressure, pressure / rt, temperature, sqrt(GAMMA * rt)

    def function(self, *inputs: float) -> tuple[float, ...]:
        pressure, density, temperature, speed_of_sound = self._eval(*inputs)
        return pressure, density, temperature, speed_of_sound, viscosity(temperature)
