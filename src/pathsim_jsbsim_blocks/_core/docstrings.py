"""Text shared by many docstrings: written once, filled in at import."""

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

    def fill(documented: Documented) -> Documented:
        if documented.__doc__:  # absent under python -OO
            documented.__doc__ = _PLACE.sub(
                lambda place: indent(clean[place[2]], place[1]), documented.__doc__
            )
        return documented

    return fill


def entries(documented: Any, **names: str) -> str:
    """Texts of parameters from the docstring that explains them, each under another's name."""
    page = cleandoc(documented.__doc__ or "")  # absent under python -OO
    found = []
    for name, there in names.items():
        entry = re.search(rf"^{there}( : .*\n(?: +.*\n?)+)", page, re.MULTILINE)
        found.append(f"{name}{entry[1]}" if entry else "")
    return "".join(x if x.endswith("\n") else f"{x}\n" for x in found)
