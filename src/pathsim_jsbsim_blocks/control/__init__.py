"""Controllers: the sampled PI-D law, one block per hold, and the autopilot."""

from .._core.sampling import SampledLaw
from .pid import PID, PIDState
from .response import ResponseQuality, response_quality

__all__ = ["PID", "PIDState", "ResponseQuality", "SampledLaw", "response_quality"]
