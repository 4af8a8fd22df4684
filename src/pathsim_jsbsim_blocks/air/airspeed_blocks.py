"""Blocks that convert between calibrated, equivalent and true airspeed and Mach number.

They wrap the functions of ``airspeed``, in the standard atmosphere at an altitude. Those that
pathsim-flight also has are drop-in replacements for its blocks.
"""

from __future__ import annotations

from collections.abc import Callable
from inspect import cleandoc
from textwrap import indent
from typing import Any, ClassVar

from . import airspeed
from . import pathsim_flight_types as flight
from .atmosphere_blocks import AirDataBlock

# quantities by port
_PORTS = {
    "cas": "calibrated airspeed, m/s",
    "eas": "equivalent airspeed, m/s",
    "tas": "true airspeed, m/s",
    "mach": "Mach number",
    "altitude": "altitude in m: geometric, or pressure altitude if ``altitude_kind`` is "
    '"geopotential"',
    "temp_deviation": "from the standard temperature, K",
}

# how each airspeed follows from the Mach number
_FORMULAS = {
    "cas": r"p_0 f(CAS / a_0) = p f(M)",
    "eas": r"EAS = M a_0 \sqrt{p / p_0} = TAS \sqrt{\rho / \rho_0}",
    "tas": "TAS = M a",
    "mach": "",
}

_PITOT = """
f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above.
A perfect gas: valid to about Mach 5."""

_PAGE = """\
{text}

.. math::

    {formulas}
{notes}
A negative speed stays negative.

Parameters
----------
altitude_kind : str
    what the altitude input is: "geometric" (height, as ``Aircraft`` gives it) or "geopotential"
    (what a pilot's altimeter shows, set to 1013.25 hPa). At 11,000 m they are 19 m apart: taken one
    for the other, a CAS of 100 m/s gives a TAS that is 0.19 m/s wrong
out_of_range : str
    beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

Inputs
------
{inputs}

Outputs
-------
{outputs}

Raises
------
FlightError
    during the run, if an input is not finite, or an altitude is out of range and
    ``out_of_range`` is "error"
"""


class _Conversion(AirDataBlock):
    """Base of the blocks named SOURCEtoTARGET: ports, function and page follow from the name."""

    _convert: ClassVar[Callable[..., float]]

    def __init_subclass__(cls, **keywords: Any) -> None:
        if _Conversion in cls.__bases__:  # a user's subclass may have any name
            cls._complete()
        super().__init_subclass__(**keywords)

    @classmethod
    def _complete(cls) -> None:
        source, target = sides = cls.__name__.lower().split("to")
        # the temperature enters only in TAS
        inputs = [source, "altitude", *(["temp_deviation"] if "tas" in sides else [])]
        cls.input_port_labels = {name: i for i, name in enumerate(inputs)}
        cls.output_port_labels = {target: 0}
        cls._convert = staticmethod(getattr(airspeed, f"{source}_to_{target}"))
        if cls.__doc__:  # absent under python -OO
            formulas = r", \quad ".join(filter(None, map(_FORMULAS.get, sides)))
            page = _PAGE.format(
                text=cleandoc(cls.__doc__),
                formulas=formulas,
                notes="\nIndex 0 is sea level." * ("_0" in formulas) + _PITOT * ("cas" in sides),
                inputs="\n".join(f"{name}\n    {_PORTS[name]}" for name in inputs),
                outputs=f"{target}\n    {_PORTS[target]}",
            )
            # indented, as other docstrings are
            cls.__doc__ = indent(page, "    ").lstrip()

    def _eval(self, speed: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return self._convert(speed, self._isa(altitude, temp_deviation))

    function = _eval  # type: ignore[assignment]


class EAStoTAS(_Conversion, flight.EAStoTAS):
    """True airspeed (TAS) at an equivalent airspeed (EAS) and an altitude."""


class EAStoMach(_Conversion):
    """Mach number at an equivalent airspeed (EAS) and an altitude."""


class TAStoEAS(_Conversion):
    """Equivalent airspeed (EAS) at a true airspeed (TAS) and an altitude."""


class TAStoMach(_Conversion):
    """Mach number at a true airspeed (TAS) and an altitude."""


class MachtoEAS(_Conversion):
    """Equivalent airspeed (EAS) at a Mach number and an altitude."""


class MachtoTAS(_Conversion):
    """True airspeed (TAS) at a Mach number and an altitude."""


class CAStoEAS(_Conversion, flight.CAStoEAS):
    """Equivalent airspeed (EAS) at a calibrated airspeed (CAS) and an altitude."""


class CAStoTAS(_Conversion, flight.CAStoTAS):
    """True airspeed (TAS) at a calibrated airspeed (CAS) and an altitude."""


class CAStoMach(_Conversion, flight.CAStoMach):
    """Mach number at a calibrated airspeed (CAS) and an altitude."""


class EAStoCAS(_Conversion):
    """Calibrated airspeed (CAS) at an equivalent airspeed (EAS) and an altitude."""


class TAStoCAS(_Conversion, flight.TAStoCAS):
    """Calibrated airspeed (CAS) at a true airspeed (TAS) and an altitude."""


class MachtoCAS(_Conversion, flight.MachtoCAS):
    """Calibrated airspeed (CAS) at a Mach number and an altitude."""
