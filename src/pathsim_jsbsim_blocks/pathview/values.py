"""Write the live values of a script as Python expressions."""

from __future__ import annotations

import argparse
import ast
import builtins
import copy
import dataclasses
import functools
import importlib
import keyword
import types
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events._event import Event

from .functions import Functions, inner_names, outer_value

PARTS = (Block, Event, Connection, Simulation)


class Unwritable(Exception):
    """A value that cannot be written as an expression; the text says why."""


class Values:
    """Expressions for live values, and the code that these expressions need.

    Parameters
    ----------
    namespace : mapping
        the script's names
    functions : Functions
        the functions of its source
    need : callable
        called with each of the script's names that an expression uses, and its location

    Attributes
    ----------
    made : dict
        code to add: names with an expression or a function definition, in the order of their use
    parts : dict
        names in functions that refer to parts of the diagram, and these parts
    imports : set of str
        modules to import
    names : dict
        the names of functions and of variables around them, by ``id``
    """

    def __init__(
        self,
        namespace: Mapping[str, Any],
        functions: Functions,
        need: Callable[[str, ast.AST], None],
    ):
        self.namespace, self.functions, self.need = namespace, functions, need
        self.made: dict[str, ast.expr | ast.FunctionDef] = {}
        self.parts: dict[str, Any] = {}
        self.imports: set[str] = set()
        self.names: dict[int, tuple[str, Any]] = {}

    def expression(self, value: Any, name: str = "") -> ast.expr:
        """An expression whose value is ``value``.

        Raises
        ------
        Unwritable
            if there is none
        """
        node = self._literal(value)
        if node is None and not isinstance(value, PARTS):
            node = (
                self._named(value, name)
                or self._collection(value)
                or self._object(value)
                or self._function(value, name)
            )
        if node is None:
            raise Unwritable(f"{_short(value)} cannot be written as an expression")
        return node

    def _literal(self, value: Any) -> ast.expr | None:
        if isinstance(value, np.generic) and value.shape == () and not value.dtype.names:
            value = value.item()
        if value is None or value is ... or type(value) in (bool, int, str, bytes):
            return ast.Constant(value)
        if type(value) in (float, complex):
            text = repr(value).replace("inf", "np.inf").replace("nan", "np.nan")
            if type(value) is complex and "np." in text:
                text = f"complex({self.text(value.real)}, {self.text(value.imag)})"
            return _parsed(text)
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufcU":
            dtype = (
                ""
                if value.size and np.array(value.tolist()).dtype == value.dtype
                else f", dtype={str(value.dtype)!r}"
            )
            shape = f".reshape({value.shape})" if not value.size else ""
            inner = ast.unparse(self.expression(value.tolist()))
            return _parsed(f"np.array({inner}{dtype}){shape}")
        return None

    def text(self, value: Any) -> str:
        return ast.unparse(self.expression(value))

    def _named(self, value: Any, but: str) -> ast.expr | None:
        """A name of the script, or of an installed module."""
        for name, found in self.namespace.items():
            if (
                found is value
                and name != but
                and not name.startswith("__")
                and not isinstance(value, (list, dict, set, tuple, np.ndarray))
            ):
                node = ast.Name(name, ast.Load())
                self.need(name, node)
                return node
        if isinstance(value, np.ufunc):
            return _parsed(f"np.{value.__name__}")
        if isinstance(value, types.ModuleType):
            self.imports.add(value.__name__)
            return _parsed(value.__name__)
        module, path = getattr(value, "__module__", None), getattr(value, "__qualname__", "")
        if isinstance(value, (type, types.FunctionType, types.BuiltinFunctionType)) and (
            module and module != "__main__" and path.replace(".", "").isidentifier()
        ):
            if module == "builtins":
                return _parsed(path)
            try:
                found = functools.reduce(getattr, path.split("."), importlib.import_module(module))
            except (ImportError, AttributeError):
                return None
            if found is value:
                self.need(f"{module}.", ast.Name(path, ast.Load()))
                self.imports.add(module)
                return _parsed(f"{module}.{path}")
        return None

    def _collection(self, value: Any) -> ast.expr | None:
        if type(value) in (list, tuple, set):
            items = [self.expression(v) for v in value]
            if type(value) is list:
                return ast.List(items, ast.Load())
            if type(value) is tuple:
                return ast.Tuple(items, ast.Load())
            return ast.Set(items) if items else _parsed("set()")
        if type(value) is dict:
            return ast.Dict(
                [self.expression(k) for k in value], [self.expression(v) for v in value.values()]
            )
        return None

    def _object(self, value: Any) -> ast.expr | None:
        """An object that its fields can rebuild."""
        if isinstance(value, types.MethodType):
            return ast.Attribute(self.expression(value.__self__), value.__name__, ast.Load())
        if isinstance(value, functools.partial):
            maker: Any = functools.partial
            return self._call(maker, [value.func, *value.args], value.keywords)
        if type(value) in (argparse.Namespace, types.SimpleNamespace):
            return self._call(type(value), [], vars(value))
        if dataclasses.is_dataclass(value) and not isinstance(value, type):
            fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value) if f.init}
            return self._call(type(value), [], fields)
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            return self._call(type(value), list(value), {})
        return None

    def _call(self, function: Any, args: Iterable[Any], keywords: Mapping[str, Any]) -> ast.expr:
        return ast.Call(
            self.expression(function),
            [self.expression(a) for a in args],
            [ast.keyword(k, self.expression(v)) for k, v in keywords.items()],
        )

    # functions ----------------------------------------------------------------------------------

    def _function(self, value: Any, name: str) -> ast.expr | None:
        """A function of the script; its closure variables become names of the code."""
        if not isinstance(value, types.FunctionType):
            return None
        if id(value) in self.names:
            return ast.Name(self.names[id(value)][0], ast.Load())
        node = self.functions.node(value)
        if node is None:
            raise Unwritable(f"function {value.__name__!r} is not in the script")
        if isinstance(node, ast.AsyncFunctionDef):
            return None
        wish = name or (node.name if isinstance(node, ast.FunctionDef) else "")
        if wish:
            wish = wish if name else self._unique(wish)
            self.names[id(value)] = (wish, value)
        renamed = {n.id: self._outer(value, n) for n in inner_names(node)}
        renamed = {old: new for old, new in renamed.items() if old != new}
        defaults = self._defaults(value, node)
        if isinstance(node, ast.Lambda) and not renamed and defaults is node.args:
            return node
        written = _substituted(node, renamed, {n.id for n in inner_names(node)})
        if defaults is not node.args:
            written.args = copy.deepcopy(defaults)
        if isinstance(node, ast.Lambda):
            return _without_places(written)
        written.name, written.decorator_list, written.returns = wish, [], None
        for arg in ast.walk(written.args):
            if isinstance(arg, ast.arg):
                arg.annotation = None
        self.made[wish] = _without_places(written)
        return ast.Name(wish, ast.Load())

    def _outer(self, function: types.FunctionType, name: ast.Name) -> str:
        """The name in the code for an outer name of a function."""
        if name.id not in function.__code__.co_freevars:
            # also for a function defined elsewhere: its globals are the script's
            self.need(name.id, name)
            return name.id
        cell = function.__closure__[  # type: ignore[index]
            function.__code__.co_freevars.index(name.id)
        ]
        value = outer_value(function, name.id)
        if value is ...:
            raise Unwritable(f"{name.id!r} has no value yet")
        if isinstance(value, PARTS):
            stand_in = f"__part_{id(value)}"
            self.parts[stand_in] = value
            return stand_in
        if id(value) in self.names:
            return self.names[id(value)][0]
        if id(cell) not in self.names:
            wish = self._unique(name.id)
            self.names[id(cell)] = (wish, cell)
            node = self.expression(value, wish if isinstance(value, types.FunctionType) else "")
            if not (isinstance(node, ast.Name) and node.id == wish):
                self.made[wish] = node
        return self.names[id(cell)][0]

    def _defaults(self, function: types.FunctionType, node: Any) -> ast.arguments:
        """The arguments of a function with its defaults."""
        old = node.args
        defaults = [
            self._default(d, v)
            for d, v in zip(old.defaults, function.__defaults__ or (), strict=True)
        ]
        kw = function.__kwdefaults__ or {}
        kw_defaults = [
            d and self._default(d, kw[a.arg])
            for a, d in zip(old.kwonlyargs, old.kw_defaults, strict=True)
        ]
        if all(
            a is b
            for a, b in zip(
                [*defaults, *kw_defaults], [*old.defaults, *old.kw_defaults], strict=True
            )
        ):
            return old
        new = copy.copy(old)
        new.defaults, new.kw_defaults = defaults, kw_defaults
        return new

    def _default(self, node: ast.expr, value: Any) -> ast.expr:
        return node if isinstance(node, ast.Constant) else self.expression(value)

    def _unique(self, wish: str) -> str:
        taken = {*self.namespace, *self.made, *dir(builtins), *(n for n, _ in self.names.values())}
        name, i = wish, 2
        while name in taken or keyword.iskeyword(name):
            name, i = f"{wish}_{i}", i + 1
        return name


def _parsed(text: str) -> ast.expr:
    return _without_places(ast.parse(text, mode="eval").body)


def _without_places(node: Any) -> Any:
    """A node that is not in the script's source."""
    for inner in ast.walk(node):
        for name in ("lineno", "end_lineno", "col_offset", "end_col_offset"):
            inner.__dict__.pop(name, None)
    return node


def _substituted(node: Any, renamed: Mapping[str, str], outer: set[str]) -> Any:
    """A function with new names for its outer names, which are now globals."""
    memo: dict[int, Any] = {}
    out = copy.deepcopy(node, memo)
    for old in inner_names(node):
        memo[id(old)].id = renamed.get(old.id, old.id)
    for inner in ast.walk(out):
        body: Any = getattr(inner, "body", None)
        for i, statement in enumerate(body if isinstance(body, list) else ()):
            if isinstance(statement, ast.Nonlocal) and set(statement.names) <= outer:
                body[i] = ast.Global([renamed.get(n, n) for n in statement.names])
    return out


def _short(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."
