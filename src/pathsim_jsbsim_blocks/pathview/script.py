"""Run a diagram script up to its ``run``, and remember which line built what."""

from __future__ import annotations

import ast
import itertools
import logging
import sys
import types
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, TypeGuard
from unittest.mock import patch

from pathsim import Simulation
from pathsim.blocks import Block
from pathsim.events._event import Event

from ..errors import DiagramError
from .names import bound, changes, root

_RECORD = "__built__"
_SCOPE_READERS = {"globals", "locals", "vars", "dir", "eval", "exec", "super"}
_RUNS = ("run", "run_streaming", "run_realtime")


@dataclass
class Construction:
    """The expression that made an object.

    Attributes
    ----------
    node : ast.Call or ast.FunctionDef
        a call, or the function that a block class decorates
    value : object
        what it made
    around : str
        "a loop", "a comprehension", "a condition", or empty
    direct : bool
        the call is one of the object's class, not of a function that builds it
    """

    node: ast.Call | ast.FunctionDef
    value: Any
    around: str
    direct: bool


class Script:
    """A diagram script, run with ``Simulation.run`` held back.

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
    run_call : ast.Call or None
        the call that runs the simulation
    statements : list of ast.stmt
        the statements that come before the run, those of the main guard included
    """

    def __init__(self, path: str | Path):
        self.path = Path(path)
        try:
            self.source = self.path.read_text(encoding="utf-8")
            self.tree = ast.parse(self.source, str(self.path))
        except OSError as error:
            self.refuse(f"cannot be read ({error.strerror})")
        except SyntaxError as error:
            raise DiagramError(f"not Python: {error.msg}", path=path, line=error.lineno) from error
        except ValueError as error:  # not UTF-8, null bytes
            self.refuse(f"not a Python script ({error})")
        self.namespace: dict[str, Any] = {}
        self._built: dict[int, Construction] = {}
        self._running: Simulation | None = None
        lines = self._execute()
        self.simulation = self._the_simulation()
        self.run_call = self._find_run(lines[-1] if lines else None)
        self.statements = self._before_run(lines[0] if lines else None)

    def refuse(self, reason: str, node: ast.AST | None = None) -> NoReturn:
        """Raise the error that names the script and the line."""
        raise DiagramError(reason, path=self.path, line=getattr(node, "lineno", None))

    def construction(self, value: Any) -> Construction | None:
        """Where an object was built; None if no expression of the module's own level did."""
        return self._built.get(id(value))

    def changes(self, statement: ast.stmt) -> Iterator[tuple[str, ast.AST]]:
        """What a statement changes in place, itself or by a call of one of the script's functions.

        Yields names of the module and the place, as ``names.changes`` does.
        """
        yield from changes(statement)
        call = statement.value if isinstance(statement, ast.Expr) else None
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)):
            return
        for function in ast.walk(self.tree):
            if isinstance(function, ast.FunctionDef) and function.name == call.func.id:
                local = bound(function.body) | {a.arg for a in ast.walk(function.args)
                                                if isinstance(a, ast.arg)}
                for inner in function.body:
                    yield from ((n, place) for n, place in changes(inner) if n not in local)
                for node in ast.walk(function):
                    if isinstance(node, ast.Global):
                        yield from ((name, node) for name in node.names)

    def _execute(self) -> list[int]:
        """Run the script; the lines of its frames at the held-back run, outermost first."""
        recorder = _Recorder(self.tree)
        tree = ast.parse(self.source)
        recorder.visit(tree)
        code = compile(tree, str(self.path), "exec", dont_inherit=True)
        module = types.ModuleType(f"_diagram_{self.path.stem}")
        module.__file__ = str(self.path)
        setattr(module, _RECORD, lambda i, value: self._record(*recorder.calls[i], value))
        self.namespace = vars(module)
        try:
            with _as_main_program(module, self.path), _runs_held_back(self._reached):
                exec(code, self.namespace)
        except _RunReached as reached:
            return self._lines(reached)
        except (Exception, SystemExit) as error:
            lines = self._lines(error)
            raise DiagramError(f"the script fails: {type(error).__name__}: {error}", path=self.path,
                               line=lines[-1] if lines else None) from error
        finally:
            del self.namespace[_RECORD]
            self._record_decorated()
        return []

    def _reached(self, simulation: Simulation) -> None:
        self._running = simulation
        raise _RunReached

    def _record(self, node: ast.Call, around: str, value: Any) -> Any:
        if isinstance(value, (Block, Event, Simulation)) and id(value) not in self._built:
            direct = self._evaluated(node.func) is type(value)
            self._built[id(value)] = Construction(node, value, around, direct)
        return value

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
                    self._built[id(value)] = Construction(node, value, "", by == [type(value)])

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
            self.refuse("importing the script builds no Simulation; build it at the top level, "
                        "outside functions and the main guard")
        if len(found) == 1:
            return next(iter(found.values()))
        if isinstance(self.namespace.get("sim"), Simulation):
            return self.namespace["sim"]
        self.refuse(f"the script builds {len(found)} simulations; name the one to show 'sim'")

    def _find_run(self, line: int | None) -> ast.Call | None:
        def is_it(node: ast.AST) -> TypeGuard[ast.Call]:
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)
                    and node.func.attr in _RUNS):
                return False
            if line is not None:
                return node.lineno <= line <= (node.end_lineno or 0)
            owner = node.func.value
            return (isinstance(owner, ast.Name)
                    and self.namespace.get(owner.id) is self.simulation)

        calls = [n for n in ast.walk(self.tree) if is_it(n)]
        if line is not None and not calls:
            raise DiagramError("the simulation is run by another module; call its run() here",
                               path=self.path, line=line)
        return min(calls, key=lambda n: n.lineno, default=None)

    def _before_run(self, line: int | None) -> list[ast.stmt]:
        def runs(statement: ast.stmt) -> bool:
            return any(n is self.run_call for n in ast.walk(statement))

        statements: list[ast.stmt] = []
        for statement in self.tree.body:
            if line is not None and line <= (statement.end_lineno or 0):
                break
            if not _is_main_guard(statement):
                statements.append(statement)
            elif runs(statement):
                statements += itertools.takewhile(lambda s: not runs(s), statement.body)
        return statements


def named_arguments(call: ast.Call, names: Sequence[str]) -> dict[str, ast.expr]:
    """Arguments of a call by parameter name, up to the first *args, without **kwargs."""
    positional = itertools.takewhile(lambda a: not isinstance(a, ast.Starred), call.args)
    return {**dict(zip(names, positional, strict=False)),
            **{k.arg: k.value for k in call.keywords if k.arg}}


def _is_main_guard(statement: ast.stmt) -> TypeGuard[ast.If]:
    return isinstance(statement, ast.If) and any(
        isinstance(n, ast.Name) and n.id == "__name__" for n in ast.walk(statement.test))


class _RunReached(BaseException):
    """The script runs its simulation: all is built."""


_AROUND = {
    "a loop": (ast.For, ast.AsyncFor, ast.While),
    "a comprehension": (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp),
    "a condition": (ast.If, ast.IfExp, ast.BoolOp, ast.Try, ast.Match),
}


class _Recorder(ast.NodeTransformer):
    """Wraps every call outside functions: ``f(x)`` becomes ``__built__(i, f(x))``."""

    def __init__(self, original: ast.Module):
        self.calls: list[tuple[ast.Call, str]] = []
        self._originals = {_span(n): n for n in ast.walk(original) if isinstance(n, ast.Call)}
        self._around = [""]

    def visit_Call(self, node: ast.Call) -> ast.AST:
        if isinstance(node.func, ast.Name) and node.func.id in _SCOPE_READERS:
            return node
        self.calls.append((self._originals[_span(node)], self._around[-1]))
        index = len(self.calls) - 1
        self.generic_visit(node)
        wrapped = ast.Call(ast.Name(_RECORD, ast.Load()), [ast.Constant(index), node], [])
        return ast.fix_missing_locations(ast.copy_location(wrapped, node))

    def visit(self, node: ast.AST) -> ast.AST:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda, ast.ClassDef)):
            return node
        around = next((text for text, types in _AROUND.items() if isinstance(node, types)), None)
        if around is None:
            return super().visit(node)
        self._around.append(around)
        try:
            return super().visit(node)
        finally:
            self._around.pop()


def _span(node: ast.Call) -> tuple[int, int, int | None, int | None]:
    return node.lineno, node.col_offset, node.end_lineno, node.end_col_offset


@contextmanager
def _as_main_program(module: types.ModuleType, path: Path) -> Iterator[None]:
    """Python's surroundings of a script: its folder first in ``sys.path``, no arguments."""
    with ExitStack() as stack:
        stack.enter_context(patch.object(sys, "path", [str(path.resolve().parent), *sys.path]))
        stack.enter_context(patch.object(sys, "argv", [str(path)]))
        # classes that the script defines look their module up
        sys.modules[module.__name__] = module
        stack.callback(sys.modules.pop, module.__name__, None)
        stack.enter_context(quiet())
        yield


@contextmanager
def quiet() -> Iterator[None]:
    """Without the announcement that PathSim logs for every simulation it builds."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        yield
    finally:
        logging.disable(before)


@contextmanager
def _runs_held_back(reached: Callable[[Simulation], None]) -> Iterator[None]:
    def run(self: Simulation, *args: Any, **kwargs: Any) -> None:
        reached(self)

    with ExitStack() as stack:
        for name in _RUNS:
            stack.enter_context(patch.object(Simulation, name, run))
        yield
