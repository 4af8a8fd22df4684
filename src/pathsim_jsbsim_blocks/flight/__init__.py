"""JSBSim aircraft: models, trims, and the blocks that fly them. Needs jsbsim."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .airframe import Airframe
from .fleet import LevelFlight, level_flight
from .model_files import aircraft_names, empty_weight_cg, has_retractable_gear
from .trimming import TrimState, trim
from .trimming.condition import TrimCondition

if TYPE_CHECKING:
    from .aircraft import Aircraft, linear_model
    from .fdm import JSBSimFDM
else:
    # imported at first use: without PathSim, workers for trims start five times faster
    _WITH_PATHSIM = {"Aircraft": "aircraft", "JSBSimFDM": "fdm", "linear_model": "aircraft"}

    def __getattr__(name: str) -> Any:
        if name in _WITH_PATHSIM:
            return getattr(import_module(f".{_WITH_PATHSIM[name]}", __name__), name)
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

    def __dir__() -> list[str]:
        return sorted(__all__)


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
    "linear_model",
    "trim",
]
