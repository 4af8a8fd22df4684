"""Units: `convert` for numbers and arrays, `UnitConversion` for signals."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ._core.function import NamedFunction
from ._core.units import conversion, convert

__all__ = ["UnitConversion", "convert"]


@dataclass(eq=False, repr=False)
class UnitConversion(NamedFunction):
    """Converts a signal from one unit to another, by exact factors.

    Aircraft ports use ft, ft/s, kt and deg; air-data blocks use SI units.

    .. math::
        y = \\frac{a_s u + b_s - b_t}{a_t}

    with factor a and offset b to SI of the source unit s and the target unit t.

    Parameters
    ----------
    source : str
        unit of the input: m, km, ft, in, nmi, mi; m/s, km/h, kt, ft/s, ft/min, mph; m/s2, ft/s2, g;
        rad, deg; rad/s, deg/s, rpm; kg, lb, slug; kg*m2, slug*ft2; N, kN, lbf; N*m, ft*lbf; W, kW,
        hp; Pa, hPa, psf, psi; kg/m3, slug/ft3; K, degC, degF, degR; s, min, h
    target : str
        unit of the output, one of the same quantity

    Inputs
    ------
    in
        value in the source unit

    Outputs
    -------
    out
        value in the target unit

    Raises
    ------
    ParameterError
        for an unknown unit, naming the nearest, and for units of different quantities

    References
    ----------
    Thompson and Taylor, *Guide for the Use of the International System of Units*, NIST SP 811, 2008

    Examples
    --------
    >>> conversion("kt", "km/h")
    (1.852, 0.0)
    """

    source: str = "ft"
    target: str = "m"

    input_port_labels = {"in": 0}
    output_port_labels = {"out": 0}

    def build(self) -> None:
        self._factor, self._offset = conversion(self.source, self.target)

    def function(self, u: Any) -> Any:
        return self._factor * u + self._offset
