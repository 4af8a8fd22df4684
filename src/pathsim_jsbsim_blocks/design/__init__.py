"""Gains of the autopilot designed from linear models of the aircraft. Needs jsbsim."""

from .designed import DesignedGains, LoopReport, design_gains

__all__ = ["DesignedGains", "LoopReport", "design_gains"]
