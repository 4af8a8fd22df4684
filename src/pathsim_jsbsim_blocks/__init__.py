"""Fly JSBSim aircraft in PathSim block diagrams.

Every block can be imported from here. Where jsbsim is not installed (PathView's hosted editor runs
in the browser), the aircraft blocks are absent and all others work.
"""

import logging
from importlib.util import find_spec

from ._core._pathsim import keep_warnings_visible
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
from .control.autopilot import Autopilot
from .control.holds import *
from .control.pid import DiscretePID
from .errors import (
    AircraftError,
    BlocksError,
    DiagramError,
    FlightError,
    ParameterError,
    PropertyError,
    TrimError,
)
from .sources import DoubletSource, MultistepSource, RampSource

__all__ = [
    "AircraftError",
    "Autopilot",
    "BlocksError",
    "BodyToNED",
    "BodyToWind",
    "CAStoEAS",
    "CAStoMach",
    "CAStoTAS",
    "DiagramError",
    "DiscretePID",
    "DoubletSource",
    "EAStoCAS",
    "EAStoMach",
    "EAStoTAS",
    "FlightError",
    "GeodeticToNED",
    "ISAtmosphere",
    "MachtoCAS",
    "MachtoEAS",
    "MachtoTAS",
    "MultistepSource",
    "NEDToBody",
    "ParameterError",
    "PropertyError",
    "RampSource",
    "TAStoCAS",
    "TAStoEAS",
    "TAStoMach",
    "TrimError",
    "WindToBody",
    "fly",
]
__all__ += _holds.__all__

if find_spec("jsbsim") is not None:
    from .flight._trim import TrimState
    from .flight.aircraft import Aircraft
    from .flight.condition import TrimCondition
    from .flight.fdm import JSBSimFDM

    __all__ += ["Aircraft", "JSBSimFDM", "TrimCondition", "TrimState"]

__version__ = "0.1.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())
keep_warnings_visible()


def __dir__() -> list[str]:
    # PathView looks for blocks here
    return sorted(__all__)
