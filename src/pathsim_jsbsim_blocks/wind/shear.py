"""Wind shear near the ground: the logarithmic profile of MIL-F-8785C."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from .._core.checks import finite, heading, number
from .._core.function import NamedFunction
from .._core.parameters import parameter
from .._core.units import KNOT

_REFERENCE_HEIGHT = 20.0  # ft
_TOP = 1000.0  # ft, maximum height of the specification's profile

_speed = partial(number, low=0.0, high=1e3)  # kt
# ft; from smoother than ice to below the reference height
_roughness = partial(number, above=0.0, low=1e-6, high=math.nextafter(_REFERENCE_HEIGHT, 0.0))


def logarithmic_profile(h: Any, wind_20ft: float = 15.0, roughness: float = 0.15) -> Any:
    """Speed of the mean wind at a height above the terrain.

    The logarithmic profile of MIL-F-8785C, 3.7.3; see `WindShear`.

    Parameters
    ----------
    h : float or array
        height above the terrain, ft
    wind_20ft : float
        wind speed at 20 ft, kt
    roughness : float
        roughness length z_0, below 20 ft: 0.15 ft for terminal flight phases (category C), 2 ft
        for others

    Returns
    -------
    float or array
        kt

    Raises
    ------
    ParameterError
        for a negative wind speed, a roughness out of its range, values that are not finite
    """
    (h,) = finite(h=h)
    low, speed = _roughness("roughness", roughness), _speed("wind_20ft", wind_20ft)
    speed = speed * np.log(np.clip(h, low, _TOP) / low) / math.log(_REFERENCE_HEIGHT / low)
    return speed if np.ndim(speed) else float(speed)


@dataclass(eq=False, repr=False)
class WindShear(NamedFunction):
    """Mean wind that grows with the logarithm of the height, for the aircraft's wind ports.

    .. math::
        u = W_{20} \\frac{\\ln(h / z_0)}{\\ln(20 \\, \\mathrm{ft} / z_0)}

    The speed is 0 below z_0 and constant above 1000 ft.

    Parameters
    ----------
    wind_20ft : float
        wind speed at 20 ft above the terrain, kt
    direction : float
        true direction that the wind blows from, deg
    roughness : float
        roughness length z_0, below 20 ft: 0.15 ft for terminal flight phases (category C), 2 ft
        for others
    terrain : float
        elevation of the terrain above mean sea level, ft

    Inputs
    ------
    h
        altitude above mean sea level, ft

    Outputs
    -------
    north, east
        velocity of the air, ft/s

    Raises
    ------
    ParameterError
        for a negative wind speed, a roughness out of its range, values that are not finite

    References
    ----------
    MIL-F-8785C, *Flying Qualities of Piloted Airplanes*, 1980, 3.7.3.
    """

    wind_20ft: float = parameter(15.0, _speed)
    direction: float = parameter(0.0, heading)
    roughness: float = parameter(0.15, _roughness)
    terrain: float = parameter(0.0, number)

    is_wind = True
    input_port_labels = {"h": 0}
    output_port_labels = {"north": 0, "east": 1}
    # inputs that must be connected
    _places = ("h",)

    def function(self, h: float) -> tuple[float, float]:
        height = number("h", h) - self._checked.terrain
        speed = KNOT * logarithmic_profile(height, self.wind_20ft, self.roughness)
        psi = math.radians(self._checked.direction)
        return -speed * math.cos(psi), -speed * math.sin(psi)
