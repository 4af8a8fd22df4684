"""Fly JSBSim aircraft in PathSim block diagrams.

Every block can be imported from here. Where jsbsim is not installed (PathView's hosted editor runs
in the browser), the aircraft blocks are absent and all others work.
"""

import logging
from importlib.util import find_spec

from .airspeed_blocks import EAStoMach, EAStoTAS, MachtoEAS, MachtoTAS, TAStoEAS, TAStoMach
from .atmosphere_blocks import ISAtmosphere
from .axes import BodyToNED, BodyToWind, GeodeticToNED, NEDToBody, WindToBody
from .calibrated_airspeed_blocks import (
    CAStoEAS,
    CAStoMach,
    CAStoTAS,
    EAStoCAS,
    MachtoCAS,
    TAStoCAS,
)
from .control.autopilot import Autopilot
from .control.holds import (
    AirspeedHold,
    AltitudeHold,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)
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

if find_spec("jsbsim") is not None:
    from .aircraft import Aircraft
    from .fdm import JSBSimFDM
    from .trim import TrimState
    from .trim_condition import TrimCondition

__version__ = "0.1.0"

# without a handler Python's last resort would write JSBSim's warnings to the console
logging.getLogger(__name__).addHandler(logging.NullHandler())
