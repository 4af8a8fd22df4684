"""Plain values as texts, so that two processes can compare what they hold."""

from __future__ import annotations

import copyreg
import dis
import os
import random
import sys
import types
import zlib
from collections import deque
from collections.abc import Mapping
from contextvars import ContextVar
from typing import Any

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from .._core.pathsim_internals import OF_A_RUN, ON
from ..scripts.script import FOLLOWING, Script

_NUMBERS = (bool, int, float, complex)
_DEEP = 20
MODEL = "rehearsed"  # the module that a model's code is in
# a script's calls are made in `Script`, which named tuples take for their module
_OWN = ("__main__", MODEL, Script.__module__)
# the flight sets the state of these
_GLOBAL_GENERATORS = (random._inst, np.random.mtrand._rand)  # type: ignore[attr-defined]
# generators, counters, files: what they give next depends on what was read before
_STATEFUL = {*sys.stdlib_module_names, "numpy", "pathsim", "scipy"}
PARTS = (Block, Connection, Event, Simulation)


def text_of(value: Any, _around: tuple[int, ...] = ()) -> str:
    """A text that is equal for equal plain values, of any depth.

    Plain are numbers, texts, arrays, collections, objects of Python, numpy, scipy and PathSim, and
    of classes that a script defines, with their state. Of anything else, and of parts of a diagram,
    it is the type only.
    """
    if type(value).__module__ in _OWN and not (id(value) in _around or len(_around) > _DEEP):
        inside = (*_around, id(value))
        state = _state(value, inside), text_of(getattr(value, "__dict__", None), inside)
        return f"{_kind(value)}{state} {text_of(type(value), inside)}"
    if value is None or isinstance(value, (*_NUMBERS, str, bytes, range, slice)):
        return repr(value) if type(value) in _NUMBERS else f"{_kind(value)}({value!r})"
    if isinstance(value, (np.ndarray, np.generic)):
        return f"{_kind(value)}({value.dtype}, {value.shape}, {_items(value.tolist(), _around)})"
    if id(value) in _around or len(_around) > _DEEP:
        return "..."
    if value is os or value is os.getenv:
        value = os.environ
    inside = (*_around, id(value))
    if isinstance(value, Mapping):
        pairs = [f"{text_of(k, inside)}: {text_of(v, inside)}" for k, v in value.items()]
        return f"{_kind(value)}{{{', '.join(pairs)}}}"
    if isinstance(value, (list, tuple, deque)):
        return f"{_kind(value)}[{', '.join(text_of(v, inside) for v in value)}]"
    if isinstance(value, (set, frozenset)):
        return f"{_kind(value)}[{', '.join(sorted(text_of(v, inside) for v in value))}]"
    if isinstance(value, types.FunctionType):
        code = _of_code(value.__code__, value.__globals__)
        return f"function{code}{text_of({**_own_values(value), **vars(value)}, inside)}"
    if isinstance(value, (staticmethod, classmethod)):
        return f"{_kind(value)}({text_of(value.__func__, inside)})"
    if isinstance(value, property):
        return f"property{text_of([value.fget, value.fset, value.fdel], inside)}"
    if isinstance(value, types.ModuleType) or any(value is g for g in _GLOBAL_GENERATORS):
        return _kind(value)
    if isinstance(value, types.GeneratorType):
        begun = value.gi_frame and (value.gi_frame.f_lasti >= 0, value.gi_frame.f_locals)
        return f"generator{text_of(begun, inside)}"
    if isinstance(value, type):
        if value.__module__ not in _OWN:
            return f"{value.__module__}.{value.__qualname__}"
        own = {
            k: v
            for k, v in vars(value).items()
            if not k.startswith("__") or isinstance(v, types.FunctionType)
        }
        return f"class {value.__qualname__} {text_of(own, inside)}"
    if type(value).__module__.partition(".")[0] in _STATEFUL and not isinstance(value, PARTS):
        return f"{_kind(value)}({_state(value, inside)})"
    return _kind(value)


def _state(value: Any, around: tuple[int, ...]) -> str:
    """What would be pickled, and where a file stands; else its attributes."""
    if isinstance(value, ContextVar):
        return text_of(value.get(None), around)
    place = None
    try:
        place = value.tell() if hasattr(value, "tell") else None
        make, given, *state = value.__reduce_ex__(2)
        if make is copyreg.__newobj__:  # type: ignore[attr-defined]
            given = given[1:]
        parts = [s for s in (place, given, *state) if s is not None and s != ()]
    except Exception:  # classes refuse in ways of their own
        parts = [place, getattr(value, "__dict__", {})]
        if hasattr(value, "__next__") and place is None:
            parts = [id(value)]  # what it gives next cannot be read: it equals nothing else
    return text_of(parts, around)


def attributes(part: Any) -> dict[str, str]:
    """The attributes of a block or an event as texts, private ones of PathSim's classes only.

    PathSim keeps a parameter that may change later under ``_p_`` and its name.
    """
    kind = next(c for c in type(part).__mro__ if c.__module__ not in _OWN)
    of_pathsim = kind.__module__.startswith("pathsim.")
    return {
        name.removeprefix("_p_"): text_of(value)
        for name, value in vars(part).items()
        if name == ON or not (name in _ELSEWHERE or (name[0] == "_" and not of_pathsim))
    }


# wires are compared by their numbers, what a subsystem consists of by `structure`, and what a
# run changes by the flight
_ELSEWHERE = {"input_port_labels", "output_port_labels", "blocks", "connections", *OF_A_RUN}


def _items(value: Any, around: tuple[int, ...]) -> str:
    return text_of(value, around) if isinstance(value, list) else repr(value)


def _kind(value: Any) -> str:
    kind = type(value)
    own = kind.__module__ in ("builtins", *_OWN)
    return kind.__qualname__ if own else f"{kind.__module__}.{kind.__qualname__}"


def _of_code(code: types.CodeType, variables: Mapping[str, Any]) -> str:
    """Constants, names and operators in a code, in their order, and those of functions in it.

    Not what the way into a model changes: the calls that follow a script's own, texts of several
    lines, names of inner functions and of parts of the diagram.
    """
    constants = [
        _of_code(c, variables) if isinstance(c, types.CodeType) else text_of(c)
        for c in code.co_consts
        if not (isinstance(c, bytes) or (isinstance(c, str) and ("\n" in c or "<locals>" in c)))
    ]
    says = []
    for i in dis.get_instructions(code):
        if i.opname.startswith(("BINARY", "INPLACE", "UNARY", "COMPARE")):
            says.append(i.opname + i.argrepr)
        elif i.opcode in dis.hasname and i.argval not in FOLLOWING:
            part = i.opname == "LOAD_GLOBAL" and isinstance(variables.get(i.argval), PARTS)
            says += [] if part else [i.argval]
    return f"{constants}{says}"


def _own_values(function: types.FunctionType) -> dict[str, Any]:
    """Default values of a function and variables around it, without parts of a diagram."""
    code, defaults = function.__code__, function.__defaults__ or ()
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    own = dict(zip(code.co_varnames[code.co_argcount - len(defaults) :], defaults, strict=False))
    own |= function.__kwdefaults__ or {}
    own |= {name: cell.cell_contents for name, cell in cells.items()}
    used = [function.__globals__.get(name) for name in code.co_names]
    sources = (random, np.random, *_GLOBAL_GENERATORS)
    if "random" in code.co_names or any(
        getattr(u, "__self__", u) is s for u in used for s in sources
    ):
        state = text_of([random.getstate(), np.random.get_state()])  # noqa: NPY002
        own["random"] = f"global generators in state {zlib.crc32(state.encode())}"
    return {k: own[k] for k in sorted(own) if not isinstance(own[k], PARTS)}
