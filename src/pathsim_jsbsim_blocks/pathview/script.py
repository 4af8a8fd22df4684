"""Run a diagram script up to its first ``run``, and record which line built each object."""

from __future__ import annotations

import ast
import functools
import importlib.util
import inspect
import itertools
import logging
import math
import os
import sys
import types
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn, TypeGuard
from unittest.mock import patch

from pathsim import Simulation
from pathsim.blocks import Block
from pathsim.events._event import Event

from ..errors import DiagramError
from .libraries import Libraries
from .names import bound, root

# scripts import `fly` from here; an import would tie the bridge to all blocks
_PACKAGE = sys.modules[__name__.partition(".")[0]]
_CALL = "__call__"
_SCOPE_READERS = {"globals", "locals", "vars", "dir", "eval", "exec", "super"}
_RUNS = ("run", "run_streaming", "run_realtime")
_FLY = "fly"
_STEPS = ("timestep", "step")
_STATES = ("steadystate", "pss", "linearize", "load_checkpoint")


@dataclass
class Construction:
    """The expression that made an object.

    Attributes
    ----------
    node : ast.Call or ast.FunctionDef
        a call, or the function that a block class decorates
    value : object
        the resulting object
    direct : bool
        the call is one of the object's class, not of a function that builds it
    local : set of str
        names that belong to the functions around the expression
    target : str
        the variable, attribute or key to which it is assigned, or empty
    given : dict
        the arguments of a direct call by parameter
    """

    node: ast.Call | ast.FunctionDef
    value: Any
    direct: bool
    local: set[str] = field(default_factory=set)
    target: str = ""
    given: dict[str, Any] = field(default_factory=dict)


@dataclass
class Run:
    """The first run of a script: how it is called, and where.

    Attributes
    ----------
    method : str
        "run", "timestep" and the like
    arguments : dict
        the values of its arguments, defaults included
    lines : list of int
        lines of the script in the frames around it, outermost first
    """

    method: str
    arguments: dict[str, Any]
    lines: list[int]


class Script:
    """A diagram script, executed as the main program up to its first run.

    ``at_run`` is called with the script at that point, before any cleanup such as ``finally``.
    Without a run it is called at the end. ``result`` is what it returns.

    Attributes
    ----------
    path : Path
        the file
    source : str
        its text
    tree : ast.Module
        its syntax tree
    namespace : dict
        the names that it has bound
    simulation : Simulation
        the diagram
    run : Run or None
        the first run; None if the script runs nothing
    run_call : ast.Call or None
        the call that runs the simulation, if it is in the script itself
    states : list of tuple
        method and line of calls before the run that change the simulation's state
    statements : list of ast.stmt
        the statements that come before the run, those of the main guard included
    """

    def __init__(self, path: str | Path, at_run: Callable[[Script], Any] | None = None):
        self.path = Path(path)
        try:
            self.source = importlib.util.decode_source(self.path.read_bytes())
            self.tree = ast.parse(self.source, str(self.path))
        except OSError as error:
            self.refuse(f"cannot be read ({error.strerror})")
        except SyntaxError as error:
            raise DiagramError(f"not Python: {error.msg}", path=path, line=error.lineno) from error
        except ValueError as error:  # not in the declared encoding, null bytes
            self.refuse(f"not a Python script ({error})")
        self.namespace: dict[str, Any] = {}
        self.states: list[tuple[str, int | None]] = []
        self.run: Run | None = None
        self._built: dict[int, Construction] = {}
        self._running: Simulation | None = None
        self._parents = {
            child: node for node in ast.walk(self.tree) for child in ast.iter_child_nodes(node)
        }
        self._at_run = at_run or (lambda script: None)
        self._error: Exception | None = None
        self._standing = False
        self.result: Any = None
        self._execute()
        if self._error is not None:
            raise self._error

    def _stand(self) -> None:
        """Read the finished diagram; errors are stored, because the script could catch them."""
        self._standing = True
        try:
            self.simulation = self._the_simulation()
            self.run_call = self._find_run()
            self.statements = self._before_run(self.run.lines[0] if self.run else None)
            self._record_decorated()
            self.result = self._at_run(self)
        except Exception as error:
            self._error = error
        finally:
            self._standing = False

    def refuse(self, reason: str, node: ast.AST | None = None) -> NoReturn:
        """Raise the error that names the script and the line."""
        raise DiagramError(reason, path=self.path, line=getattr(node, "lineno", None))

    def changed_libraries(self) -> list[str]:
        """What the script has changed in PathSim, its toolboxes and numpy so far."""
        return self._libraries.changed()

    def mention(self, *names: str) -> ast.AST | None:
        """The last statement before the run that mentions a name and builds nothing."""
        last = self.run.lines[-1] if self.run else math.inf
        building = {id(made.node) for made in self._built.values()}
        found = [
            node
            for node in ast.walk(self.tree)
            if isinstance(node, (ast.Expr, ast.Assign, ast.AugAssign, ast.Delete, ast.AnnAssign))
            and node.lineno < last
            and not any(id(inner) in building for inner in ast.walk(node))
            and {n.id for n in ast.walk(node) if isinstance(n, ast.Name)} & {*names}
        ]
        return max(found, key=lambda n: n.lineno, default=None)

    def storing(self, attribute: str) -> ast.AST | None:
        """Where an attribute of this name is assigned, or named in a text."""
        for node in ast.walk(self.tree):
            if getattr(node, "value", None) == attribute or (
                isinstance(node, ast.Attribute)
                and node.attr == attribute
                and isinstance(node.ctx, ast.Store)
            ):
                return node
        return None

    def construction(self, value: Any) -> Construction | None:
        """Where an object was built; None if no expression of the script did."""
        return self._built.get(id(value))

    def _execute(self) -> None:
        """Run the script, as the main program, until its first run."""
        recorder = _Recorder(self.tree)
        tree = ast.parse(self.source)
        recorder.visit(tree)
        code = compile(tree, str(self.path), "exec", dont_inherit=True)
        module = types.ModuleType("__main__")
        module.__file__ = str(self.path)
        # stays in the namespace: functions of the script also call it later
        setattr(module, _CALL, lambda i, *a, **k: self._call(recorder.calls[i], *a, **k))
        self.namespace = vars(module)
        try:
            with (
                _as_main_program(module, self.path),
                self._runs_held_back(),
                ExitStack() as stack,
            ):
                self._libraries = Libraries(self.tree)
                stack.callback(self._libraries.restore)
                exec(code, self.namespace)
                self._stand()
        except _RunReached:
            pass
        except SystemExit as error:
            if error.code not in (None, 0):
                lines = self._lines(error)
                hint = "; PathView passes no arguments to a script" if error.code == 2 else ""
                raise DiagramError(
                    f"the script fails: SystemExit: {error}{hint}",
                    path=self.path,
                    line=lines[-1] if lines else None,
                ) from error
            if self.run is None:
                self._stand()
        except Exception as error:
            lines = self._lines(error)
            raise DiagramError(
                f"the script fails: {type(error).__name__}: {error}",
                path=self.path,
                line=lines[-1] if lines else None,
            ) from error

    @contextmanager
    def _runs_held_back(self) -> Iterator[None]:
        def held_back(run: Callable[..., Any]) -> Callable[..., Any]:
            signature = inspect.signature(run)

            @functools.wraps(run)
            def method(*args: Any, **kwargs: Any) -> Any:
                if self._standing:  # the first run itself, by `at_run`
                    return run(*args, **kwargs)
                call = signature.bind(*args, **kwargs)
                call.apply_defaults()
                simulation = call.args[0]
                if self.run is None:  # a script may catch what ends it, and run again
                    lines = [line for _, line in self._frames()][::-1]
                    self._running, self.run = simulation, Run(run.__name__, call.arguments, lines)
                    if call.arguments.get("reset"):
                        simulation.reset()
                    self._stand()
                raise _RunReached

            return method

        def noted(name: str) -> Callable[..., Any]:
            original = getattr(Simulation, name)

            def method(simulation: Simulation, *args: Any, **kwargs: Any) -> Any:
                # these methods advance the simulation by steps of their own
                with patch.multiple(Simulation, **steps):
                    result = original(simulation, *args, **kwargs)
                self.states.append((name, self._caller()))
                return result

            return method

        steps = {name: getattr(Simulation, name) for name in _STEPS}
        with ExitStack() as stack:
            for owner, name in [(Simulation, n) for n in (*_RUNS, *_STEPS)] + [(_PACKAGE, _FLY)]:
                run = held_back(getattr(owner, name))
                stack.enter_context(patch.object(owner, name, run))
            for name in _STATES:
                stack.enter_context(patch.object(Simulation, name, noted(name)))
            yield

    def _caller(self) -> int | None:
        """The line of the script that is being executed."""
        return next((line for _, line in self._frames()), None)

    def _frames(self) -> Iterator[tuple[types.FrameType, int]]:
        """Frames of the script and their lines, the innermost first."""
        frame = inspect.currentframe()
        while frame is not None:
            if frame.f_code.co_filename == str(self.path):
                yield frame, frame.f_lineno
            frame = frame.f_back

    def _call(self, node: ast.Call, make: Any, *args: Any, **kwargs: Any) -> Any:
        value = make(*args, **kwargs)
        if isinstance(value, (Block, Event, Simulation)) and id(value) not in self._built:
            made = Construction(
                node, value, make is type(value), self.local_names(node), self._target(node)
            )
            if made.direct:
                made.given = inspect.signature(make).bind(*args, **kwargs).arguments
            self._built[id(value)] = made
        return value

    def local_names(self, node: ast.AST) -> set[str]:
        """Names that belong to the functions around a node."""
        names: set[str] = set()
        for around in self.around(node):
            if isinstance(around, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)):
                body = around.body if isinstance(around.body, list) else [around.body]
                names |= bound(body) | {
                    a.arg for a in ast.walk(around.args) if isinstance(a, ast.arg)
                }
        return names

    def around(self, node: ast.AST) -> Iterator[ast.AST]:
        """The nodes around one, the innermost first."""
        while node in self._parents:
            node = self._parents[node]
            yield node

    def _target(self, node: ast.Call) -> str:
        parent = self._parents.get(node)
        target: ast.AST | None = None
        if isinstance(parent, ast.Assign):
            target = parent.targets[0]
        elif isinstance(parent, (ast.AnnAssign, ast.NamedExpr)):
            target = parent.target
        elif isinstance(parent, ast.Dict):
            target = parent.keys[parent.values.index(node)] if node in parent.values else None
        elif isinstance(parent, ast.Tuple) and isinstance(self._parents.get(parent), ast.Assign):
            targets = self._parents[parent].targets[0]  # type: ignore[attr-defined]
            if isinstance(targets, ast.Tuple) and len(targets.elts) == len(parent.elts):
                target = targets.elts[parent.elts.index(node)]
        if isinstance(target, ast.Subscript):
            target = target.slice
        if isinstance(target, ast.Constant) and isinstance(target.value, str):
            return target.value
        return getattr(target, "attr", getattr(target, "id", ""))

    def _evaluated(self, node: ast.expr) -> Any:
        """What a dotted name means; None for any other expression."""
        try:
            return None if root(node) is None else eval(ast.unparse(node), self.namespace)
        except Exception:
            return None

    def _record_decorated(self) -> None:
        for node in self.tree.body:
            if isinstance(node, ast.FunctionDef):
                value = self.namespace.get(node.name)
                if isinstance(value, (Block, Event)) and id(value) not in self._built:
                    by = [self._evaluated(d) for d in node.decorator_list]
                    self._built[id(value)] = Construction(node, value, by == [type(value)])

    def _lines(self, error: BaseException) -> list[int]:
        lines = []
        trace = error.__traceback__
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == str(self.path):
                lines.append(trace.tb_lineno)
            trace = trace.tb_next
        return lines

    def _the_simulation(self) -> Simulation:
        if self._running is not None:
            return self._running
        found = {id(v): v for v in self.namespace.values() if isinstance(v, Simulation)}
        if not found:
            self.refuse(
                "the script runs no Simulation, and has none at its top level; run it, or "
                "build it outside functions"
            )
        if len(found) == 1:
            return next(iter(found.values()))
        if isinstance(self.namespace.get("sim"), Simulation):
            return self.namespace["sim"]
        self.refuse(f"the script builds {len(found)} simulations; name the one to show 'sim'")

    def _find_run(self) -> ast.Call | None:
        """The call of the first run; without one, the first that is written."""
        calls = sorted(
            (
                n
                for n in ast.walk(self.tree)
                if isinstance(n, ast.Call) and _called(n) in (*_RUNS, *_STEPS, _FLY)
            ),
            key=lambda c: c.lineno,
        )
        if self.run is None:
            return next(
                (
                    n
                    for n in calls
                    if self._evaluated(
                        n.args[0]
                        if _called(n) == _FLY and n.args
                        else getattr(n.func, "value", n.func)
                    )
                    is self.simulation
                ),
                None,
            )
        line, method = self.run.lines[-1], self.run.method
        return next(
            (n for n in calls if n.lineno <= line <= (n.end_lineno or 0) and _called(n) == method),
            None,
        )

    def run_arguments(self) -> dict[str, ast.expr]:
        """The expressions given to the call that runs the simulation for a duration."""
        call = self.run_call
        if call is None or _called(call) not in (*_RUNS, _FLY):
            return {}
        run = getattr(_PACKAGE if _called(call) == _FLY else self.simulation, _called(call))
        return named_arguments(call, list(inspect.signature(run).parameters))

    def _before_run(self, line: int | None) -> list[ast.stmt]:
        """The statements of the top level, and of the main guard, that end before the run."""
        statements: list[ast.stmt] = []
        for statement in self.tree.body:
            inner = statement.body if _is_main_guard(statement) else [statement]
            for one in inner:
                if line is not None and line <= (one.end_lineno or 0):
                    return statements
                statements.append(one)
        return statements

    def left_out(self) -> list[tuple[int, str]]:
        """What the script does after its first run, by line; none of it is in the model."""
        if self.run is None:
            return []
        first, last, found = self.run.lines[0], self.run.lines[-1], dict[int, str]()
        if self.run.method in _STEPS:
            found[last] = f"how long {self.run.method}() goes on"
        parts = {n for n, v in self.namespace.items() if isinstance(v, (Block, Event, Simulation))}
        for node in ast.walk(self.tree):
            lines = range(getattr(node, "lineno", 0), (getattr(node, "end_lineno", 0) or 0) + 1)
            if isinstance(node, (ast.For, ast.While)) and last in lines:
                if self.run.method not in _STEPS:
                    found[node.lineno] = "the loop runs the simulation again"
            elif isinstance(node, ast.Call) and node.lineno > first and node is not self.run_call:
                name = _called(node)
                if name in (*_RUNS, *_STATES, _FLY):
                    found[node.lineno] = f"{ast.unparse(node.func)}()"
                elif name == "Simulation":
                    found[node.lineno] = "another simulation"
            elif (
                isinstance(node, ast.Attribute)
                and isinstance(node.ctx, ast.Store)
                and node.lineno > first
                and root(node) in parts
            ):
                found[node.lineno] = f"{root(node)!r} is changed"
        return sorted(found.items())


def named_arguments(call: ast.Call, names: Sequence[str]) -> dict[str, ast.expr]:
    """Arguments of a call by parameter name, up to the first *args, without **kwargs."""
    positional = itertools.takewhile(lambda a: not isinstance(a, ast.Starred), call.args)
    return {
        **dict(zip(names, positional, strict=False)),
        **{k.arg: k.value for k in call.keywords if k.arg},
    }


def _called(call: ast.Call) -> str:
    """Name of the function or method that a call is written with."""
    return getattr(call.func, "attr", getattr(call.func, "id", ""))


def _is_main_guard(statement: ast.stmt) -> TypeGuard[ast.If]:
    return isinstance(statement, ast.If) and any(
        isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(statement.test)
    )


class _RunReached(BaseException):
    """The script is about to run its simulation; the diagram is complete."""


class _Recorder(ast.NodeTransformer):
    """Passes on every call: ``f(x)`` becomes ``__call__(i, f, x)``."""

    def __init__(self, original: ast.Module):
        self.calls: list[ast.Call] = []
        self._originals = {_span(n): n for n in ast.walk(original) if isinstance(n, ast.Call)}

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id in _SCOPE_READERS:
            return node
        self.calls.append(self._originals[_span(node)])
        index = len(self.calls) - 1
        self.generic_visit(node)
        node.args[:0] = [ast.Constant(index), node.func]
        node.func = ast.Name(_CALL, ast.Load())
        return ast.fix_missing_locations(node)


def _span(node: ast.Call) -> tuple[int, int, int | None, int | None]:
    return node.lineno, node.col_offset, node.end_lineno, node.end_col_offset


@contextmanager
def _as_main_program(module: types.ModuleType, path: Path) -> Iterator[None]:
    """The environment of a main program: its folder first in ``sys.path``, no arguments.

    What the script changes of it, and its current folder, is put back.
    """
    with ExitStack() as stack:
        stack.callback(os.chdir, os.getcwd())
        stack.enter_context(patch.dict(os.environ))
        stack.enter_context(patch.object(sys, "path", [str(path.resolve().parent), *sys.path]))
        stack.enter_context(patch.object(sys, "argv", [str(path)]))
        # classes that the script defines look up their module by name
        stack.callback(sys.modules.__setitem__, "__main__", sys.modules["__main__"])
        sys.modules["__main__"] = module
        stack.enter_context(quiet())
        yield


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress the INFO line that PathSim logs for every simulation it builds."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        yield
    finally:
        logging.disable(before)
