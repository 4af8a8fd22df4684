"""Compare the diagram of a script with the one that its model builds, value by value."""

from __future__ import annotations

import ast
import builtins
import copy
import enum
import functools
import types
import weakref
from collections import deque
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pathsim import Simulation, Subsystem
from pathsim.blocks import Block
from pathsim.utils.graph import Graph
from pathsim.utils.register import Register

from .._core._pathsim import own_events, port_number
from .names import bound, references

_FUNCTION_NODES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
_DERIVED = (Graph,)  # drawn from blocks and connections, which are compared themselves
_LABELS = {"input_port_labels", "output_port_labels"}  # wires are compared by their numbers


@dataclass(frozen=True)
class Difference:
    """A value of the script's diagram that the model does not have.

    Attributes
    ----------
    part : object
        the block, event or simulation of the script
    path : tuple of str
        attributes and items that lead to the value, from the part
    name : str
        the name in the script's functions by which it is reached, or empty
    here, there : object
        the script's value and the model's
    """

    part: Any
    path: tuple[str, ...]
    name: str
    here: Any
    there: Any

    @property
    def attribute(self) -> str:
        """The attribute of the part in which it is."""
        return self.path[0].removeprefix(".") if self.path else ""

    def __str__(self) -> str:
        where = "".join(self.path).lstrip(".") or type(self.part).__name__
        return f"{where} is {short(self.here)}, and {short(self.there)} in the model"


def short(value: Any) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) <= 60 else f"{text[:57]}..."


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

    def attributes(self, nodes: Iterable[ast.AST]) -> set[str]:
        """Names of attributes that functions read, and the methods that they may call."""
        todo = [
            *nodes,
            *(
                n
                for n in self._nodes
                if getattr(n, "name", "").startswith("__") and n.name != "__init__"
            ),
        ]
        read: set[str] = set()
        while todo:
            new = {n.attr for n in ast.walk(todo.pop()) if isinstance(n, ast.Attribute)} - read
            read |= new
            todo += [n for n in self._nodes if getattr(n, "name", "") in new]
        return read


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


class Comparison:
    """Two simulations, and what is different in the second.

    Parameters
    ----------
    here, there : Simulation
        of the script and of its model
    parts, parts_there : mapping
        their blocks and events, those of subsystems included, by common names
    functions, functions_there : Functions
        those of both sources

    Attributes
    ----------
    differences : list of Difference
        empty if both simulate the same
    opaque : list
        parts with values that cannot be compared
    """

    def __init__(
        self,
        here: Simulation,
        there: Simulation,
        parts: Mapping[str, Any],
        parts_there: Mapping[str, Any],
        functions: Functions,
        functions_there: Functions,
    ):
        self.differences: list[Difference] = []
        self.opaque: list[Any] = []
        self._functions = functions, functions_there
        self._names = {id(p): name for name, p in parts.items()}
        self._names_there = {id(p): name for name, p in parts_there.items()}
        self._partner = {id(here): there, **{id(p): parts_there[n] for n, p in parts.items()}}
        self._seen: dict[tuple[int, int], tuple[Any, Any]] = {}
        self._held: list[tuple[str, Any, Any, Any]] = []
        self._called: list[ast.AST] = []
        self._at: tuple[Any, tuple[str, ...], str] = (here, (), "")
        self._structure(here, there)
        for name, part in parts.items():
            self._at = (part, (), "")
            self._part(part, parts_there[name])
        self._at = (here, (), "")
        for name in (
            "dt",
            "dt_min",
            "dt_max",
            "Solver",
            "tolerance_fpi",
            "iterations_max",
            "time",
            "_active",
        ):
            self._inside(f".{name}", getattr(here, name), getattr(there, name))
        if here.engine.is_adaptive != there.engine.is_adaptive:
            self._differ(here.engine, there.engine)
        read = functions.attributes(self._called) if self._held else set()
        for name, place, mine, theirs in self._held:
            if name in read or "__dict__" in read:
                self._at = place
                self._inside(f".{name}", mine, theirs)

    def name(self, part: Any) -> str:
        """The common name of one of the first simulation's parts."""
        return self._names.get(id(part), "")

    # structure ----------------------------------------------------------------------------------

    def _structure(self, here: Any, there: Any) -> None:
        for what, parts in (("blocks", _blocks), ("events", _events)):
            a = {self._names.get(id(p)) for p in parts(here)}
            b = {self._names_there.get(id(p)) for p in parts(there)}
            self._inside(f".{what}", a, b)
        self._inside(".connections", _wires(here, self._names), _wires(there, self._names_there))

    def _part(self, here: Any, there: Any) -> None:
        extra = type(here) is not type(there)  # a script's class that only adds __init__
        if extra and not issubclass(type(here), type(there)):
            self._differ(type(here), type(there))
            return
        if isinstance(here, Subsystem):
            self._structure(here, there)
        self._attributes(
            here,
            there,
            {
                "blocks",
                "connections",
                "_events",
                "interface",
                "graph",
                "_blocks_dyn",
                "_blocks_evt",
                "boosters",
                "_solver_args",
                "_solver_parent",
                *_LABELS,
            }
            if isinstance(here, Subsystem)
            else _LABELS,
            extra,
        )

    def _attributes(
        self, here: Any, there: Any, skip: Collection[str], extra: bool = False
    ) -> None:
        mine, theirs = _state(here), _state(there)
        for name in mine.keys() | theirs.keys():
            if name in skip or (extra and name not in theirs):
                continue
            if id(mine.get(name)) in self._partner and id(here) not in self._partner:
                # an object of the script that holds a part: compared only if something reads it
                self._held.append((name, self._at, mine[name], theirs.get(name)))
                continue
            self._inside(f".{name}", mine.get(name, ...), theirs.get(name, ...))

    # values -------------------------------------------------------------------------------------

    def _differ(self, here: Any, there: Any) -> None:
        part, path, name = self._at
        self.differences.append(Difference(part, path, name, here, there))

    def _inside(self, step: str, here: Any, there: Any, name: str = "") -> None:
        before = self._at
        self._at = (before[0], (*before[1], step), name or before[2])
        self._compare(here, there)
        self._at = before

    def _compare(self, here: Any, there: Any) -> None:
        if id(here) in self._partner:
            if self._partner[id(here)] is not there:
                self._differ(here, there)
            return
        if here is there or isinstance(here, _DERIVED):
            return
        if (id(here), id(there)) in self._seen:
            return
        self._seen[id(here), id(there)] = (here, there)
        for kinds, compare in self._ways():
            if isinstance(here, kinds) and isinstance(there, kinds):
                compare(here, there)
                return
        if type(here) is not type(there) and not self._same_class(type(here), type(there)):
            self._differ(here, there)
        else:
            self._object(here, there)

    def _ways(self) -> Sequence[tuple[Any, Callable[[Any, Any], None]]]:
        return (
            ((bool, np.bool_), self._equal),
            ((int, float, complex, np.number), self._number),
            ((str, bytes, range, enum.Enum), self._equal),
            (np.ndarray, self._array),
            (
                np.random.Generator,
                lambda a, b: self._inside(".state", a.bit_generator.state, b.bit_generator.state),
            ),
            (
                np.random.RandomState,
                lambda a, b: self._inside(
                    ".state", a.get_state(legacy=False), b.get_state(legacy=False)
                ),
            ),
            (Register, self._register),
            (Mapping, self._mapping),
            ((list, tuple, deque), self._sequence),
            ((set, frozenset), self._equal),
            (types.FunctionType, self._function),
            (types.MethodType, self._method),
            (types.BuiltinMethodType, self._builtin),
            (
                functools.partial,
                lambda a, b: self._sequence(
                    [a.func, a.args, a.keywords], [b.func, b.args, b.keywords]
                ),
            ),
            (weakref.ref, lambda a, b: self._compare(a(), b())),
            (type, lambda a, b: None if self._same_class(a, b) else self._differ(a, b)),
        )

    def _equal(self, here: Any, there: Any) -> None:
        if here != there:
            self._differ(here, there)

    def _number(self, here: Any, there: Any) -> None:
        # 2 and 2.0 differ in overflow and division
        if isinstance(here, (int, np.integer)) != isinstance(there, (int, np.integer)) or not (
            here == there or (here != here and there != there)
        ):
            self._differ(here, there)

    def _array(self, here: np.ndarray, there: np.ndarray) -> None:
        if here.dtype != there.dtype or here.shape != there.shape:
            self._differ(here, there)
        elif here.dtype == object:
            self._sequence(here.ravel().tolist(), there.ravel().tolist())
        elif not np.array_equal(here, there, equal_nan=here.dtype.kind in "fc"):
            self._differ(here, there)

    def _register(self, here: Register, there: Register) -> None:
        # registers may differ in length: they grow with their wires until the run begins
        a, b = here.to_array(), there.to_array()
        n = max(len(a), len(b))
        self._compare(*(np.concatenate([x, np.zeros(n - len(x))]) for x in (a, b)))

    def _mapping(self, here: Mapping[Any, Any], there: Mapping[Any, Any]) -> None:
        if here.keys() != there.keys():
            self._differ(here, there)
            return
        for key in here:
            self._inside(f"[{short(key)}]", here[key], there[key])

    def _sequence(self, here: Sequence[Any], there: Sequence[Any]) -> None:
        if type(here) is not type(there) or len(here) != len(there):
            self._differ(here, there)
            return
        for i, (a, b) in enumerate(zip(here, there, strict=True)):
            self._inside(f"[{i}]", a, b)

    def _function(self, here: types.FunctionType, there: types.FunctionType) -> None:
        if here.__code__ is there.__code__:  # of a library
            self._sequence(list(here.__defaults__ or ()), list(there.__defaults__ or ()))
            for name in here.__code__.co_freevars:
                self._inside(f".{name}", outer_value(here, name), outer_value(there, name))
            return
        node, node_there = (f.node(g) for f, g in zip(self._functions, (here, there), strict=True))
        if node is None or node_there is None:
            self._differ(here, there)
            return
        self._called.append(node)
        names, names_there = inner_names(node), inner_names(node_there)
        if _shape(node) != _shape(node_there) or len(names) != len(names_there):
            self._differ(here, there)
            return
        self._inside(" default", [*(here.__defaults__ or ())], [*(there.__defaults__ or ())])
        self._inside(" default", here.__kwdefaults__ or {}, there.__kwdefaults__ or {})
        for a, b in zip(names, names_there, strict=True):
            name = "" if a.id in here.__code__.co_freevars else a.id
            self._inside(f" {a.id}", outer_value(here, a.id), outer_value(there, b.id), name)

    def _method(self, here: types.MethodType, there: types.MethodType) -> None:
        self._inside(" self", here.__self__, there.__self__)
        self._compare(here.__func__, there.__func__)

    def _builtin(self, here: types.BuiltinMethodType, there: types.BuiltinMethodType) -> None:
        if here.__name__ != there.__name__:
            self._differ(here, there)
        else:
            self._inside(" self", here.__self__, there.__self__)

    def _object(self, here: Any, there: Any) -> None:
        mine = _state(here)
        if mine or _state(there):
            self._attributes(here, there, set())
            return
        try:
            states = [x.__reduce_ex__(4) for x in (here, there)]
        except Exception:
            self.opaque.append(self._at[0])
            return
        if isinstance(states[0], str):
            self._equal(*states)
        else:
            self._sequence(*([f for f in s[1:] if f is not None] for s in states))

    def _same_class(self, here: type, there: type) -> bool:
        """Same class, or the model's version of a class of the script."""
        return here is there or (
            here.__qualname__ == there.__qualname__
            and there.__module__ in ("builtins", "__main__", "rebuilt")
        )


def _blocks(system: Any) -> list[Block]:
    blocks = list(system.blocks)
    return [system.interface, *blocks] if isinstance(system, Subsystem) else blocks


def _events(system: Any) -> list[Any]:
    return own_events(system) if isinstance(system, Subsystem) else system.events


def _wires(system: Any, names: Mapping[int, str]) -> set[tuple[str | None, int, str | None, int]]:
    """The wires of a system that are in use."""
    return {
        (
            names.get(id(c.source.block)),
            port_number(c.source.block.outputs, out),
            names.get(id(target.block)),
            port_number(target.block.inputs, into),
        )
        for c in system.connections
        if c
        for target in c.targets
        for out, into in zip(c.source.ports, target.ports, strict=True)
    }


def _state(value: Any) -> dict[str, Any]:
    """The attributes of an object, including those in slots."""
    state = dict(getattr(value, "__dict__", {}))
    for kind in type(value).__mro__:
        slots = kind.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if name not in ("__dict__", "__weakref__"):
                state[name] = getattr(value, name, ...)
    return state


def inner_names(node: Any) -> list[ast.Name]:
    """Names of outer scopes that a function uses when it is called."""
    body = _body(node)
    local = frozenset(_argument_names(node)) | bound(body)
    return [name for part in body for name in references(part, local)]


def _shape(node: Any) -> str:
    """What a function does, regardless of its own name and the names of outer scopes."""
    memo: dict[int, Any] = {}
    body = [copy.deepcopy(part, memo) for part in _body(node)]
    for name in inner_names(node):
        memo[id(name)].id = "?"
    for part in body:
        for inner in ast.walk(part):
            if isinstance(inner, (ast.Global, ast.Nonlocal)):
                inner.names = []
    text = " ".join(map(ast.dump, body)).replace("Nonlocal(", "Global(")
    return f"{_argument_names(node)} {text}"
