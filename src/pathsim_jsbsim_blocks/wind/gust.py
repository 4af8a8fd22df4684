"""Discrete 1-cosine gust, and the gust velocities of the transport category."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .._core.checks import number, optional, positive
from .._core.parameters import parameter
from .._core.units import FOOT
from ..air import isa
from ..sources import _EdgeSource, polarity_of

# altitude in ft, reference gust velocity in ft/s EAS between the design cruising speed and that of
# maximum gust intensity: 14 CFR 25.341(a)(5)(i), amendment 25-141
_REFERENCE = ((0.0, 15000.0, 60000.0), (56.0, 44.0, 20.86))


def design_gust_velocity(gradient: float, altitude: float, alleviation: float = 1.0) -> float:
    """Design gust velocity of CS-25 and 14 CFR part 25 in ft/s, true.

    .. math::
        U_\\mathrm{ds} = U_\\mathrm{ref} F_g \\left(\\frac{H}{350 \\, \\mathrm{ft}}\\right)^{1/6}
        \\sqrt{\\rho_0 / \\rho}

    with U_ref = 56 ft/s EAS at sea level, 44 at 15,000 ft and 20.86 at 60,000 ft, linear between.
    At the design diving speed it is half of this.

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
        for values out of these ranges

    References
    ----------
    14 CFR 25.341(a), CS 25.341(a).

    Examples
    --------
    >>> round(design_gust_velocity(350.0, 0.0), 2)
    56.0
    """
    gradient = number("gradient", gradient, low=30.0, high=350.0)
    altitude = number("altitude", altitude, low=0.0, high=_REFERENCE[0][-1])
    alleviation = number("alleviation", alleviation, above=0.0, high=1.0)
    reference = float(np.interp(altitude, *_REFERENCE))
    density = isa(altitude * FOOT, altitude_kind="geopotential").density / isa(0.0).density
    return reference * alleviation * (gradient / 350.0) ** (1 / 6) / math.sqrt(density)


@dataclass(eq=False, repr=False)
class OneMinusCosineGust(_EdgeSource):
    """Discrete gust of the 1-cosine shape, with the lengths and velocities of CS 25.341.

    .. math::
        U = \\frac{U_\\mathrm{ds}}{2} \\left(1 - \\cos\\frac{\\pi s}{H}\\right), \\qquad
        0 \\le s = V (t - t_\\mathrm{start}) \\le 2 H

    and 0 before and after. Wired to ``wind_down`` of an aircraft, a gust of polarity -1 is an
    upward one, which raises nz.

    Parameters
    ----------
    gradient : float
        gust gradient distance H, the length of the rise, ft; half of the gust's length
    airspeed : float
        true airspeed V at which the gust is met, ft/s
    altitude : float
        ft, for the design gust velocity
    amplitude : float, optional
        peak velocity U_ds in ft/s true; default: ``wind.design_gust_velocity`` of the gradient and
        the altitude
    start : float
        time at which the gust begins in s
    polarity : float
        sign of the gust, 1 or -1

    Outputs
    -------
    gust
        velocity of the air, ft/s

    Raises
    ------
    ParameterError
        for a length or an airspeed that is not positive, a polarity other than 1 and -1, and
        without an amplitude a gradient outside of 30 to 350 ft or an altitude outside of 0 to
        60,000 ft

    References
    ----------
    14 CFR 25.341(a), CS 25.341(a).
    """

    gradient: float = parameter(350.0, positive)
    airspeed: float = parameter(300.0, positive)
    altitude: float = parameter(0.0, number)
    amplitude: float | None = parameter(None, optional)
    start: float = parameter(1.0, number, low=0.0)
    polarity: float = parameter(1, polarity_of)

    is_wind = True
    output_port_labels = {"gust": 0}

    @property
    def peak(self) -> float:
        """Velocity at the middle of the gust, ft/s."""
        peak = self._checked.amplitude
        if peak is None:
            peak = design_gust_velocity(self.gradient, self.altitude)
        return self._checked.polarity * peak

    def _edge_times(self) -> list[float]:
        c, self._peak = self._checked, self.peak
        return [c.start, c.start + 2 * c.gradient / c.airspeed]

    def update(self, t: float) -> None:
        y = 0.0
        if self.passed == 1:
            # within the gust, also where a parameter was edited in the middle of it
            s = min(max(self.airspeed * (t - self.start), 0.0), 2 * self.gradient)
            y = self._peak / 2 * (1 - math.cos(math.pi * s / self.gradient))
        self.outputs[0] = y
