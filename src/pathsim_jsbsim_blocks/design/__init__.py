"""Gains of the autopilot designed from linear models of the aircraft. Needs jsbsim."""

from .designed import DesignedGains, design_gains
from .schedule import DesignedSchedule, design_schedule

__all__ = [
    "DesignedGains",
    "DesignedSchedule",
    "design_gains",
    "design_schedule",
]
