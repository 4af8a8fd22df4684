"""Turn a diagram script into a PathView model, and prove it by flight."""

from __future__ import annotations

import ast
import threading
import time
import warnings
from pathlib import Path
from typing import Any, NoReturn

from pathsim import Connection, Simulation

from .._core.checks import as_path, number
from ..errors import DiagramError
from ..scripts.first_run import FirstRun
from . import pvm
from .diagram import Diagram
from .frozen import Frozen
from .plain import attributes
from .proof import Proof, Rehearsal
from .reader import ByValue, read_diagram
from .rehearsal import SETTINGS, Difference, Job, Parting, blocks_of, structure
from .settings import setting_values
from .shape import Json, shortened

_CHECKED = 60.0  # s of processing
_DRAWS = "draws from a global random generator, whose state differs; give it its own"
_ONE_AT_A_TIME = threading.RLock()  # an export replaces functions of the whole process


def export_script(
    script: str | Path, out: str | Path | None = None, check: float = _CHECKED
) -> Path:
    """Write a PathSim script as a PathView model that has flown as the script does.

    The script is executed, as the main program and without arguments, to the end of its first run.
    The model is the diagram at the start of that run. Blocks, wires, events and solver settings are
    read from the simulation. Parameters are taken from the source as written where that gives the
    diagram's values, and are its values elsewhere. The model is then built from its text in a
    process of its own and flown beside the script: every output of every block at every step must
    be the same, bit for bit. Random numbers without a seed, and the time of day, are the same
    on both sides. A warning names what comes after the first run.

    Parameters
    ----------
    script : str or Path
        a script that runs a ``Simulation``, or builds one at its top level
    out : str or Path, optional
        the model; default is the script's name with .pvm. If it exists, blocks that it has keep
        their positions
    check : float
        s of processing after which the comparison ends; ``math.inf`` compares the whole run

    Returns
    -------
    Path
        the model

    Raises
    ------
    DiagramError
        if the script fails or contains something that PathView cannot represent, the model flies
        otherwise (file, line and reason), or the model cannot be written

    Warns
    -----
    UserWarning
        how far the comparison went, where it ended before the run
    """
    out, proof = export_with_proof(script, out, check)
    if not proof.whole:
        warnings.warn(f"{out}: {proof}", UserWarning, stacklevel=2)
    return out


def export_with_proof(
    script: str | Path, out: str | Path | None = None, check: float = _CHECKED
) -> tuple[Path, Proof]:
    """`export_script`, and what was compared."""
    script = as_path("script", script)
    out = script.parent / f"{script.stem}.pvm" if out is None else as_path("out", out)
    existing = pvm.read(out) if out.is_file() else None
    check = number("check", check, above=0.0, infinite=True)
    content, proof = script_model(script, existing, check)
    pvm.write(out, pvm.text(content))
    return out, proof


def script_model(
    script: str | Path, existing: Json | None = None, check: float = _CHECKED
) -> tuple[Json, Proof]:
    """The content of a script's model, and what was compared; parameters as in `export_script`.

    A warning names what the script does after its first run, which is not in the model.
    """
    frozen = Frozen(time.time())
    with _ONE_AT_A_TIME, Rehearsal(script) as rehearsal, frozen.applied():
        first_run = FirstRun(
            script, lambda s: _Export(s, rehearsal, frozen).proven(existing, check)
        )
    if rest := first_run.left_out():
        first = first_run.lines[-1]
        # at the script's line: the caller's would be of the command line
        warnings.warn_explicit(
            f"the model is the diagram of the first run (line {first}); not in it: "
            + ", ".join(f"line {line}: {what}" for line, what in rest),
            UserWarning,
            str(first_run.path),
            first,
        )
    return first_run.result


class _Export:
    """Turns a script, whose first run begins, into a model that flies as it does."""

    def __init__(self, script: FirstRun, rehearsal: Rehearsal, frozen: Frozen):
        self.script, self.rehearsal, self.frozen = script, rehearsal, frozen
        self._failed: dict[int, str] = {}  # statements that PathView cannot execute, by line

    def proven(self, existing: Json | None, check: float) -> tuple[Json, Proof]:
        script = self.script
        self._refuse_own_simulation()
        settings = setting_values(script)
        run = {
            "duration": float(settings["duration"]),
            "reset": bool(script.begun and script.begun.arguments.get("reset")),
            "adaptive": True,
        }
        self.frozen.begin()  # the global generators are compared, too
        content, diagram = self._equal(existing, settings, run)
        blocks = list(blocks_of(diagram.values).values())
        self.frozen.begin()
        outcome = self.rehearsal.fly(script.simulation, run, blocks, check)
        if isinstance(outcome, Parting):
            self._refuse_parting(outcome, diagram)
        return content, outcome

    def _equal(
        self, existing: Json | None, settings: dict[str, str], run: dict[str, Any]
    ) -> tuple[Json, Diagram]:
        """A model that builds the script's diagram.

        Parameters are as in the source; those that differ then are written with their values.
        Statements that fail in PathView are left out.
        """
        by_value: ByValue = set()
        while True:
            try:
                diagram = read_diagram(self.script, by_value, self._failed)
            except DiagramError:
                self._refuse_failed()
                raise
            content = pvm.model(diagram, existing)
            differences = self.rehearsal.differences(self._job(content, diagram, settings, run))
            if not differences:
                return content, diagram
            more = {p for d in differences for p in self._parameters(d, diagram)} - by_value
            line = diagram.places.get(differences[0].line)
            if line is not None:
                self._failed[line] = differences[0].error
            elif not more:
                self._refuse(differences[0], diagram)
            by_value |= more

    def _job(
        self, content: Json, diagram: Diagram, settings: dict[str, str], run: dict[str, Any]
    ) -> Job:
        script, parts = self.script, diagram.values
        given = {k: v for k, v in diagram.settings.items() if k != "solver" and v}
        return Job(
            text=pvm.text(content),
            path=str(script.path),
            # the script has imported them already
            toolboxes=[f"{t.package}:{t.import_path}" for t in diagram.toolboxes],
            process=self.rehearsal.surroundings,
            now=self.frozen.now,
            parts={name: attributes(part) for name, part in parts.items()},
            parameters={
                **{name: diagram.parts[name].target.params for name in blocks_of(parts)},
                SETTINGS: given,
            },
            settings=settings,
            names=diagram.code_values,
            structure=structure(script.simulation, parts),
            run=run,
        )

    def _parameters(self, difference: Difference, diagram: Diagram) -> ByValue:
        """Parameters that may be written with their values for a difference to vanish."""
        name = difference.name
        if difference.variable == SETTINGS:
            return {(None, name)}
        if difference.variable not in diagram.parts:
            return set()
        part = diagram.parts[difference.variable]
        computed = [n for n, e in part.arguments.items() if not isinstance(e, ast.Constant)]
        named = name in {*part.known, *part.arguments}
        return {(id(part.value), n) for n in ([name] if named else computed)}

    # what cannot be written -----------------------------------------------------------------------

    def _refuse_own_simulation(self) -> None:
        script, simulation = self.script, self.script.simulation
        if type(simulation) is not Simulation:
            what = f"the simulation is a {type(simulation).__name__}"
            place = script.built_at(simulation)
            script.refuse(f"{what}; PathView has PathSim's Simulation only", place)
        for name, value in vars(simulation).items():
            if callable(value) and hasattr(Simulation, name):
                reason = f"{name} of the simulation is replaced; PathView has PathSim's own"
                script.refuse(reason, script.storing(name))
        for name in script.changed_libraries():
            reason = (
                f"{name} is changed, and PathView has its own: a class or function of a library "
            )
            script.refuse(reason + "cannot be replaced", script.storing(name.rpartition(".")[2]))

    def _refuse_failed(self) -> None:
        """Name the first statement that PathView cannot execute: the rest follows from it."""
        for line, error in self._failed.items():
            raise DiagramError(
                f"PathView cannot execute this line: {error}", path=self.script.path, line=line
            )

    def _refuse(self, difference: Difference, diagram: Diagram) -> NoReturn:
        self._refuse_failed()
        script, name = self.script, difference.name
        part = getattr(diagram.parts.get(difference.variable), "value", None)
        what = repr(name) if part is None else script.called(part)
        here, there = _short(difference.here, difference.there)
        values, place = f"{here}, and {there} in the model", script.last_mention(name)
        if difference.error:
            owner = name if part is None else f"parameter {name!r} of {what}"
            reason = f"PathView cannot evaluate {owner} before the blocks exist: {difference.error}"
            script.refuse(reason, script.built_at(part))
        if " in state " in here:
            reason, place = f"{what} {_DRAWS}", place or script.built_at(part)
        elif name in diagram.code_values:
            missing = "is changed by a statement that the model does not have"
            advice = (
                "give it its value where it is made, or change it by a call on a line of its own"
            )
            reason = f"{what} {missing}: it is {values}; {advice}"
        elif part is None:
            reason = f"{what} changes before the run: {values}; PathView cannot represent that"
            wires = [n for n, v in script.namespace.items() if isinstance(v, Connection)]
            place = script.last_mention(name, *wires)
        else:
            reason = f"{what} is changed after it is built: {name} is {values}"
            reason += "; PathView cannot represent that"
            place = script.last_mention(*self._names(part)) or script.built_at(part)
        script.refuse(reason, place or script.run_call)

    def _refuse_parting(self, parting: Parting, diagram: Diagram) -> NoReturn:
        self._refuse_failed()
        script = self.script
        if not parting.variable:
            reason = f"the script {parting.here}, and the model {parting.there}"
            script.refuse(f"at t = {parting.time!r} s {reason}", script.run_call)
        part = diagram.parts[parting.variable].value
        place = script.last_mention(*self._names(part))
        if script.states:
            method, line = script.states[-1]
            why = f"{method}() in line {line} changes its state before the run"
        elif place is not None:
            why = f"line {place.lineno} may change it after it is built"
        elif self.frozen.seeded:
            why = f"it {_DRAWS}"
        else:
            why = "it depends on something that the model does not have"
        at = f"port {parting.port} at t = {parting.time!r} s"
        values = f"{parting.here}, and {parting.there} in the model"
        reason = f"{script.called(part)} flies otherwise in the model: {at} is {values}; {why}"
        script.refuse(reason, place or script.built_at(part))

    def _names(self, part: Any) -> set[str]:
        """The script's names for a part, and those of collections that hold it."""

        def has(value: Any) -> bool:
            held = value.values() if isinstance(value, dict) else value
            return isinstance(value, (dict, list, tuple)) and any(v is part for v in held)

        names = {n for n, v in self.script.namespace.items() if v is part or has(v)}
        return names | {self.script.target(part)} - {""}


def _short(here: str, there: str) -> list[str]:
    """Texts of at most 60 characters, around the place where they differ."""
    pairs = enumerate(zip(here, there, strict=False))
    start = max(0, next((i for i, (a, b) in pairs if a != b), 0) - 20)
    return [shortened(f"...{text[start:]}" if start else text) for text in (here, there)]
