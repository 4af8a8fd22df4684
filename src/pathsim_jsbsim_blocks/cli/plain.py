"""Docstrings as plain text, as a terminal can show them."""

from __future__ import annotations

import re
import textwrap


def plain_text(docstring: str) -> str:
    """A docstring without the marks of reST; formulas stay in TeX."""

    def block(match: re.Match[str]) -> str:
        formula = textwrap.dedent(match[1]).strip("\n")
        return f"{textwrap.indent(formula, '    ')}\n"

    text = re.sub(
        r"^\.\. math::[ \t]*\n\n?((?:[ \t]+.*\n?|\n(?=[ \t]))+)", block, docstring, flags=re.M
    )
    text = re.sub(r":[\w:]+:`~?([^`]*)`", r"`\1`", text)
    return text.replace("``", "`")
