"""Controllers: the sampled PI-D law, one block per hold, and the autopilot."""

from .pid import PID, PIDState
from .response import ResponseQuality, response_quality

__all__ = ["PID", "PIDState", "ResponseQuality", "response_quality"]
