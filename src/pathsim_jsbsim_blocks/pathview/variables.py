"""How PathView names the variables of a script."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable


def plain(name: str) -> str:
    """The variable that PathView derives from a name."""
    variable = re.sub(r"[^a-zA-Z0-9_]", "", name.replace(" ", "_"))
    return ("n_" + variable if variable[:1].isdigit() else variable).lower()


def prefix_inside(subsystem: str, prefix: str) -> str:
    """What PathView puts before the variables of blocks in a subsystem of this name."""
    return f"{prefix}{plain(subsystem)}_"


def printable(name: str) -> str:
    """A name on one line, without line separators, control characters or direction marks.

    Its variable is the same.
    """
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name)


def unique(wish: str, taken: Callable[[str], bool], mark: str = "_") -> str:
    """A name that is not taken: ``wish``, or with a number behind it."""
    numbered = (f"{wish}{mark}{i}" for i in itertools.count(2))
    return next(name for name in itertools.chain([wish], numbered) if not taken(name))
