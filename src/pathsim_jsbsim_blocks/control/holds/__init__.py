"""One block per hold, all made of the plain loops in ``control.loops``.

Their outputs are increments on the trimmed commands, as ``Aircraft`` takes them.
"""

from typing import TYPE_CHECKING

# the package and PathView export the names in the ``__all__`` of each module
from . import lateral, longitudinal
from .lateral import *
from .longitudinal import *

if not TYPE_CHECKING:  # mypy would treat a list that it cannot evaluate as empty
    __all__ = [*lateral.__all__, *longitudinal.__all__]
