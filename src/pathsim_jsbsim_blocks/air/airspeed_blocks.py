"""Blocks that convert between calibrated, equivalent and true airspeed and Mach number.

Thin shells over the functions of ``airspeed``, in the standard atmosphere at an altitude. Those
that pathsim-flight has too stand in for its own.
"""

from __future__ import annotations

import pathsim_flight.utils as flight

from . import airspeed
from .atmosphere_blocks import AirDataBlock


class EAStoTAS(AirDataBlock, flight.EAStoTAS):
    r"""True airspeed (TAS) at an equivalent airspeed (EAS) and an altitude.

    .. math::

        TAS = EAS \sqrt{\rho_0 / \rho} = \frac{EAS}{a_0} \sqrt{p_0 / p}\, a

    Index 0 is sea level. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    eas
        equivalent airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    tas
        true airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"eas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, eas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.eas_to_tas(eas, self._isa(altitude, temp_deviation))


class EAStoMach(AirDataBlock):
    r"""Mach number at an equivalent airspeed (EAS) and an altitude.

    .. math::

        M = \frac{EAS}{a_0} \sqrt{p_0 / p}

    Index 0 is sea level. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    eas
        equivalent airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    mach
        Mach number

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"eas": 0, "altitude": 1}
    output_port_labels = {"mach": 0}

    def _eval(self, eas: float, altitude: float) -> float:
        return airspeed.eas_to_mach(eas, self._isa(altitude))


class TAStoEAS(AirDataBlock):
    r"""Equivalent airspeed (EAS) at a true airspeed (TAS) and an altitude.

    .. math::

        EAS = TAS \sqrt{\rho / \rho_0} = \frac{TAS}{a} a_0 \sqrt{p / p_0}

    Index 0 is sea level. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    tas
        true airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    eas
        equivalent airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"eas": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_eas(tas, self._isa(altitude, temp_deviation))


class TAStoMach(AirDataBlock):
    """Mach number at a true airspeed (TAS) and an altitude.

    .. math::

        M = TAS / a

    A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    tas
        true airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    mach
        Mach number

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"mach": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_mach(tas, self._isa(altitude, temp_deviation))


class MachtoEAS(AirDataBlock):
    r"""Equivalent airspeed (EAS) at a Mach number and an altitude.

    .. math::

        EAS = M a_0 \sqrt{p / p_0}

    Index 0 is sea level. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    mach
        Mach number
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    eas
        equivalent airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"mach": 0, "altitude": 1}
    output_port_labels = {"eas": 0}

    def _eval(self, mach: float, altitude: float) -> float:
        return airspeed.mach_to_eas(mach, self._isa(altitude))


class MachtoTAS(AirDataBlock):
    """True airspeed (TAS) at a Mach number and an altitude.

    .. math::

        TAS = M a

    A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    mach
        Mach number
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    tas
        true airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"mach": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, mach: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.mach_to_tas(mach, self._isa(altitude, temp_deviation))


class CAStoEAS(AirDataBlock, flight.CAStoEAS):
    r"""Equivalent airspeed (EAS) at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0), \qquad EAS = M a_0 \sqrt{p / p_0}

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    cas
        calibrated airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    eas
        equivalent airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"cas": 0, "altitude": 1}
    output_port_labels = {"eas": 0}

    def _eval(self, cas: float, altitude: float) -> float:
        return airspeed.cas_to_eas(cas, self._isa(altitude))


class CAStoTAS(AirDataBlock, flight.CAStoTAS):
    r"""True airspeed (TAS) at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0), \qquad TAS = M a

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    cas
        calibrated airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    tas
        true airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"cas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"tas": 0}

    def _eval(self, cas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.cas_to_tas(cas, self._isa(altitude, temp_deviation))


class CAStoMach(AirDataBlock, flight.CAStoMach):
    """Mach number at a calibrated airspeed (CAS) and an altitude.

    .. math::

        p f(M) = p_0 f(CAS / a_0)

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    cas
        calibrated airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    mach
        Mach number

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"cas": 0, "altitude": 1}
    output_port_labels = {"mach": 0}

    def _eval(self, cas: float, altitude: float) -> float:
        return airspeed.cas_to_mach(cas, self._isa(altitude))


class EAStoCAS(AirDataBlock):
    r"""Calibrated airspeed (CAS) at an equivalent airspeed (EAS) and an altitude.

    .. math::

        M = \frac{EAS}{a_0} \sqrt{p_0 / p}, \qquad p_0 f(CAS / a_0) = p f(M)

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    eas
        equivalent airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    cas
        calibrated airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"eas": 0, "altitude": 1}
    output_port_labels = {"cas": 0}

    def _eval(self, eas: float, altitude: float) -> float:
        return airspeed.eas_to_cas(eas, self._isa(altitude))


class TAStoCAS(AirDataBlock, flight.TAStoCAS):
    r"""Calibrated airspeed (CAS) at a true airspeed (TAS) and an altitude.

    .. math::

        M = TAS / a, \qquad p_0 f(CAS / a_0) = p f(M)

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    tas
        true airspeed, m/s
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"
    temp_deviation
        from the standard temperature, K

    Outputs
    -------
    cas
        calibrated airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"tas": 0, "altitude": 1, "temp_deviation": 2}
    output_port_labels = {"cas": 0}

    def _eval(self, tas: float, altitude: float, temp_deviation: float = 0.0) -> float:
        return airspeed.tas_to_cas(tas, self._isa(altitude, temp_deviation))


class MachtoCAS(AirDataBlock, flight.MachtoCAS):
    """Calibrated airspeed (CAS) at a Mach number and an altitude.

    .. math::

        p_0 f(CAS / a_0) = p f(M)

    with f(M) = (1 + 0.2 M^2)^3.5 - 1 up to Mach 1, Rayleigh's formula above; index 0 is sea level.
    A perfect gas: valid to about Mach 5. A negative speed stays negative.

    Parameters
    ----------
    altitude_kind : str
        what the altitude input is: "geometric" (height) or "geopotential"
    out_of_range : str
        beyond -5 km or 80 km: "extrapolate" (with one warning), "clamp" or "error"

    Inputs
    ------
    mach
        Mach number
    altitude
        altitude in m: a height, or pressure altitude where ``altitude_kind`` is "geopotential"

    Outputs
    -------
    cas
        calibrated airspeed, m/s

    Raises
    ------
    FlightError
        while it runs: for inputs that are not finite, and for altitudes out of range
        if ``out_of_range`` is "error"
    """

    input_port_labels = {"mach": 0, "altitude": 1}
    output_port_labels = {"cas": 0}

    def _eval(self, mach: float, altitude: float) -> float:
        return airspeed.mach_to_cas(mach, self._isa(altitude))
