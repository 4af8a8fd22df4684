"""Gains of the autopilot designed from linear models of the aircraft. Needs jsbsim."""

from .designed import DesignedGains, design_gains
from .schedule import DesignedSchedule, design_schedule
from .search import LoopReport

__all__ = [
    "DesignedGains",
    "DesignedSchedule",
    "LoopReport",
    "design_gains",
    "design_schedule",
]
