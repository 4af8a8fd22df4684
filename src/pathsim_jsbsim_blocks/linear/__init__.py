"""Linear models of a trimmed aircraft: matrices with names, modes, flying qualities."""

from .block import LinearModelBlock
from .model import LinearModel
from .modes import Mode
from .qualities import Quality, flying_qualities

__all__ = ["LinearModel", "LinearModelBlock", "Mode", "Quality", "flying_qualities"]
