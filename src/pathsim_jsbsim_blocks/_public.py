"""All that can be imported from the package itself."""

from importlib.util import find_spec

from ._core.running import fly
from .air.airspeed_blocks import (
    CAStoEAS,
    CAStoMach,
    CAStoTAS,
    EAStoCAS,
    EAStoMach,
    EAStoTAS,
    MachtoCAS,
    MachtoEAS,
    MachtoTAS,
    TAStoCAS,
    TAStoEAS,
    TAStoMach,
)
from .air.atmosphere_blocks import ISAtmosphere
from .axes import BodyToNED, BodyToWind, GeodeticToNED, NEDToBody, WindToBody
from .control import holds as _holds
from .control.actuator import Actuator
from .control.autopilot import Autopilot
from .control.holds import *
from .control.pid import DiscretePID
from .control.receivers import Glideslope, Localizer
from .control.sensor import Sensor
from .daveml.block import DaveML
from .errors import (
    AircraftError,
    BlocksError,
    DiagramError,
    FlightError,
    LinearisationError,
    ParameterError,
    PropertyError,
    TrimError,
)
from .sources import DoubletSource, MultistepSource, RampSource
from .tracks.recorder import FlightRecorder
from .units import UnitConversion
from .wind.gust import OneMinusCosineGust
from .wind.microburst import Microburst
from .wind.shear import WindShear
from .wind.turbulence import DrydenTurbulence

__all__ = [
    "Actuator",
    "AircraftError",
    "Autopilot",
    "BlocksError",
    "BodyToNED",
    "BodyToWind",
    "CAStoEAS",
    "CAStoMach",
    "CAStoTAS",
    "DaveML",
    "DiagramError",
    "DiscretePID",
    "DoubletSource",
    "DrydenTurbulence",
    "EAStoCAS",
    "EAStoMach",
    "EAStoTAS",
    "FlightError",
    "FlightRecorder",
    "GeodeticToNED",
    "Glideslope",
    "ISAtmosphere",
    "LinearisationError",
    "Localizer",
    "MachtoCAS",
    "MachtoEAS",
    "MachtoTAS",
    "Microburst",
    "MultistepSource",
    "NEDToBody",
    "OneMinusCosineGust",
    "ParameterError",
    "PropertyError",
    "RampSource",
    "Sensor",
    "TAStoCAS",
    "TAStoEAS",
    "TAStoMach",
    "TrimError",
    "UnitConversion",
    "WindShear",
    "WindToBody",
    "fly",
]
__all__ += _holds.__all__  # type: ignore[attr-defined]

if find_spec("jsbsim") is not None:
    from .flight.aircraft import Aircraft
    from .flight.fdm import JSBSimFDM
    from .flight.linear import LinearAircraft
    from .flight.trimming.condition import TrimCondition
    from .flight.trimming.state import TrimState

    __all__ += ["Aircraft", "JSBSimFDM", "LinearAircraft", "TrimCondition", "TrimState"]
