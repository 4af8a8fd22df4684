"""JSBSim aircraft: models, trims, and the blocks that fly them. Needs jsbsim."""

from ._trim import TrimState, trim
from .aircraft import Aircraft
from .airframe import Airframe, aircraft_names, empty_weight_cg, has_retractable_gear
from .condition import TrimCondition
from .fdm import JSBSimFDM
from .fleet import LevelFlight, level_flight

__all__ = [
    "Aircraft",
    "Airframe",
    "JSBSimFDM",
    "LevelFlight",
    "TrimCondition",
    "TrimState",
    "aircraft_names",
    "empty_weight_cg",
    "has_retractable_gear",
    "level_flight",
    "trim",
]
