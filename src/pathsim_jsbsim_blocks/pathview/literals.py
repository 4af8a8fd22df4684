"""Write values and functions of a script as Python expressions."""

from __future__ import annotations

import ast
import builtins
import copy
import types
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..scripts.names import arguments, bound, references
from .shape import shortened

_FUNCTIONS = (ast.FunctionDef, ast.Lambda)
# arithmetic with these rounds and divides by zero in ways of its own
_SCALARS = {np.dtype(code).type for code in "?bBhHiIlLqQefdFD"}


class Unwritable(Exception):
    """A value that cannot be written as an expression; the text says why."""


def literal(value: Any) -> str:
    """An expression for a number, text, array, collection or built-in function."""
    if type(value) in _SCALARS:
        return f"np.{type(value).__name__}({literal(value.item())})"
    if value is None or value is ... or type(value) in (bool, int, str, bytes):
        return repr(value)
    if type(value) in (float, complex):
        text = repr(value).replace("inf", "np.inf").replace("nan", "np.nan")
        if type(value) is complex and "np." in text:
            return f"complex({literal(value.real)}, {literal(value.imag)})"
        return text
    if isinstance(value, np.ndarray) and value.dtype.kind in "biufcU":
        same = value.size and np.array(value.tolist()).dtype == value.dtype
        shape = "" if value.size else f".reshape({value.shape})"
        dtype = "" if same else f", dtype={str(value.dtype)!r}"
        return f"np.array({literal(value.tolist())}{dtype}){shape}"
    if type(value) in (list, tuple, set):
        items = ", ".join(map(literal, value))
        if type(value) is tuple:
            return f"({items},)" if len(value) == 1 else f"({items})"
        return f"[{items}]" if type(value) is list else f"{{{items}}}" if value else "set()"
    if type(value) is dict:
        return "{" + ", ".join(f"{literal(k)}: {literal(v)}" for k, v in value.items()) + "}"
    if isinstance(value, np.ufunc):
        return f"np.{value.__name__}"
    name = getattr(value, "__name__", "")
    if name and getattr(builtins, name, None) is value:
        return str(name)
    raise Unwritable(f"{shortened(' '.join(repr(value).split()))} is not a plain value")


def memories(value: Any) -> Iterator[int]:
    """What a collection or an array can change, as addresses."""
    if isinstance(value, np.ndarray):
        while isinstance(value.base, np.ndarray):
            value = value.base
        yield id(value)
    elif isinstance(value, (list, dict, set, tuple)):
        if not isinstance(value, tuple):
            yield id(value)
        for inner in [*value, *(value.values() if isinstance(value, dict) else ())]:
            yield from memories(inner)


def definition(function: types.FunctionType, tree: ast.AST) -> Any:
    """A function's definition in its script; None if it is not there, or if it is ambiguous."""
    code, found = function.__code__, []
    for node in ast.walk(tree):
        if isinstance(node, _FUNCTIONS) and getattr(node, "name", "<lambda>") == code.co_name:
            first = min(n.lineno for n in (node, *getattr(node, "decorator_list", ())))
            found += [node] if first == code.co_firstlineno else []
    return found[0] if len({ast.dump(n) for n in found}) == 1 else None


def top_level(
    function: types.FunctionType,
    node: Any,
    part_name: Callable[[Any], str | None],
    value_of: Callable[[str, Any], ast.expr],
) -> ast.FunctionDef | ast.Lambda:
    """A function of the script as one of the top level; `Unwritable` if it cannot be one.

    Values of variables around it become default values of further parameters. ``node`` is its
    definition; ``part_name`` gives the name of a part of the diagram, ``value_of`` an
    expression for the value of a variable.
    """
    if node is None:
        raise Unwritable(f"function {function.__name__!r} is not in the script")
    if any(isinstance(n, ast.Nonlocal) for n in ast.walk(node)):
        raise Unwritable(f"{function.__name__!r} changes a variable of the function around it")
    new = copy.deepcopy(node)
    given = function.__kwdefaults__ or {}
    for i, argument in enumerate(node.args.kwonlyargs):
        if argument.arg in given:
            new.args.kw_defaults[i] = value_of(argument.arg, given[argument.arg])
    defaults = function.__defaults__ or ()
    names = [a.arg for a in (*node.args.posonlyargs, *node.args.args)][-len(defaults) :]
    new.args.defaults = [value_of(*pair) for pair in zip(names, defaults, strict=False)]
    renamed = {}
    cells = function.__closure__ or ()
    for name, cell in zip(function.__code__.co_freevars, cells, strict=True):
        part = part_name(cell.cell_contents)
        if part is not None:
            renamed[name] = part
        else:
            new.args.kwonlyargs.append(ast.arg(name))
            new.args.kw_defaults.append(value_of(name, cell.cell_contents))
    body = new.body if isinstance(new.body, list) else [new.body]
    local = bound(body) | {a.arg for a in arguments(new)}
    for part_of_body in body:
        for reference in references(part_of_body, frozenset(local - renamed.keys())):
            reference.id = renamed.get(reference.id, reference.id)
    return new
