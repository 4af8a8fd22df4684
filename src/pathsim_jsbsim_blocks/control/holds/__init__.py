"""One block per hold, all made of the plain loops in ``control.loops``.

Their outputs are increments on the trimmed commands, as ``Aircraft`` takes them.
"""

from typing import TYPE_CHECKING

from . import landing, lateral, longitudinal, navigation
from .landing import *
from .lateral import *
from .longitudinal import *
from .navigation import *

if not TYPE_CHECKING:  # mypy would take a list that it cannot read for an empty one
    __all__ = [*lateral.__all__, *longitudinal.__all__, *navigation.__all__, *landing.__all__]
