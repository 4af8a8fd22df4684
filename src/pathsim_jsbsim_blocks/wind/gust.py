"""Discrete 1-cosine gust, and the gust velocities of the transport category."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from .._core.checks import number, one_of, optional, positive, refuse
from .._core.parameters import parameter
from .._core.pathsim_internals import WiredRegister
from .._core.units import FOOT
from ..air import isa
from ..sources import _EdgeSource, polarity_of

# altitude in ft, reference gust velocity in ft/s EAS from the design speed for maximum gust
# intensity to the design cruising speed: 14 CFR 25.341(a)(5)(i), amendment 25-141
_REFERENCE = ((0.0, 15000.0, 60000.0), (56.0, 44.0, 20.86))
# limits of the gradient in the rule, rounded separately in each unit
_FEET, _METRES = (30.0, 350.0), (9.0, 107.0)


def design_gust_velocity(gradient: float, altitude: float, alleviation: float = 1.0) -> float:
    """Design gust velocity of CS-25 and 14 CFR part 25 in ft/s, true.

    .. math::
        U_\\mathrm{ds} = U_\\mathrm{ref} F_g \\left(\\frac{H}{350 \\, \\mathrm{ft}}\\right)^{1/6}
        \\sqrt{\\rho_0 / \\rho}

    with U_ref = 56 ft/s EAS at sea level, 44 at 15,000 ft and 20.86 at 60,000 ft, linear in
    between. At the design dive speed the gust has half this velocity.

    Parameters
    ----------
    gradient : float
        gust gradient distance H, the length of the rise, 30 to 350 ft
    altitude : float
        pressure altitude in the standard atmosphere, 0 to 60,000 ft
    alleviation : float
        flight profile alleviation factor F_g, at most 1

    Returns
    -------
    float
        ft/s true

    Raises
    ------
    ParameterError
        for values outside these ranges

    References
    ----------
    14 CFR 25.341(a), CS 25.341(a).

    Examples
    --------
    >>> round(design_gust_velocity(350.0, 0.0), 2)
    56.0
    """
    gradient = number("gradient", gradient, low=_FEET[0], high=_FEET[1])
    altitude = number("altitude", altitude, low=0.0, high=_REFERENCE[0][-1])
    alleviation = number("alleviation", alleviation, above=0.0, high=1.0)
    reference = float(np.interp(altitude, *_REFERENCE))
    density = isa(altitude * FOOT, altitude_kind="geopotential").density / isa(0.0).density
    return reference * alleviation * (gradient / 350.0) ** (1 / 6) / math.sqrt(density)


@dataclass(eq=False, repr=False)
class OneMinusCosineGust(_EdgeSource):
    """Discrete gust of the 1-cosine shape, with the lengths and velocities of CS 25.341.

    A positive gust has the direction of the connected port: **down** at ``wind_down``, as in
    MIL-F-8785C. The upward gust of CS 25.341, which raises nz, has polarity -1 at that port.

    .. math::
        U = \\frac{U_\\mathrm{ds}}{2} \\left(1 - \\cos\\frac{\\pi s}{H}\\right), \\qquad
        0 \\le s = V (t - t_\\mathrm{start}) \\le 2 H

    and 0 before and after. V is the true airspeed at the start of the gust.

    Parameters
    ----------
    gradient : float
        gust gradient distance H, the length of the rise, in ``unit``; half of the gust's length
    airspeed : float, optional
        true airspeed V, ft/s; default: the port ``vt`` at the start of the gust
    altitude : float
        pressure altitude in ft, for the design gust velocity
    amplitude : float, optional
        peak velocity U_ds in ft/s true; default: ``wind.design_gust_velocity`` of the gradient and
        the altitude
    start : float
        time in s at which the gust begins
    polarity : float
        sign of the gust, 1 or -1
    unit : str
        unit of the gradient, "ft" or "m"

    Inputs
    ------
    vt
        true airspeed in ft/s, read as the gust begins; not read if ``airspeed`` is given

    Outputs
    -------
    gust
        velocity of the air, ft/s

    Raises
    ------
    ParameterError
        for a length or an airspeed that is not positive, a polarity other than 1 and -1, and,
        without an amplitude, a gradient outside 30 to 350 ft (9 to 107 m) or an altitude outside
        0 to 60,000 ft; at the start of a run, without ``airspeed`` and a connection to ``vt``

    References
    ----------
    14 CFR 25.341(a), CS 25.341(a).
    """

    gradient: float = parameter(350.0, positive)
    airspeed: float | None = parameter(None, optional, above=0.0)
    altitude: float = parameter(0.0, number)
    amplitude: float | None = parameter(None, optional)
    start: float = parameter(1.0, number, low=0.0)
    polarity: float = parameter(1, polarity_of)
    unit: Literal["ft", "m"] = parameter("ft", one_of, choices=("ft", "m"))

    is_wind = True
    input_port_labels = {"vt": 0}
    output_port_labels = {"gust": 0}

    _vt = 0.0  # true airspeed at the port at the start of the gust, ft/s

    def _begin(self) -> None:
        super()._begin()
        self.inputs = WiredRegister(1, dict(self.input_port_labels))

    @property
    def length(self) -> float:
        """The gradient distance in ft."""
        return self.gradient / FOOT if self.unit == "m" else self.gradient

    @property
    def peak(self) -> float:
        """Velocity at the middle of the gust, ft/s."""
        peak = self._checked.amplitude
        if peak is None:
            low, high = _METRES if self.unit == "m" else _FEET
            number("gradient", self.gradient, low=low, high=high)
            length = min(max(self.length, _FEET[0]), _FEET[1])
            peak = design_gust_velocity(length, self.altitude)
        return self._checked.polarity * peak

    def _speed(self) -> float:
        """True airspeed of the gust, ft/s; 0 before the gust reads it from the port."""
        return self._checked.airspeed or self._vt

    def _edge_times(self) -> list[float]:
        start, speed, self._peak = self._checked.start, self._speed(), self.peak
        return [start, start + 2 * self.length / speed] if speed else [start]

    def _at_edge(self, t: float) -> None:
        if self.airspeed is None and self.passed == 1:
            self._vt = positive("airspeed", float(self.inputs[0]))
            self._times = self._edge_times()
        super()._at_edge(t)

    def reset(self) -> None:
        self._vt = 0.0
        self._times = self._edge_times()
        super().reset()

    def update(self, t: float) -> None:
        if self.airspeed is None and not self.inputs.wired:
            why = "a gust requires an airspeed: give airspeed in ft/s, or connect the port vt"
            refuse("airspeed", None, why)
        y = 0.0
        if self.passed == 1:
            # stay within the gust if a parameter is edited during it
            s = min(max(self._speed() * (t - self.start), 0.0), 2 * self.length)
            y = self._peak / 2 * (1 - math.cos(math.pi * s / self.length))
        self.outputs[0] = y
