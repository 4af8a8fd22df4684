"""Blocks that convert between calibrated, equivalent and true airspeed and Mach number.

They wrap the functions of ``airspeed``, in the standard atmosphere at an altitude. Those that
pathsim-flight also has are drop-in replacements for its blocks.
"""

from __future__ import annotations

from inspect import cleandoc
from textwrap import indent
from typing import TypeVar

import pathsim_flight.utils as flight

from . import airspeed
from .atmosphere_blocks import AirDataBlock

Converter = TypeVar("Converter", bound=type[AirDataBlock])

# quantities by the names of their ports
_PORTS = {
    "cas": "calibrated airspeed, m/s",
    "eas": "equivalent airspeed, m/s",
    "tas": "true airspeed, m/s",
    "mach": "Mach number",
    "altitude": "altitude in m: a height, or pressure altitude where ``altitude_kind`` is "
    '"geopotential"',
    "temp_deviation": "from the standard temperature, K",
}

_PITOT = """\
with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
A perfect gas: valid to about Mach 5. A negative speed stays negative."""

_PAGE = """\
{text}

Parameters
----------
altitude_kind : str
    what the altitude input is: "geometric" (height) or "geopotential"
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


def _conversion(block: Converter) -> Converter:
    """Complete the docstring of a block by what all have, and by its ports."""

    def described(labels: dict[str, int]) -> str:
        return "\n".join(f"{name}\n    {_PORTS[name]}" for name in labels)

    if block.__doc__:  # absent under python -OO
        page = _PAGE.format(
            text=cleandoc(block.__doc__).replace("%(pitot)s", _PITOT),
            inputs=described(block.input_port_labels),
            outputs=described(block.output_port_labels),
        )
        # indented, as other docstrings are
        block.__doc__ = indent(page, "    ").lstrip()
    return block


@_conversion
class EAStoTAS(AirDataBlock, flight.EAStoTAS):
    r"""True airspeed (TAS) at an equivalent airspeed (EAS) and an altitude.

    .. math::

        TAS = EAS \sqrt{\rho_0 / \rho} = \frac{EAS}{a_0} \sqrt{p_0 / p}\, a

    Index 0 is sea level. A negative speed stays negative.
    """

    input_port_labels = {"eas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, eas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.eas_to_tas(eas, self._isa(altitude, temp_deviation))


@_conversion
class EAStoMach(AirDataBlock):
    r"""Mach number at an equivalent airspeed (EAS) and an altitude.

    .. math::

        M = \frac{EAS}{a_0} \sqrt{p_0 / p}

    Index 0 is sea level. A negative speed stays negative.
    """

    input_port_labels = {"eas": 0, "altitude": 1}
    output_port_labels = {"mach": 0}

    def _eval(self, eas: float, altitude: float) -> float:
        return airspeed.eas_to_mach(eas, self._isa(altitude))


@_conversion
class TAStoEAS(AirDataBlock):
    r"""Equivalent airspeed (EAS) at a true airspeed (TAS) and an altitude.

    .. math::

        EAS = TAS \sqrt{\rho / \rho_0} = \frac{TAS}{a} a_0 \sqrt{p / p_0}

    Index 0 is sea level. A negative speed stays negative.
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"eas": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_eas(tas, self._isa(altitude, temp_deviation))


@_conversion
class TAStoMach(AirDataBlock):
    """Mach number at a true airspeed (TAS) and an altitude.

    .. math::

        M = TAS / a

    A negative speed stays negative.
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"mach": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_mach(tas, self._isa(altitude, temp_deviation))


@_conversion
class MachtoEAS(AirDataBlock):
    r"""Equivalent airspeed (EAS) at a Mach number and an altitude.

    .. math::

        EAS = M a_0 \sqrt{p / p_0}

    Index 0 is sea level. A negative speed stays negative.
    """

    input_port_labels = {"mach": 0, "altitude": 1}
    output_port_labels = {"eas": 0}

    def _eval(self, mach: float, altitude: float) -> float:
        return airspeed.mach_to_eas(mach, self._isa(altitude))


@_conversion
class MachtoTAS(AirDataBlock):
    """True airspeed (TAS) at a Mach number and an altitude.

    .. math::

        TAS = M a

    A negative speed stays negative.
    """

    input_port_labels = {"mach": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, mach: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.mach_to_tas(mach, self._isa(altitude, temp_deviation))


@_conversion
class CAStoEAS(AirDataBlock, flight.CAStoEAS):
    r"""Equivalent airspeed (EAS) at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0), \qquad EAS = M a_0 \sqrt{p / p_0}

    %(pitot)s
    """

    input_port_labels = {"cas": 0, "altitude": 1}
    output_port_labels = {"eas": 0}

    def _eval(self, cas: float, altitude: float) -> float:
        return airspeed.cas_to_eas(cas, self._isa(altitude))


@_conversion
class CAStoTAS(AirDataBlock, flight.CAStoTAS):
    r"""True airspeed (TAS) at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0), \qquad TAS = M a

    %(pitot)s
    """

    input_port_labels = {"cas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, cas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.cas_to_tas(cas, self._isa(altitude, temp_deviation))


@_conversion
class CAStoMach(AirDataBlock, flight.CAStoMach):
    """Mach number at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0)

    %(pitot)s
    """

    input_port_labels = {"cas": 0, "altitude": 1}
    output_port_labels = {"mach": 0}

    def _eval(self, cas: float, altitude: float) -> float:
        return airspeed.cas_to_mach(cas, self._isa(altitude))


@_conversion
class EAStoCAS(AirDataBlock):
    r"""Calibrated airspeed (CAS) at an equivalent airspeed (EAS) and an altitude.

    .. math::

        M = \frac{EAS}{a_0} \sqrt{p_0 / p}, \qquad p_0 f(CAS / a_0) = p f(M)

    %(pitot)s
    """

    input_port_labels = {"eas": 0, "altitude": 1}
    output_port_labels = {"cas": 0}

    def _eval(self, eas: float, altitude: float) -> float:
        return airspeed.eas_to_cas(eas, self._isa(altitude))


@_conversion
class TAStoCAS(AirDataBlock, flight.TAStoCAS):
    r"""Calibrated airspeed (CAS) at a true airspeed (TAS) and an altitude.

    .. math::

        M = TAS / a, \qquad p_0 f(CAS / a_0) = p f(M)

    %(pitot)s
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"cas": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_cas(tas, self._isa(altitude, temp_deviation))


@_conversion
class MachtoCAS(AirDataBlock, flight.MachtoCAS):
    """Calibrated airspeed (CAS) at a Mach number and an altitude.

    .. math::

        p_0 f(CAS / a_0) = p f(M)

    %(pitot)s
    """

    input_port_labels = {"mach": 0, "altitude": 1}
    output_port_labels = {"cas": 0}

    def _eval(self, mach: float, altitude: float) -> float:
        return airspeed.mach_to_cas(mach, self._isa(altitude))
