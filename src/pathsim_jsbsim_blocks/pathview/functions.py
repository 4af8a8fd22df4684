"""The functions of a script: their source, and the names that they take from around them."""

from __future__ import annotations

import ast
import builtins
import types
from typing import Any

from .names import bound, references

_FUNCTION_NODES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


class Functions:
    """The functions in a piece of source, found by their code objects."""

    def __init__(self, tree: ast.AST, filename: str):
        self.filename = filename
        self._nodes: list[Any] = [n for n in ast.walk(tree) if isinstance(n, _FUNCTION_NODES)]

    def node(self, function: types.FunctionType) -> Any:
        """Its definition; None if it is not in this source, or if it is ambiguous."""
        code = function.__code__
        if code.co_filename != self.filename:
            return None
        found = [
            n
            for n in self._nodes
            if _first_line(n) == code.co_firstlineno
            and getattr(n, "name", "<lambda>") == code.co_name
            and _argument_names(n) == code.co_varnames[: _count(code)]
        ]
        if len(found) > 1 and hasattr(code, "co_positions"):
            places = [p for p in code.co_positions() if None not in p and p[3] > p[2]]
            found = [
                n
                for n in found
                if all(
                    (_body(n)[0].lineno, _body(n)[0].col_offset) <= (first, column)
                    and (last, end) <= (_body(n)[-1].end_lineno, _body(n)[-1].end_col_offset)
                    for first, last, column, end in places
                )
            ]
        if len({ast.dump(n) for n in found}) != 1:
            return None
        return found[0]


def _body(node: Any) -> list[Any]:
    return node.body if isinstance(node.body, list) else [node.body]


def _first_line(node: Any) -> int:
    return min([node.lineno, *(d.lineno for d in getattr(node, "decorator_list", ()))])


def _argument_names(node: Any) -> tuple[str, ...]:
    a = node.args
    every = [*a.posonlyargs, *a.args, *a.kwonlyargs, *filter(None, (a.vararg, a.kwarg))]
    return tuple(arg.arg for arg in every)


def _count(code: types.CodeType) -> int:
    return (
        code.co_argcount
        + code.co_kwonlyargcount
        + bool(code.co_flags & 4)
        + bool(code.co_flags & 8)
    )


def outer_value(function: types.FunctionType, name: str) -> Any:
    """The value of an outer name in a function; ``...`` if it is not bound yet."""
    if name in function.__code__.co_freevars:
        try:
            return function.__closure__[  # type: ignore[index]
                function.__code__.co_freevars.index(name)
            ].cell_contents
        except ValueError:  # still empty
            return ...
    return function.__globals__.get(name, getattr(builtins, name, ...))


def inner_names(node: Any) -> list[ast.Name]:
    """Names of outer scopes that a function uses when it is called."""
    body = _body(node)
    local = frozenset(_argument_names(node)) | bound(body)
    return [name for part in body for name in references(part, local)]
