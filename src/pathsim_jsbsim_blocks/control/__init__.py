"""Controllers: the sampled PI-D law, one block per hold, and the autopilot."""

from .response import ResponseQuality, response_quality

__all__ = ["ResponseQuality", "response_quality"]
