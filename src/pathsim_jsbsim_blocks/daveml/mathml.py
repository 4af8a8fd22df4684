"""MathML of a calculation as an expression, and that as Python."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from .elements import Element

# an operator and its arguments, which are expressions, or ("number", x), ("variable", id)
Expression = tuple

_ANY = 256

# minimum and maximum number of arguments; the Python operator between them, or function
# fmt: off
OPERATORS: dict[str, tuple[int, int, str]] = {
    "plus": (1, _ANY, " + "), "times": (1, _ANY, " * "),
    "minus": (1, 2, " - "), "divide": (2, 2, " / "),
    "power": (2, 2, "pow"), "root": (1, 2, "pow"),
    "rem": (2, 2, "fmod"), "quotient": (2, 2, "whole"),
    "min": (1, _ANY, "min"), "max": (1, _ANY, "max"),
    "floor": (1, 1, "floor"), "ceiling": (1, 1, "ceil"),
    "abs": (1, 1, "abs"), "exp": (1, 1, "exp"), "ln": (1, 1, "log"), "log": (1, 2, "log10"),
    **{f"{x}{h}": (1, 1, f"{x}{h}") for x in ("sin", "cos", "tan") for h in ("", "h")},
    **{f"arc{x}{h}": (1, 1, f"a{x}{h}") for x in ("sin", "cos", "tan") for h in ("", "h")},
    "atan2": (2, 2, "atan2"),
    "lt": (2, 2, " < "), "leq": (2, 2, " <= "), "gt": (2, 2, " > "), "geq": (2, 2, " >= "),
    "eq": (2, 2, " == "), "neq": (2, 2, " != "),
    "and": (1, _ANY, "every"), "or": (1, _ANY, "some"),
    "xor": (2, 2, "either"), "not": (1, 1, "negate"),
}
# fmt: on
_RECIPROCALS = {"sec": "cos", "csc": "sin", "cot": "tan"}
_LOGIC = ("and", "or", "not")
_COMPARISONS = (" < ", " <= ", " > ", " >= ", " == ", " != ")
_CONSTANTS = {"pi": math.pi, "exponentiale": math.e, "true": 1.0, "false": 0.0}


def _undefined() -> float:
    raise ValueError("no piece of its piecewise applies")


# functions that the Python of an expression calls
NAMES: dict[str, Any] = {
    **vars(math),
    **{"__builtins__": {}, "abs": abs, "min": min, "max": max, "undefined": _undefined},
    # as floats: Python's own give integers, which never overflow
    "floor": lambda x: x // 1.0,
    "ceil": lambda x: -(-x // 1.0),
    "whole": lambda a, b: float(math.trunc(a / b)),
    "every": lambda *x: float(all(x)),
    "some": lambda *x: float(any(x)),
    "either": lambda a, b: float((a != 0) != (b != 0)),
    "negate": lambda x: float(not x),
    "limited": lambda x, low, high: low if x < low else high if x > high else x,  # NaN stays
}


def read_expression(element: Element) -> Expression:
    """The expression of a MathML element."""
    tag, children = element.tag, element.children
    if tag == "cn":
        return ("number", _number(element))
    if tag == "ci":
        return ("variable", element.text.strip())
    if tag in _CONSTANTS:
        return ("number", _CONSTANTS[tag])
    if tag == "piecewise":
        return _piecewise(element)
    kinds = ("apply", "cn", "ci", "piecewise", *_CONSTANTS)
    if tag != "apply" or not children:
        raise element.error(f"{tag!r} is not an expression", name=tag, of=kinds)
    operator, *arguments = children
    if operator.tag == "piecewise" and not arguments:  # some files apply it to nothing
        return _piecewise(operator)
    name = operator.text.strip() if operator.tag == "csymbol" else operator.tag
    bare = [x.one(*kinds) if x.tag in ("degree", "logbase") else x for x in arguments]
    return _applied(operator, name, [*map(read_expression, bare)])


def _applied(element: Element, name: str, arguments: list[Expression]) -> Expression:
    if name in _RECIPROCALS:
        return ("divide", ("number", 1.0), _applied(element, _RECIPROCALS[name], arguments))
    if name not in OPERATORS:
        raise element.error(f"unknown operator {name!r}", name=name, of=[*OPERATORS, "sec", "cot"])
    fewest, most, _ = OPERATORS[name]
    if not fewest <= len(arguments) <= most:
        number = fewest if fewest == most else f"{fewest} to {most}"
        raise element.error(f"{name!r} takes {number} arguments, not {len(arguments)}")
    if name == "root":
        *degree, x = arguments
        return ("power", x, ("divide", ("number", 1.0), *(degree or [("number", 2.0)])))
    if name == "log" and len(arguments) == 2:
        return ("divide", ("ln", arguments[1]), ("ln", arguments[0]))
    if len(arguments) == 1 and most == _ANY:
        return ("neq", *arguments, ("number", 0.0)) if name in _LOGIC else arguments[0]
    if name == "minus" and len(arguments) == 1:
        return ("minus", ("number", 0.0), *arguments)
    return (name, *arguments)


def _number(element: Element) -> float:
    kind = element.get("type", "real", "integer", "double", "e-notation")
    if kind == "e-notation" and [c.tag for c in element.children] == ["sep"]:
        return element.parse("e".join(element.text.split()))
    return element.parse(element.text)


def _piecewise(element: Element) -> Expression:
    """Values and conditions in turn, then the value of ``otherwise``, if any."""
    element.only("piece", "otherwise")
    parts = sorted(element.children, key=lambda part: part.tag == "otherwise")
    for part in parts:
        count = 2 - (part is parts[-1] and part.tag == "otherwise")
        if len(part.children) != count or len(parts) > _ANY:
            raise part.error(f"a piece needs a value and a condition; at most {_ANY} pieces")
    if not parts:
        raise element.error("the piecewise is empty")
    return ("piecewise", *(read_expression(x) for part in parts for x in part.children))


def variables_of(expression: Expression) -> set[str]:
    """The variables that an expression reads."""
    kind, *arguments = expression
    if kind in ("number", "variable"):
        return {*arguments} if kind == "variable" else set()
    return set().union(*map(variables_of, arguments))


def python_of(expression: Expression, name: Callable[[str], str]) -> str:
    """An expression as Python; ``name`` maps a variable's id to its Python name."""
    kind, *arguments = expression
    if kind in ("number", "variable"):
        return name(arguments[0]) if kind == "variable" else f"({arguments[0]!r})"
    parts = [python_of(x, name) for x in arguments]
    if kind == "piecewise":
        pieces = zip(parts[::2], parts[1::2], strict=False)
        last = parts[-1] if len(parts) % 2 else "undefined()"
        return "(" + "".join(f"{value} if {when} else " for value, when in pieces) + f"{last})"
    operator = OPERATORS[kind][2]
    if operator[0] != " ":
        return f"{operator}({', '.join(parts)})"
    chain = f"({operator.join(parts)})"
    return f"({chain} * 1.0)" if operator in _COMPARISONS else chain  # a bool is an integer
