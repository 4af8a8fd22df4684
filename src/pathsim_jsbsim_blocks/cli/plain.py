"""Docstrings as plain text: formulas in words, as a terminal can show them."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable

# what a formula has, and what is printed for it, in this order
_TEX = [
    (r"\\(?:left|right)(?![a-z])|\\(?:begin|end)\{\w+\*?\}|&", ""),
    (r"\\\\\s*", "\n"),
    (r"\\(?:q?quad)(?![a-z])|\\[,;: ]", " "),
    (r"\\(?:mathrm|mathbf|mathcal|text|vec|hat|tilde) *(?:\{([^{}]*)\}|(\w))", r"\1\2"),
    (r"\\(d?dot) *\{?\\?(\w(?:[a-z]+(?=\W))?)\}?", r"\2\1"),
    (r"\\le(?:q)?(?![a-z])", "<="),
    (r"\\ge(?:q)?(?![a-z])", ">="),
    (r"\\cdot(?![a-z])", "*"),
    (r"\\int(?![a-z])", "integral"),
    (r"\\[dt]frac(?![a-z])", r"\\frac"),
]
# without braces inside, so that the inner ones go first
_BRACES: list[tuple[str, str | Callable[[re.Match[str]], str]]] = [
    (r"\\frac *\{([^{}]*)\} *\{([^{}]*)\}", lambda m: f"({_factor(m[1])}/{_factor(m[2])})"),
    (r"\\sqrt *\{([^{}]*)\}", r"sqrt(\1)"),
    (r"_\{(\w+)\}", r"_\1"),
    (r"([_^])\{([^{}]*)\}", r"\1(\2)"),
]


def _factor(text: str) -> str:
    return text if re.fullmatch(r"[\\\w']+", text) else f"({text})"


def plain_formula(tex: str) -> str:
    """A formula of LaTeX in words: theta_cmd, hdot, sqrt(p/p_0)."""
    for pattern, text in _TEX:
        tex = re.sub(pattern, text, tex)
    count = 1
    while count:
        count = 0
        for pattern, replacement in _BRACES:
            tex, replaced = re.subn(pattern, replacement, tex)
            count += replaced
    # a name is apart from what stands before it
    tex = re.sub(r"(?<=[\w)])\\(?=[A-Za-z])", " ", tex).replace("\\", "")
    lines = (re.sub(r" {2,}", " ", line).strip() for line in tex.splitlines())
    return "\n".join(lines)


def plain_text(docstring: str) -> str:
    """A docstring without the marks of reST, its formulas in words."""

    def block(match: re.Match[str]) -> str:
        formula = plain_formula(textwrap.dedent(match[1]).strip("\n"))
        return f"{textwrap.indent(formula, '    ')}\n"

    text = re.sub(
        r"^\.\. math::[ \t]*\n\n?((?:[ \t]+.*\n?|\n(?=[ \t]))+)", block, docstring, flags=re.M
    )
    text = re.sub(r":math:`([^`]*)`", lambda m: plain_formula(m[1]), text)
    text = re.sub(r":[\w:]+:`~?([^`]*)`", r"`\1`", text)
    return text.replace("``", "`")
