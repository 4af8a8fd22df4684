"""A diagram script, executed as the main program up to its first run."""

from __future__ import annotations

import ast
import contextlib
import functools
import inspect
import itertools
import logging
import math
import os
import random
import sys
import traceback
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any, NoReturn, TypeGuard
from unittest.mock import patch

import numpy as np
from pathsim import Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from .._core.running import fly
from .._core.wiring import warn_of_wiring
from .._seeding import draws_from_shared
from ..errors import DiagramError
from ..scripts.names import assignments, bound, own
from ..scripts.runs import RunStart, intercepted_runs
from ..scripts.script import Script, is_beside, main_program
from .generators import SharedGenerators

_RUNS = ("run", "run_streaming", "run_realtime")
_STEPS = ("timestep", "step")
_GENERATORS = (np.random.default_rng, np.random.RandomState, random.Random)
_STATES = ("steadystate", "pss", "linearize", "load_checkpoint")


@dataclass
class Construction:
    """The call that made an object."""

    node: ast.Call
    value: Any
    # parameters in the call; None if a function of the script builds the object
    arguments: frozenset[str] | None
    values: dict[str, tuple[Any, Any]]  # of all parameters, each with the object's attribute then


class FirstRun(Script):
    """A script at the beginning of its first run, or at its end if it has no run.

    ``capture`` is called with this object at that point, before any cleanup such as ``finally``;
    ``result`` is its return value. A `DiagramError` has the line that fails.
    """

    simulation: Simulation
    run_call: ast.Call | None  # that runs the simulation, if it is in the script itself
    statements: list[ast.stmt]  # before the run, those of the main guard included

    def __init__(self, path: str | Path, capture: Callable[[FirstRun], Any] | None = None):
        path = self.path = Path(path)
        self._built: dict[int, Construction] = {}
        try:
            super().__init__(path, followed=True)
        except OSError as error:
            self.refuse(f"cannot be read ({error.strerror})")
        except SyntaxError as error:
            raise DiagramError(f"not Python: {error.msg}", path=path, line=error.lineno) from error
        except ValueError as error:  # not in the declared encoding, null bytes
            self.refuse(f"not a Python script ({error})")
        self.namespace: dict[str, Any] = {}
        self.run_start: RunStart | None = None  # the first run
        self.lines: list[int] = []  # of the script in the frames around the run, outermost first
        # method and line of calls before the run that change the simulation's state
        self.states: list[tuple[str, int | None]] = []
        self.result: Any = None
        self.generators: SharedGenerators  # as they are when the run begins
        self._parents = {
            child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)
        }
        self._capture_with = capture
        self._error: Exception | None = None
        self._capturing = False
        self._process = os.getpid()
        self._execute()
        if self._error is not None:
            # of a function of the diagram, in the run that is compared
            if self._own_lines(traceback.walk_tb(self._error.__traceback__)):
                self._refuse_failure(self._error)
            raise self._error

    def _execute(self) -> None:
        """Run the script, as the main program, until its first run."""
        try:
            with (
                main_program(self.path) as module,
                _undone(),
                intercepted_runs(self._begin, *_RUNS[1:], *_STEPS, *_STATES),
            ):
                self.namespace, self.generators = vars(module), SharedGenerators()
                self.run(module)
                if self.run_start is None:  # the script may have caught what ends it
                    self._capture()
        except SystemExit as error:
            if error.code not in (None, 0):
                hint = "; PathView passes no arguments to a script" if error.code == 2 else ""
                self._refuse_failure(error, hint)
            if self.run_start is None:
                self._capture()
        except Exception as error:
            self._refuse_failure(error)

    def _call(self, index: bytes, make: Any, /, *args: Any, **kwargs: Any) -> Any:
        builds = isinstance(make, type) and issubclass(make, Block)
        if builds and not self._capturing:
            self.generators.look()
        if make in _GENERATORS and all(x is None for x in (*args, *kwargs.values())):
            self.generators.drawn = True
        part = super()._call(index, make, *args, **kwargs)
        if isinstance(part, (Block, Event, Simulation)):
            self._record(self._calls[int(index)], part, make, args, kwargs)
        if builds and draws_from_shared(part):  # the model's own block draws these numbers again
            self.generators.look(own=False)
        return part

    def _record(self, node: ast.Call, part: Any, make: Any, args: Any, kwargs: Any) -> None:
        """Keep the call that made a part of the diagram, with its values as they are then."""
        arguments, values = None, {}
        if make is type(part):
            call = inspect.signature(make).bind(*args, **kwargs)
            arguments = frozenset(call.arguments)
            call.apply_defaults()
            values = {
                n: (_copied(v), _copied(getattr(part, n, v))) for n, v in call.arguments.items()
            }
        self._built.setdefault(id(part), Construction(node, part, arguments, values))

    def construction(self, value: Any) -> Construction | None:
        """The call that built an object; None if no call of the script did."""
        return self._built.get(id(value))

    def _begin(self, run: RunStart) -> None:
        if self._capturing:  # `capture` makes the first run itself
            return
        if os.getpid() != self._process:
            self.refuse("the script runs its simulation in a separate process")
        lines = self._own_lines(traceback.walk_stack(None))[::-1]
        if run.method in _STATES:
            self.states.append((run.method, lines[-1] if lines else None))
            return
        if self.run_start is None:  # a script may catch SystemExit, and run again
            self.run_start, self.lines = run, lines
            if run.arguments.get("reset"):
                run.simulation.reset()
            self._capture()
        raise SystemExit  # ends a thread without a traceback

    def _capture(self) -> None:
        """Read the finished diagram; errors are stored, because the script could catch them."""
        self._capturing = True
        try:
            self.generators.look()
            self.simulation = self._the_simulation()
            self.run_call = self._find_run()
            self.statements = self._before_run()
            if self._capture_with is not None:
                self.result = self._capture_with(self)
            warn_of_wiring(self.simulation)
        except Exception as error:
            self._error = error
        finally:
            self._capturing = False

    def _the_simulation(self) -> Simulation:
        if self.run_start is not None:
            return self.run_start.simulation
        simulations = {id(v): v for v in self.namespace.values() if isinstance(v, Simulation)}
        if not simulations:
            why = "the script neither runs a Simulation nor has one at its top level"
            self.refuse(f"{why}; run it, or build it outside functions")
        if len(simulations) == 1:
            return next(iter(simulations.values()))
        if isinstance(self.namespace.get("sim"), Simulation):
            return self.namespace["sim"]
        self.refuse(f"the script builds {len(simulations)} simulations; name the one to show 'sim'")

    def _find_run(self) -> ast.Call | None:
        if self.run_start is None or not self.lines:
            return None
        calls = (n for n in ast.walk(self.tree) if isinstance(n, ast.Call))
        line, method = self.lines[-1], self.run_start.method
        return next((n for n in calls if line in _lines(n) and _name(n) == method), None)

    def run_arguments(self) -> dict[str, ast.expr]:
        """The expressions given to the call that runs the simulation for a duration."""
        if self.run_start is None or self.run_call is None or self.run_start.method in _STEPS:
            return {}
        method = self.run_start.method
        run = fly if method == "fly" else getattr(self.simulation, method)
        return named_arguments(self.run_call, list(inspect.signature(run).parameters))

    def _before_run(self) -> list[ast.stmt]:
        """The statements of the top level, and of the main guard, that end before the run."""
        line = self.lines[0] if self.lines else math.inf
        of_top = [s.body if _is_main_guard(s) else [s] for s in self.tree.body]
        return [s for body in of_top for s in body if (s.end_lineno or 0) < line]

    # what is read from it -------------------------------------------------------------------------

    def refuse(self, reason: str, node: ast.AST | None = None) -> NoReturn:
        """Raise the error that names the script and the line."""
        raise DiagramError(reason, path=self.path, line=getattr(node, "lineno", None))

    def _refuse_failure(self, error: BaseException, hint: str = "") -> NoReturn:
        lines = self._own_lines(traceback.walk_tb(error.__traceback__))
        raise DiagramError(
            f"the script fails: {type(error).__name__}: {error}{hint}",
            path=self.path,
            line=lines[-1] if lines else None,
        ) from error

    def _own_lines(self, frames: Iterator[tuple[FrameType, int]]) -> list[int]:
        return [line for frame, line in frames if frame.f_code.co_filename == str(self.path)]

    def names_of(self, value: Any) -> list[str]:
        """The script's variables for an object, without those of loops."""
        return [n for n, v in self.namespace.items() if v is value and n not in self._of_loops]

    @functools.cached_property
    def _of_loops(self) -> frozenset[str]:
        loops = [n for n in own(self.tree.body) if isinstance(n, ast.For)]
        names = {target.id for n in own(self.tree.body) for target, _ in assignments(n)}
        return bound(n.target for n in loops) - names

    def called(self, part: Any) -> str:
        """The name of a part of the diagram in error messages."""
        names = self.names_of(part)
        return repr(names[0]) if names else f"this {type(part).__name__}"

    def built_at(self, part: Any) -> ast.AST | None:
        """The expression that builds a part."""
        construction = self.construction(part)
        return construction.node if construction else None

    def last_mention(self, *names: str) -> Any:
        """The last statement before the run that mentions a name and builds nothing."""
        last = self.lines[-1] if self.lines else math.inf
        building = {c.node for c in self._built.values()}
        mentions = [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, (ast.Expr, ast.Assign, ast.AugAssign, ast.Delete, ast.AnnAssign))
            and node.lineno < last
            and not building.intersection(ast.walk(node))
            and {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} & {*names}
        ]
        return max(mentions, key=lambda n: n.lineno, default=None)

    def is_beside(self, module: str) -> bool:
        """Whether a module is the script or in its folder, which a model cannot import."""
        return module == "__main__" or is_beside(self.path.resolve().parent, module)

    def file_of(self, module: str) -> tuple[str, dict[str, Any]]:
        """The file of a module, and its names."""
        if module == "__main__":
            return str(self.path), self.namespace
        file = sys.modules[module]
        return str(file.__file__), vars(file)

    def attributes_of(self, name: str) -> list[str]:
        """The attributes of a module that the script uses."""
        nodes = (n for n in ast.walk(self.tree) if isinstance(n, ast.Attribute))
        return sorted({n.attr for n in nodes if getattr(n.value, "id", "") == name})

    def target(self, value: Any) -> str:
        """The variable, attribute or key to which the call that built an object is assigned."""
        node: Any = self.built_at(value)
        parent: Any = self._parents.get(node)
        for statement in filter(None, (parent, self._parents.get(parent))):  # ``a, b = f(), g()``
            for name, value_node in assignments(statement):
                if value_node is node:
                    return name.id
        target = getattr(parent, "targets", [None])[0]
        if isinstance(parent, ast.Dict) and node in parent.values:
            target = parent.keys[parent.values.index(node)]
        key = getattr(getattr(target, "slice", target), "value", "")
        return getattr(target, "attr", key if isinstance(key, str) else "")

    def left_out(self) -> list[tuple[int, str]]:
        """The runs of the script after its first one, by line."""
        if self.run_start is None or not self.lines:
            return []
        first, last, runs = self.lines[0], self.lines[-1], dict[int, str]()
        steps = self.run_start.method in _STEPS
        if steps:
            runs[last] = f"the number of calls of {self.run_start.method}()"
        for node in ast.walk(self.tree):
            if isinstance(node, (ast.For, ast.While)) and last in _lines(node):
                if not steps:
                    runs[node.lineno] = "the loop runs the simulation again"
            elif (
                isinstance(node, ast.Call)
                and _name(node) in (*_RUNS, *_STATES, "fly")
                and node.lineno > first
                and node is not self.run_call
            ):
                runs[node.lineno] = f"{ast.unparse(node.func)}()"
        return sorted(runs.items())


def _copied(value: Any) -> Any:
    """A copy of an array or a collection; other values as they are."""
    if isinstance(value, np.ndarray):
        return value.copy()
    if type(value) in (list, tuple, set):
        return type(value)(map(_copied, value))
    return {k: _copied(v) for k, v in value.items()} if type(value) is dict else value


def named_arguments(call: ast.Call, names: Sequence[str]) -> dict[str, ast.expr]:
    """Arguments of a call by parameter name, up to the first *args, without **kwargs."""
    positional = itertools.takewhile(lambda a: not isinstance(a, ast.Starred), call.args)
    return {
        **dict(zip(names, positional, strict=False)),
        **{k.arg: k.value for k in call.keywords if k.arg},
    }


def _name(call: ast.Call) -> str:
    """Name of the function or method that is called."""
    return getattr(call.func, "attr", getattr(call.func, "id", ""))


def _lines(node: Any) -> range:
    return range(node.lineno, node.end_lineno + 1)


def _is_main_guard(statement: ast.stmt) -> TypeGuard[ast.If]:
    return isinstance(statement, ast.If) and any(
        isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(statement.test)
    )


@contextmanager
def _undone() -> Iterator[None]:
    """Restore the process state that a script changes, and suppress PathSim's log."""
    level = logging.root.manager.disable
    with ExitStack() as stack:
        stack.callback(os.chdir, os.getcwd())
        stack.enter_context(patch.dict(os.environ))
        stack.enter_context(contextlib.redirect_stdout(sys.stdout))
        stack.enter_context(warnings.catch_warnings())
        stack.enter_context(np.printoptions())
        stack.enter_context(np.errstate())
        stack.callback(np.random.set_state, np.random.get_state())  # noqa: NPY002
        stack.callback(random.setstate, random.getstate())
        stack.callback(logging.disable, level)
        logging.disable(max(level, logging.INFO))
        yield
