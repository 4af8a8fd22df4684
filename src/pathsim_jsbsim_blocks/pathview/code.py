"""The code of a model: the definitions that its expressions need, written from live values.

Names and expressions of the script are kept if they give the live value.
"""

from __future__ import annotations

import ast
import builtins
import collections
import copyreg
import functools
import math
import operator
import random
import re
import sys
import types
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from ..scripts.names import assignments, references
from ..scripts.script import FOLLOWING
from .expressions import Expressions
from .first_run import FirstRun
from .shape import shortened
from .sources import SourceNode, first_line, of_class, of_function, one_line, text_of, with_comments
from .variables import TAKEN, unique

PARTS = (Block, Event, Simulation)
_STAND_IN = re.compile(r"__part_(\d+)")
_DEFINITION = re.compile(r"(#.*\n)*(@|def |class )")
_SCALARS = {np.dtype(code).type for code in "?bBhHiIlLqQefdFD"}
_CONTAINERS = (list, tuple, dict, set, np.ndarray)
# by the generators behind their functions
_SHARED: dict[int, Any] = {id(m.random.__self__): m for m in (np.random, random)}
_LOCALS = {"globals", "locals", "vars", "eval", "exec"}


class Unwritable(Exception):
    """A value that cannot be written as Python; the text says why."""


@dataclass
class Piece:
    """A definition, with stand-ins for parts of the diagram."""

    text: str = ""
    line: float = math.inf  # of the script
    end: float = math.inf
    needs: set[str] = field(default_factory=set)


class Code:
    """Writes values as expressions, with the definitions that these need."""

    def __init__(self, script: FirstRun):
        self.script = script
        self.expressions = Expressions(script)
        self.parts: dict[int, Any] = {}  # to which functions refer, by id
        self._pieces: dict[str, Piece] = {}
        self._states: list[Piece] = []
        self._texts: dict[int, tuple[str, Any]] = {}  # by id of a value, stored to keep the id
        self._variables: dict[tuple[int, str], str] = {}  # by namespace and name
        self._needs: list[set[str]] = [set()]
        self.inner: set[str] = set()  # variables of functions, which would hide a part of that name
        self._late: set[tuple[int, str]] = set()  # classes, and their attributes that are blocks

    @property
    def names(self) -> set[str]:
        """The names that the code binds."""
        return self._pieces.keys() | {"np"}

    def text(self, variables: Mapping[str, str]) -> str:
        """The source: definitions in the script's order, each after its dependencies."""
        order: list[Piece] = []

        def add(piece: Piece) -> None:
            if piece.text and piece not in order and piece not in stack:
                stack.append(piece)
                for name in sorted(piece.needs, key=lambda n: (self._pieces[n].line, n)):
                    add(self._pieces[name])
                order.append(piece)

        stack: list[Piece] = []
        for piece in sorted(self._pieces.values(), key=lambda p: p.line):
            add(piece)
        lines: list[str] = []
        end = 0.0
        for piece in [*order, *self._states]:
            gap = lines and (piece.line > end + 1 or _DEFINITION.match(piece.text))
            lines.append(("\n" if gap and piece.line != math.inf else "") + piece.text)
            end = piece.end
        return self.filled("\n".join(lines).lstrip("\n"), variables)

    def filled(self, text: str, variables: Mapping[str, str]) -> str:
        return _STAND_IN.sub(lambda match: variables[match[0]], text)

    # expressions ----------------------------------------------------------------------------------

    def kept(self, node: ast.expr, value: Any) -> str:
        """An expression of the script if it is plain and gives the value; else empty."""
        if not self.expressions.gives(node, value):
            return ""
        return one_line(self._spliced(SourceNode(node, self.script.source), node))

    def parameter(self, value: Any, wish: str) -> str:
        """An expression for a value that the code alone can evaluate."""
        text = self.expression(value, wish)
        if _STAND_IN.search(text) and not text.startswith("lambda"):
            if isinstance(value, types.MethodType):
                return f"lambda *args: {text}(*args)"
            raise Unwritable(f"{_short(value)} contains blocks")
        return one_line(text)

    def expression(self, value: Any, wish: str) -> str:
        """An expression for a value; one with an identity gets a definition named like ``wish``."""
        if id(value) in self._texts:
            text = self._texts[id(value)][0]
            self._need(text)
            return text
        if part := self._part(value):
            return part
        if (text := _scalar(value)) or (text := self._container(value, wish)):
            return text
        if isinstance(value, Connection):
            raise Unwritable("PathView has no names for connections")
        if isinstance(value, types.ModuleType):
            return self._module(value, wish)
        if text := self._imported(value):
            return text
        if isinstance(value, types.MethodType):
            owner = value.__self__
            text = self.expression(owner, type(owner).__name__.lower())
            return f"{text}.{value.__func__.__name__}"
        if _is_lambda(value):
            return self._function(value)
        return self._defined(value, getattr(value, "__name__", wish))

    def _part(self, value: Any) -> str:
        """A stand-in for a part of the diagram; else empty."""
        if not isinstance(value, PARTS):
            return ""
        self.parts[id(value)] = value
        return f"__part_{id(value)}"

    def _container(self, value: Any, wish: str) -> str:
        def each(items: Any) -> str:
            return ", ".join(self.expression(item, wish) for item in items)

        if isinstance(value, np.ndarray) and type(value) is np.ndarray and value.dtype != object:
            if value.dtype.kind not in "biufcU":  # e.g. structured
                raise Unwritable(f"an array of {value.dtype} cannot be written")
            keeps_type = value.size and np.array(value.tolist()).dtype == value.dtype
            shape = "" if value.size else f".reshape({value.shape})"
            dtype = "" if keeps_type else f", dtype={str(value.dtype)!r}"
            return f"np.array({_numbers(value.tolist())}{dtype}){shape}"
        if type(value) is list:
            return f"[{each(value)}]"
        if type(value) is tuple:
            return f"({each(value)}{',' * (len(value) == 1)})"
        if type(value) is set:
            return f"{{{each(value)}}}" if value else "set()"
        if type(value) is dict:
            pairs = value.items()
            text = (f"{self.expression(k, wish)}: {self.expression(v, wish)}" for k, v in pairs)
            return f"{{{', '.join(text)}}}"
        return ""

    def variable(self, name: str, namespace: dict[str, Any], own: bool = False) -> str:
        """The model's name for a variable of a module; ``own`` if functions assign it."""
        if name in FOLLOWING or name not in namespace:
            if name in _LOCALS:
                raise Unwritable(f"{name}() depends on names that the model does not have")
            return name
        value, key = namespace[name], (id(namespace), name)
        if part := self._part(value):
            return part
        if value is np:
            return "np"
        if key in self._variables:
            self._need(self._variables[key])
            return self._variables[key]
        ours = namespace is self.script.namespace
        if ours and not own and self._as_written(name):
            self._variables[key] = name
            self._need(name)
        elif _holds_parts(value):
            return self._container(value, name)
        else:
            self._variables[key] = self._stored(value, name, own, ours)
        return self._variables[key]

    def _stored(self, value: Any, name: str, own: bool, ours: bool = False) -> str:
        """The name of a variable that has a value."""
        if isinstance(value, types.ModuleType):
            return self._module(value, name)
        has_name = isinstance(value, (type, types.FunctionType, types.MethodType))
        available = id(value) in self._texts or (has_name and not _is_lambda(value))
        if not own and (available or self._imported(value)):
            return self.expression(value, name)
        return self._defined(value, name, self.expressions.line(name) if ours else math.inf)

    def _need(self, text: str) -> None:
        if text in self._pieces:
            self._needs[-1].add(text)

    # definitions ----------------------------------------------------------------------------------

    def _free(self, wish: str, mine: Any = ...) -> str:
        """An unused name; a name that the script gives to this value counts as unused."""
        namespace = self.script.namespace

        def is_taken(name: str) -> bool:
            clash = name in namespace and namespace[name] is not mine
            return clash or name in self._pieces or bool(TAKEN.fullmatch(name))

        return unique(wish.strip("_") or "value", is_taken)

    def _defined(self, value: Any, wish: str, line: float = math.inf) -> str:
        """Define a value and return its name."""
        if wish.isidentifier() and isinstance(self.script.namespace.get(wish), PARTS):
            wish = f"{wish}_{'function' if callable(value) else 'value'}"
        variables = [n for n in self.script.names_of(value) if not _scalar(value)]
        wish = variables[0] if variables else wish
        name = self._free(wish if wish.isidentifier() else "value", value)
        piece = self._pieces[name] = Piece(line=line)
        if not _scalar(value):
            self._texts[id(value)] = name, value
        self._needs.append(piece.needs)
        # a cached function returns the same values without its cache
        has_cache = isinstance(value, functools._lru_cache_wrapper)
        function: Any = value.__wrapped__ if has_cache else value
        if isinstance(function, types.FunctionType) and not _is_lambda(function):
            definition = of_function(function)
            if definition and function.__code__.co_filename == str(self.script.path):
                piece.line, piece.end = function.__code__.co_firstlineno, definition.node.end_lineno
            lines = [self._function(function, name)]
            lines += [f"{name}.{k} = {self._attribute(v, k)}" for k, v in vars(function).items()]
            piece.text = "\n".join(lines)
        elif isinstance(value, type):
            self._class(value, name, piece)
        elif _is_lambda(value):
            piece.text = f"{name} = {self._function(value)}"
        elif text := _scalar(value) or self._container(value, name):
            piece.text = f"{name} = {text}"
        elif isinstance(value, np.ndarray):
            raise Unwritable(f"{_short(value)} is an array of objects, or has attributes")
        elif isinstance(value, types.ModuleType):
            kind = self.expression(types.SimpleNamespace, "SimpleNamespace")
            names = self.script.attributes_of(wish)
            fields = (f"{n}={self._attribute(getattr(value, n), n)}" for n in names)
            piece.text = f"{name} = {kind}({', '.join(fields)})"
        else:
            self._object(value, name, piece)
        self._needs.pop()
        self._need(name)
        return name

    def _as_written(self, name: str) -> bool:
        """Define a variable by its statement in the script, if this gives the live value."""
        if text := self.expressions.imported(name):
            line = self.expressions.line(name)
            self._pieces[name] = Piece(text, line, line)
            self._keep(name)
            return True
        assignment = self.expressions.assigned(name)
        if assignment is None or TAKEN.fullmatch(name) or name in self._pieces:
            return False
        statement, value = assignment
        source = SourceNode(statement, self.script.source)
        piece = Piece(line=first_line(source), end=statement.end_lineno or 0)
        self._pieces[name] = piece
        self._keep(name)
        self._needs.append(piece.needs)
        if value is getattr(statement, "value", None):
            piece.text = with_comments(source, self._spliced(source, statement))
        else:  # one of ``a, b = 1, 2``
            inner = self._spliced(SourceNode(value, self.script.source), value)
            piece.text = f"{name} = {one_line(inner)}"
        self._needs.pop()
        return True

    def _keep(self, name: str) -> None:
        """Use a name of the script for its value."""
        value = self.script.namespace[name]
        if not _scalar(value):
            self._texts.setdefault(id(value), (name, value))
        self._variables[id(self.script.namespace), name] = name

    def _spliced(self, part: SourceNode, node: Any, new: Mapping[ast.AST, str] = {}) -> str:
        """A node of the script with the model's names."""
        both = dict(new)
        for name in references(node):
            if isinstance(name.ctx, ast.Load):
                text = self.variable(name.id, self.script.namespace)
                both.update({name: text} if text != name.id else {})
        return text_of(part, both)

    def _module(self, module: types.ModuleType, wish: str) -> str:
        if self.script.is_beside(module.__name__):
            return self._defined(module, wish)
        if module is np.random:
            return "np.random"
        for name, piece in self._pieces.items():
            if piece.text in (f"import {module.__name__}", f"import {module.__name__} as {name}"):
                self._need(name)
                return name
        name = self._free(wish, module)
        alias = "" if module.__name__ == name else f" as {name}"
        self._pieces[name] = Piece(f"import {module.__name__}{alias}", -1)
        self._need(name)
        return name

    def _imported(self, value: Any) -> str:
        """An expression for a function or class that can be imported; else empty."""
        path = getattr(value, "__qualname__", None) or getattr(value, "__name__", None)
        name = getattr(value, "__module__", None)
        if isinstance(value, np.ufunc):
            name, path = "numpy", value.__name__
        if isinstance(value, types.BuiltinMethodType) and name is None:
            owner = getattr(value, "__self__", None)
            name = owner.__name__ if isinstance(owner, types.ModuleType) else None
        module = sys.modules.get(name or "")
        for variable in self.script.names_of(value) if not _scalar(value) else ():
            if self.expressions.imported(variable) and self._as_written(variable):
                self._need(variable)
                return variable
        if generator := _SHARED.get(id(getattr(value, "__self__", None))):
            return f"{self._module(generator, 'random')}.{value.__name__}"
        if not isinstance(path, str) or module is None or self.script.is_beside(name or ""):
            return ""
        top, *attributes = path.split(".")
        try:
            if operator.attrgetter(path)(module) is not value:
                return ""
        except AttributeError:
            return ""
        if module is builtins:
            return path
        if str(name).partition(".")[0] == "numpy" and getattr(np, path, None) is value:
            return f"np.{path}"
        first = getattr(module, top)
        alias, _ = self._texts.get(id(first), ("", None))
        if not alias:
            alias = self._free(top, first)
            text = f"from {name} import {top}" + ("" if alias == top else f" as {alias}")
            self._pieces[alias] = Piece(text, -1)
            self._texts[id(first)] = alias, first
        self._need(alias)
        return ".".join([alias, *attributes])

    # functions and classes ------------------------------------------------------------------------

    def _function(self, function: types.FunctionType, name: str = "") -> str:
        """The source of a function, with the model's names and live default values."""
        source, code = of_function(function), function.__code__
        if source is None:
            what = "a lambda" if not name else f"function {function.__name__!r}"
            raise Unwritable(f"the source of {what} is ambiguous; define it on its own lines")
        cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
        new: dict[ast.AST, str] = {}
        # a default that is a block is looked up at each call: it is built after the code
        for argument, text in self._defaults(function, source.node, new).items():
            body = source.node.body if isinstance(source.node.body, list) else [source.node.body]
            for node in (n for statement in body for n in ast.walk(statement)):
                if isinstance(node, ast.Name) and node.id == argument:
                    new[node] = text
        decorators = [n for d in getattr(source.node, "decorator_list", ()) for n in ast.walk(d)]
        without = {n for root in new for n in ast.walk(root)}.union(decorators)
        _Names(self, source.node, function.__globals__, cells).put(new, without)
        text = text_of(source, new)
        if _STAND_IN.search(text):
            for node in ast.walk(source.node):
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                    self.inner.add(node.id)
                elif isinstance(node, ast.arg):
                    self.inner.add(node.arg)
        if name:
            text = re.sub(rf"(def\s+){code.co_name}\b", rf"\g<1>{name}", text, count=1)
            text = with_comments(source, text)
        return one_line(text) if isinstance(source.node, ast.Lambda) else text

    def _defaults(
        self, function: types.FunctionType, node: Any, new: dict[ast.AST, str]
    ) -> dict[str, str]:
        """Write live default values; returns those that are parts, by argument."""
        arguments, keywords = node.args, function.__kwdefaults__ or {}
        positional = [*arguments.posonlyargs, *arguments.args]
        live = function.__defaults__ or ()
        pairs = [
            *zip(positional[len(positional) - len(live) :], arguments.defaults, live, strict=False),
            *((a, d, keywords[a.arg]) for a, d in zip(arguments.kwonlyargs, arguments.kw_defaults,
                                                    strict=True) if d and a.arg in keywords),
        ]  # fmt: skip
        parts: dict[str, str] = {}
        for argument, default, value in pairs:
            if _holds_parts(value):
                parts[argument.arg] = self.expression(value, argument.arg)
                new[default] = "None"
            elif not (
                isinstance(default, ast.Constant) and _scalar(default.value) == _scalar(value)
            ):
                new[default] = self.expression(value, argument.arg)
        return parts

    def cell(self, cell: Any, name: str, own: bool) -> str:
        """The model's name for a variable of the enclosing function."""
        try:
            value = cell.cell_contents
        except ValueError:
            raise Unwritable(f"{name!r} has no value when the run begins") from None
        if id(cell) not in self._texts:
            if part := self._part(value):
                return part
            if _holds_parts(value):
                return self._container(value, name)
            if isinstance(value, types.MethodType):
                return self.expression(value, name)
            self._texts[id(cell)] = self._stored(value, name, own), cell
        text = self._texts[id(cell)][0]
        self._need(text)
        return text

    def _class(self, kind: type, name: str, piece: Piece) -> None:
        """The source of a class, and its attributes that have changed."""
        path, namespace = self.script.file_of(kind.__module__)
        functions = dict(_functions_of(kind, path))
        if issubclass(kind, tuple) and hasattr(kind, "_fields") and not functions:
            fields = list(kind._fields)
            make = self.expression(collections.namedtuple, "namedtuple")
            piece.text = f"{name} = {make}({kind.__name__!r}, {fields!r})"
            return
        lines = [f.__code__.co_firstlineno for f in functions.values()]
        tree = of_class(kind.__name__, path, lines)
        if tree is None:
            raise Unwritable(f"the source of class {kind.__name__!r} is missing or ambiguous")
        cells = {
            n: c
            for f in functions.values()
            for n, c in zip(f.__code__.co_freevars, f.__closure__ or (), strict=True)
            if n != "__class__"
        }
        new: dict[ast.AST, str] = {}
        _Names(self, tree.node, namespace, cells).put(new)
        text = re.sub(rf"(class\s+){kind.__name__}\b", rf"\g<1>{name}",
                      text_of(tree, new, decorated=True), count=1)  # fmt: skip
        if path == str(self.script.path):
            piece.line, piece.end = tree.node.lineno, tree.node.end_lineno or 0
        piece.text = "\n".join([with_comments(tree, text), *self._changed(kind, name, tree.node)])

    def _changed(self, kind: type, name: str, source: ast.ClassDef) -> Iterator[str]:
        """Assignments of a class's numbers and texts that differ from its source."""
        nodes = {target.id: value for s in source.body for target, value in assignments(s)}
        for attribute, value in list(vars(kind).items()):
            if _scalar(value) and not attribute.endswith("_"):  # dunder names are Python's
                node = nodes.get(attribute)
                if node is None or not self.expressions.gives(node, value):
                    yield f"{name}.{attribute} = {self.expression(value, attribute)}"

    # objects --------------------------------------------------------------------------------------

    def _object(self, value: Any, name: str, piece: Piece) -> None:
        """An object as pickle would rebuild it."""
        try:
            recipe = value.__reduce_ex__(4)
        except Exception as error:
            raise Unwritable(f"{_short(value)} cannot be written ({error})") from None
        if isinstance(recipe, str):
            raise Unwritable(f"{_short(value)} cannot be written")
        make, arguments, state, items, pairs = (*recipe, None, None, None)[:5]
        if make is copyreg.__newobj__:  # type: ignore[attr-defined]
            text = f"{self.expression(type(value), type(value).__name__)}.__new__"
        else:
            text = self.expression(make, getattr(make, "__name__", "make"))
        arguments = ", ".join(self.expression(a, name) for a in arguments)
        piece.text = f"{name} = {text}({arguments})"
        states = Piece()
        self._needs.append(set())  # states come last, after all definitions
        lines = [*self._state(value, name, state)]
        lines += [f"{name}.append({self.expression(i, name)})" for i in items or ()]
        for k, v in pairs or ():
            lines.append(f"{name}[{self.expression(k, name)}] = {self.expression(v, name)}")
        self._needs.pop()
        states.text = "\n".join(lines)
        if _STAND_IN.search(piece.text):
            raise Unwritable(f"{_short(value)} contains blocks")
        if lines:
            self._states.append(states)

    def _state(self, value: Any, name: str, state: Any) -> Iterator[str]:
        if state is None:
            return
        slots: dict[str, Any] = {}
        if isinstance(state, tuple) and len(state) == 2 and isinstance(state[1], dict):
            state, slots = state[0] or {}, state[1]
        if hasattr(value, "__setstate__") or not isinstance(state, dict):
            yield f"{name}.__setstate__({self.expression(state, name)})"
            return
        late = {k: v for k, v in state.items() if _holds_parts(v)}
        texts = {k: self._attribute(v, k) for k, v in state.items() if k not in late}
        if texts:
            fields = ", ".join(f"{k}={v}" for k, v in texts.items() if str(k).isidentifier())
            yield f"{name}.__dict__.update({fields})"
        for k, v in slots.items():
            yield f"{name}.{k} = {self._attribute(v, k)}"
        if late:
            kind = type(value)
            blocks = ", ".join(f"{k!r}: lambda: {self.expression(v, k)}" for k, v in late.items())
            yield f"{name}._blocks = {{{blocks}}}"
            for k in late:
                if (id(kind), k) not in self._late:
                    self._late.add((id(kind), k))
                    owner = self.expression(kind, kind.__name__)
                    yield f"{owner}.{k} = property(lambda self: self._blocks[{k!r}]())"

    def _attribute(self, value: Any, name: str) -> str:
        if type(value) in _CONTAINERS and id(value) not in self._texts:
            return self._defined(value, name)
        return self.expression(value, name)


class _Names:
    """The model's names for those in a function or class."""

    def __init__(
        self, code: Code, node: Any, namespace: dict[str, Any], cells: Mapping[str, Any]
    ):  # fmt: skip
        self.code, self.node, self.namespace, self.cells = code, node, namespace, cells
        self.declared = [n for n in ast.walk(node) if isinstance(n, (ast.Global, ast.Nonlocal))]
        self.own = {name for n in self.declared for name in n.names}  # assigned by the function

    def text(self, name: str) -> str:
        if name in self.cells:
            return self.code.cell(self.cells[name], name, name in self.own)
        return self.code.variable(name, self.namespace, name in self.own)

    def put(self, new: dict[ast.AST, str], without: Container[ast.AST] = ()) -> None:
        """Add the references whose names differ in the model."""
        for reference in references(self.node):
            if reference not in without and (text := self.text(reference.id)) != reference.id:
                new[reference] = text
        for node in self.declared:
            if isinstance(node, ast.Global) or self.cells.keys() >= {*node.names}:
                new[node] = "global " + ", ".join(map(self.text, node.names))


def _scalar(value: Any) -> str:
    """A literal of a number, text or the like; else empty."""
    if type(value) in _SCALARS:
        return f"np.{type(value).__name__}({_scalar(value.item())})"
    if value is None or value is ... or type(value) in (bool, int, str, bytes):
        return repr(value)
    if type(value) in (float, complex):
        text = repr(value).replace("inf", "np.inf").replace("nan", "np.nan")
        if type(value) is complex and "np." in text:
            return f"complex({_scalar(value.real)}, {_scalar(value.imag)})"
        return text
    return ""


def _numbers(value: Any) -> str:
    """A literal of nested lists, as `numpy.ndarray.tolist` gives them."""
    if isinstance(value, list):
        return f"[{', '.join(map(_numbers, value))}]"
    return _scalar(value)


def _is_lambda(value: Any) -> bool:
    return isinstance(value, types.FunctionType) and value.__name__ == "<lambda>"


def _holds_parts(value: Any) -> bool:
    """Whether a value is a part of a diagram, or a collection with one."""
    if isinstance(value, (list, tuple, set)):
        return any(map(_holds_parts, value))
    if isinstance(value, dict):
        return any(map(_holds_parts, value.values()))
    return isinstance(value, PARTS)


def _functions_of(kind: type, path: str) -> Iterator[tuple[str, Any]]:
    """The functions of a class that are written in a file."""
    for name, value in vars(kind).items():
        for part in (value, *(getattr(value, n, None) for n in ("__func__", "fget", "fset"))):
            if isinstance(part, types.FunctionType) and part.__code__.co_filename == path:
                yield name, part


def _short(value: Any) -> str:
    return shortened(" ".join(repr(value).split()))
