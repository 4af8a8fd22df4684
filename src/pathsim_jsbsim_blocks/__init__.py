"""Fly JSBSim aircraft in PathSim block diagrams.

Every block can be imported from here. Where jsbsim is not installed (PathView's hosted editor runs
in the browser), the aircraft blocks are absent and all others work.
"""

import logging
from importlib.util import find_spec

from .airspeed_blocks import (
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
from .atmosphere_blocks import ISAtmosphere
from .axes import BodyToNED, BodyToWind, GeodeticToNED, NEDToBody, WindToBody
from .errors import (
    AircraftError,
    BlocksError,
    FlightError,
    ParameterError,
    PropertyError,
    TrimError,
)
from .sources import DoubletSource, MultistepSource, RampSource

if find_spec("jsbsim") is not None:
    from .fdm import Aircraft, JSBSimFDM
    from .trim import TrimCondition, TrimState

__version__ = "0.1.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())
