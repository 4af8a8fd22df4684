"""Turn a diagram script into a PathView model."""

from __future__ import annotations

import ast
import io
import math
import random
import sys
import warnings
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn
from unittest.mock import patch

import numpy as np
from pathsim import Simulation

from .._core.checks import as_path
from ..errors import DiagramError
from . import pvm
from .diagram import Diagram, Graph, Node
from .generate import to_python
from .names import bound, changes, passed
from .reader import Choices, read_diagram
from .same import Comparison, Difference, Functions
from .script import HARMLESS, Script, quiet
from .settings import setting_values
from .shape import Json
from .toolboxes import registry_for, required_toolboxes


def export_script(script: str | Path, out: str | Path | None = None) -> Path:
    """Write a PathSim script as a PathView model.

    The script is executed, as the main program and without arguments, until its first run begins;
    the model is the diagram at that point. Blocks, wires, events and solver settings are read
    from the simulation. Parameters are taken from the source as written where that gives the
    diagram's values, and are its values elsewhere. A warning names what comes after the first run.

    Parameters
    ----------
    script : str or Path
        a script that runs a ``Simulation``, or builds one at its top level
    out : str or Path, optional
        the model; default is the script's name with .pvm. If it exists, blocks that it has keep
        their positions

    Returns
    -------
    Path
        the model

    Raises
    ------
    DiagramError
        if the script fails or contains something that PathView cannot represent (file, line and
        reason), or the model cannot be written
    """
    script = as_path("script", script)
    out = script.parent / f"{script.stem}.pvm" if out is None else as_path("out", out)
    pvm.write(out, pvm.text(script_model(script, pvm.read(out) if out.is_file() else None)))
    return out


def script_model(script: str | Path, existing: Json | None = None) -> Json:
    """The content of a script's model, after a rehearsal of what PathView does with it.

    Warns
    -----
    UserWarning
        names what the script does after its first run, which is not in the model
    """
    with _other_numbers():
        live = Script(script, lambda standing: _Export(standing).content(existing))
    if rest := live.left_out():
        assert live.run is not None
        first = live.run.lines[-1]
        # at the script's line: the caller's would be of the command line
        warnings.warn_explicit(
            f"the model is the diagram of the first run (line {first}); not in it: "
            + ", ".join(f"line {line}: {what}" for line, what in rest),
            UserWarning,
            str(live.path),
            first,
        )
    content: Json = live.result
    return content


class _Export:
    """Turns a script into a model that builds the same diagram, or explains why that is impossible.

    The source is tried first. Where the resulting diagram differs from the script's, live values
    replace the source, until nothing differs or nothing is left to replace.
    """

    def __init__(self, script: Script):
        self.script = script
        self.functions = Functions(script.tree, str(script.path))
        self.choices = Choices()
        self.parameters: dict[int, dict[str, bool]] = {}
        self._seeds = [
            n
            for n in ast.walk(script.tree)
            if isinstance(n, ast.Call)
            and getattr(n.func, "attr", getattr(n.func, "id", "")) == "seed"
        ]
        self._numbers = self._numbers_there = _numbers()

    def content(self, existing: Json | None) -> Json:
        while True:
            diagram = read_diagram(self.script, self.functions, self.choices)
            self.parameters = {id(part): given for part, given in diagram.parts.values()}
            content = pvm.model(diagram, existing)
            error = self._evaluate(diagram)
            if error is None:
                differences, opaque = self._differences(content, diagram)
                if not differences:
                    self._check_opaque(opaque)
                    self._check_seed(diagram)
                    return content
                if not self._replace(differences, diagram):
                    self._refuse(differences[0])
            elif not self._avoid(error, diagram):
                raise DiagramError(
                    f"PathView cannot evaluate {error.what} before the blocks exist: "
                    f"{type(error.cause).__name__}: {error.cause}",
                    path=diagram.path,
                    line=error.line,
                ) from error.cause

    # what PathView evaluates --------------------------------------------------------------------

    def _evaluate(self, diagram: Diagram) -> _Failure | None:
        """PathView's own check before a run: every parameter, with the code alone, no blocks."""
        namespace: dict[str, Any] = {"np": np}
        with _as_in_pathview(), _other_numbers():
            error = _executed(diagram.context, namespace, "exec")
            if error is not None:
                return _Failure("the code context", error, None, _code_line(error))
            todo = list(diagram.graph.nodes)
            for node in todo:
                for name, value in node.params.items():
                    error = _executed(value, namespace, "eval")
                    if error is not None:
                        return _Failure(
                            f"parameter {name!r} of {node.name!r}",
                            error,
                            node.line,
                            parameter=(node.part, name),
                        )
                todo += node.graph.nodes if node.graph else []
            for name, value in diagram.settings.items():
                if name == "solver" or not value:
                    continue
                live = setting_values(self.script)[name]
                error = _executed(f"float({value})", namespace, "eval")
                if error is not None:
                    return _Failure(f"setting {name!r}", error, None, parameter=(None, name))
                if repr(namespace[_VALUE]) != live:
                    return _Failure(
                        f"setting {name!r}",
                        ValueError(f"{namespace[_VALUE]!r}, and {live} in the script"),
                        None,
                        parameter=(None, name),
                    )
        return None

    def _avoid(self, error: _Failure, diagram: Diagram) -> bool:
        """Choose live values for what cannot be evaluated; False if there is nothing to choose."""
        if error.parameter is not None:
            return _added(self.choices.live, {error.parameter})
        names: set[str] = set()
        for statement in ast.parse(diagram.context).body:
            if statement.lineno <= (error.code_line or 0) <= (statement.end_lineno or 0):
                names |= bound([statement]) & diagram.code_names
        return _added(self.choices.pinned, names)

    # what PathView builds -----------------------------------------------------------------------

    def _differences(self, content: Json, diagram: Diagram) -> tuple[list[Difference], list[Any]]:
        here = self.script.simulation
        parts = {name: part for name, (part, _) in diagram.parts.items()}
        there, theirs, functions = self._rebuilt(content, parts)
        found = Comparison(here, there, parts, theirs, self.functions, functions)
        if found.differences:
            # what two builds of the model do not share is random in the script, too, unless that
            # seeds a global generator
            another, its, its_functions = self._rebuilt(content, parts)
            again = Comparison(there, another, theirs, its, functions, its_functions)
            by_chance = {(again.name(d.part), d.path) for d in again.differences}
            found.differences = [
                d
                for d in found.differences
                if (found.name(d.part), d.path) not in by_chance
                or (self._seeds and d.attribute in self.parameters.get(id(d.part), {}))
            ]
        return found.differences, found.opaque

    def _replace(self, differences: list[Difference], diagram: Diagram) -> bool:
        """Choose live values for what differs; False if there is nothing left to choose."""
        if _added(self.choices.pinned, {d.name for d in differences} & diagram.code_names):
            return True
        chosen = False
        for part in {id(d.part): d.part for d in differences}.values():
            mine = [d for d in differences if d.part is part]
            parameters = self.parameters.get(id(part), {})
            direct = {(id(part), d.attribute) for d in mine if d.attribute in parameters}
            given = {(id(part), name) for name, source in parameters.items() if source}
            chosen |= _added(self.choices.live, direct) or _added(self.choices.live, given)
        return chosen

    def _rebuilt(
        self, content: Json, parts: Mapping[str, Any]
    ) -> tuple[Simulation, dict[str, Any], Functions]:
        path = self.script.path
        # the script has imported its toolboxes already
        imported = [f"{t.package}:{t.import_path}" for t in required_toolboxes(content, path)]
        code = to_python(content, registry_for(content, path, trust_toolboxes=imported), path)
        namespace: dict[str, Any] = {"__name__": "rebuilt"}
        with _as_in_pathview(), _other_numbers():
            error = _executed(code, namespace, "exec", "model")
            self._numbers_there = _numbers()
        if error is not None:
            raise DiagramError(
                f"PathView cannot build this model: {type(error).__name__}: {error}",
                path=self.script.path,
            ) from error
        simulation = namespace["sim"]
        run = self.script.run
        if run is not None and run.arguments.get("reset"):
            simulation.reset()
        return (
            simulation,
            {name: namespace[name] for name in parts},
            Functions(ast.parse(code), "model"),
        )

    # what cannot be written ---------------------------------------------------------------------

    def _refuse(self, difference: Difference) -> NoReturn:
        part = difference.part
        what = self._called(part)
        states = self.script.states
        if states and part is not self.script.simulation:
            method, line = states[-1]
            raise DiagramError(
                f"{method}() before the run changes {what}: {difference}; PathView "
                "starts from the blocks' own initial values",
                path=self.script.path,
                line=line,
            )
        made = self.script.construction(part)
        place = self._touched(part)
        self.script.refuse(
            f"{what} is changed after it is built: {difference}; PathView cannot represent that",
            place or (made and made.node) or self.script.run_call,
        )

    def _check_opaque(self, parts: list[Any]) -> None:
        """Refuse calls that may change what cannot be compared."""
        for part in parts:
            place = self._touched(part)
            if place is not None:
                self.script.refuse(
                    f"{self._called(part)} may be changed here after it is built; "
                    "PathView cannot represent that",
                    place,
                )

    def _called(self, part: Any) -> str:
        names = [n for n, v in self.script.namespace.items() if v is part]
        made = self.script.construction(part)
        name = names[0] if names else made.target if made else ""
        return repr(name) if name else f"this {type(part).__name__}"

    def _touched(self, part: Any) -> ast.AST | None:
        """Where the script may change a part before the run, judging by its source."""
        made = self.script.construction(part)
        names = {
            n
            for n, v in self.script.namespace.items()
            if v is part
            or (isinstance(v, dict) and any(x is part for x in v.values()))
            or (isinstance(v, (list, tuple)) and any(x is part for x in v))
        }
        if made is not None and made.target:
            names.add(made.target)
        last = self.script.run.lines[-1] if self.script.run else math.inf
        for node in ast.walk(self.script.tree):
            if (
                not isinstance(node, ast.stmt)
                or node.lineno > last
                or (made is not None and node.lineno < made.node.lineno)
            ):
                continue
            for name, place in changes(node):
                if name in names and not (
                    isinstance(place, ast.Attribute)
                    and isinstance(place.ctx, ast.Load)
                    and (place.attr in HARMLESS or place.attr.startswith("run"))
                ):
                    return place
            if not isinstance(node, (ast.FunctionDef, ast.ClassDef)) and passed(node) & names:
                return node
        return None

    def _check_seed(self, diagram: Diagram) -> None:
        """Refuse functions that draw from a seeded global generator, whose state would differ."""
        code = [diagram.context, *(v for n in _nodes(diagram.graph) for v in n.params.values())]
        if self._seeds and self._numbers != self._numbers_there and any(map(_draws, code)):
            self.script.refuse(
                "functions of the diagram draw from the global random generator, "
                "whose state differs in the model; give them their own generator "
                "(np.random.default_rng)",
                self._seeds[-1],
            )


def _draws(code: str) -> bool:
    """Whether functions in a piece of code draw from a global random generator."""
    return any(
        isinstance(n, ast.Attribute)
        and ast.unparse(n.value) in ("np.random", "random")
        and n.attr not in ("default_rng", "Generator", "RandomState", "Random", "seed")
        for f in ast.walk(ast.parse(code))
        if isinstance(f, (ast.FunctionDef, ast.Lambda))
        for n in ast.walk(f)
    )


def _numbers() -> tuple[str, str]:
    """The state of the global random generators."""
    return str(random.getstate()), str(np.random.get_state())  # noqa: NPY002


@contextmanager
def _other_numbers() -> Iterator[None]:
    """Reseed the global random generators, and restore their state at the end."""
    before = random.getstate(), np.random.get_state()  # noqa: NPY002
    random.seed()
    np.random.seed()  # noqa: NPY002 (scripts draw from the global one)
    try:
        yield
    finally:
        random.setstate(before[0])
        np.random.set_state(before[1])  # noqa: NPY002


_VALUE = "__value__"


@dataclass
class _Failure:
    """What cannot be evaluated, and why; ``parameter`` is a part's ``id`` and a name."""

    what: str
    cause: BaseException
    line: int | None
    code_line: int | None = None
    parameter: tuple[int | None, str] | None = None


def _executed(
    code: str, namespace: dict[str, Any], mode: str, filename: str = "context"
) -> BaseException | None:
    """Run code; returns what it raised. The value of an expression is in the namespace."""
    try:
        if mode == "eval":
            namespace[_VALUE] = eval(compile(code, filename, mode, dont_inherit=True), namespace)
        else:
            exec(compile(code, filename, mode, dont_inherit=True), namespace)
    except (Exception, SystemExit) as error:
        return error
    return None


def _code_line(error: BaseException) -> int | None:
    """The line of the code context at which it failed."""
    trace = error.__traceback__
    while trace is not None:
        if trace.tb_frame.f_code.co_filename == "context" and (
            trace.tb_frame.f_code.co_name == "<module>"
        ):
            return trace.tb_lineno
        trace = trace.tb_next
    return None


@contextmanager
def _as_in_pathview() -> Iterator[None]:
    """Imitate PathView's process: other arguments, no output."""
    with (
        quiet(),
        patch.object(sys, "argv", ["pathview", "serve", "--port", "5000"]),
        redirect_stdout(io.StringIO()),
        redirect_stderr(io.StringIO()),
    ):
        yield


def _added(chosen: set[Any], more: set[Any]) -> bool:
    """Whether ``more`` has anything new for ``chosen``."""
    before = len(chosen)
    chosen |= more
    return len(chosen) > before


def _nodes(graph: Graph) -> Iterator[Node]:
    for node in graph.nodes:
        yield node
        if node.graph is not None:
            yield from _nodes(node.graph)
