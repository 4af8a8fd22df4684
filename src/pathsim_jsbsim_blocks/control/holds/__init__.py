"""One block per hold, all made of the plain loops in ``control.loops``.

Their outputs are increments on the trimmed commands, as ``Aircraft`` takes them.
"""

from . import lateral, longitudinal
from .lateral import *
from .longitudinal import *

__all__ = [*lateral.__all__, *longitudinal.__all__]
