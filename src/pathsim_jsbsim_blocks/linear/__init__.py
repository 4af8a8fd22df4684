"""Linear models of a trimmed aircraft: names, modes, flying qualities, margins, figures."""

from .charts import bode, pole_map, step_response
from .model import LinearModel
from .modes import Mode
from .qualities import Quality, flying_qualities
from .stability import Margins, margins

__all__ = [
    "LinearModel",
    "Margins",
    "Mode",
    "Quality",
    "bode",
    "flying_qualities",
    "margins",
    "pole_map",
    "step_response",
]
