"""Controllers: the sampled PI-D law, one block per hold, and the autopilot."""

from .pid import PID, PIDState

__all__ = ["PID", "PIDState"]
