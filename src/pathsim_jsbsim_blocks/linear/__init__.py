"""Linear models of a trimmed aircraft: matrices with names, modes, flying qualities, figures."""

from .charts import bode, pole_map, root_locus, step_response
from .model import LinearModel
from .modes import Mode
from .qualities import Quality, flying_qualities

__all__ = [
    "LinearModel",
    "Mode",
    "Quality",
    "bode",
    "flying_qualities",
    "pole_map",
    "root_locus",
    "step_response",
]
