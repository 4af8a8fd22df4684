"""All that can be imported from the package itself: the names without an underscore."""

from importlib.util import find_spec as _find_spec

from ._core.running import fly as fly
from .air.airspeed_blocks import CAStoEAS as CAStoEAS
from .air.airspeed_blocks import CAStoMach as CAStoMach
from .air.airspeed_blocks import CAStoTAS as CAStoTAS
from .air.airspeed_blocks import EAStoCAS as EAStoCAS
from .air.airspeed_blocks import EAStoMach as EAStoMach
from .air.airspeed_blocks import EAStoTAS as EAStoTAS
from .air.airspeed_blocks import MachtoCAS as MachtoCAS
from .air.airspeed_blocks import MachtoEAS as MachtoEAS
from .air.airspeed_blocks import MachtoTAS as MachtoTAS
from .air.airspeed_blocks import TAStoCAS as TAStoCAS
from .air.airspeed_blocks import TAStoEAS as TAStoEAS
from .air.airspeed_blocks import TAStoMach as TAStoMach
from .air.atmosphere_blocks import ISAtmosphere as ISAtmosphere
from .axes import BodyToNED as BodyToNED
from .axes import BodyToWind as BodyToWind
from .axes import GeodeticToNED as GeodeticToNED
from .axes import NEDToBody as NEDToBody
from .axes import WindToBody as WindToBody
from .control.actuator import Actuator as Actuator
from .control.autopilot import Autopilot as Autopilot
from .control.holds import *
from .control.pid import DiscretePID as DiscretePID
from .control.receivers import Glideslope as Glideslope
from .control.receivers import Localizer as Localizer
from .control.sensor import Sensor as Sensor
from .daveml.block import DaveML as DaveML
from .errors import AircraftError as AircraftError
from .errors import BlocksError as BlocksError
from .errors import DiagramError as DiagramError
from .errors import FlightError as FlightError
from .errors import LinearisationError as LinearisationError
from .errors import ParameterError as ParameterError
from .errors import PropertyError as PropertyError
from .errors import TrimError as TrimError
from .sources import DoubletSource as DoubletSource
from .sources import MultistepSource as MultistepSource
from .sources import RampSource as RampSource
from .tracks.recorder import FlightRecorder as FlightRecorder
from .units import UnitConversion as UnitConversion
from .wind.gust import OneMinusCosineGust as OneMinusCosineGust
from .wind.microburst import Microburst as Microburst
from .wind.shear import WindShear as WindShear
from .wind.turbulence import DrydenTurbulence as DrydenTurbulence

if _find_spec("jsbsim") is not None:
    from .flight.aircraft import Aircraft as Aircraft
    from .flight.fdm import JSBSimFDM as JSBSimFDM
    from .flight.linear import LinearAircraft as LinearAircraft
    from .flight.trimming.condition import TrimCondition as TrimCondition
    from .flight.trimming.state import TrimState as TrimState
