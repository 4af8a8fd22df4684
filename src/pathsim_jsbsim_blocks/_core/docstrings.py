"""Text shared by many docstrings, inserted at import."""

from __future__ import annotations

import re
from collections.abc import Callable
from inspect import cleandoc
from textwrap import indent
from typing import Any, TypeVar

Documented = TypeVar("Documented", bound=Callable[..., Any])

_PLACE = re.compile(r"^( *)%\((\w+)\)s$", re.MULTILINE)


def filler(**texts: str) -> Callable[[Documented], Documented]:
    """A decorator that replaces the lines ``%(name)s`` of a docstring with ``texts``."""
    clean = {name: cleandoc(text) for name, text in texts.items()}

    def fill(item: Documented) -> Documented:
        if item.__doc__:  # absent under python -OO
            item.__doc__ = _PLACE.sub(lambda place: indent(clean[place[2]], place[1]), item.__doc__)
        return item

    return fill
