"""Turn a diagram script into a PathView model, and prove it by flight."""

from __future__ import annotations

import threading
import warnings
from pathlib import Path
from typing import Any, NoReturn

from pathsim.blocks import Block

from .._core.checks import number
from .._core.files import as_path
from . import pvm
from .diagram import Diagram
from .first_run import FirstRun
from .proof import Difference, Job, Proof, prove, surroundings
from .reader import read_diagram
from .shape import Json

_CHECKED = 60.0  # s of processing
_ONE_AT_A_TIME = threading.RLock()  # a script may change the directory and the environment


def export_script(
    script: str | Path, out: str | Path | None = None, check: float = _CHECKED
) -> Path:
    """Write a PathSim script as a PathView model that has flown as the script does.

    The script is executed, as the main program and without arguments, to the end of its first run.
    The model is the diagram at the start of that run. Blocks, wires, events and solver settings are
    read from the simulation. Parameters are copied from the source if that gives the diagram's
    values, and written as values otherwise. The model is then built from its text in a separate
    process and flown beside the script: every output of every block at every step must be the
    same, bit for bit. In this flight, random numbers without a seed are the same on both sides; a
    number that the script drew earlier is written as a value. A warning lists later runs, which
    the model omits.

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
        if the script fails or contains something that PathView cannot represent, the model behaves
        differently (file, line and reason), or the model cannot be written

    Warns
    -----
    UserWarning
        if the comparison ended before the run, with the time that it reached
    """
    out, proof = export_with_proof(script, out, check)
    if not proof.complete:
        warnings.warn(f"{out}: {proof}", UserWarning, stacklevel=2)
    return out


def export_with_proof(
    script: str | Path, out: str | Path | None = None, check: float = _CHECKED
) -> tuple[Path, Proof]:
    """Export as `export_script`; also return what was compared."""
    script = as_path("script", script)
    out = script.parent / f"{script.stem}.pvm" if out is None else as_path("out", out)
    check = number("check", check, above=0.0, infinite=True)
    with _ONE_AT_A_TIME:
        existing = pvm.read(out) if out.is_file() else None
        content, proof = script_model(script, existing, check)
        pvm.write(out, pvm.text(content))
    return out, proof


def script_model(
    script: str | Path, existing: Json | None = None, check: float = _CHECKED
) -> tuple[Json, Proof]:
    """The content of a script's model, and what was compared; parameters as in `export_script`.

    Warnings list what the script does after its first run, which the model omits, and random
    numbers that the model fixes.
    """
    with _ONE_AT_A_TIME:
        process = surroundings()
        first_run = FirstRun(script, lambda s: _proven(s, process, existing, check))
    start, notes = first_run.lines[-1] if first_run.lines else 1, list[str]()
    if first_run.generators.drawn:
        notes.append("random numbers without a seed that the script has drawn are fixed in the "
                     "model: it flies the same in each run")  # fmt: skip
    if omissions := first_run.left_out():
        what = ", ".join(f"line {line}: {text}" for line, text in omissions)
        notes.append(f"the model is the diagram of the first run (line {start}); not in it: {what}")
    for text in notes:
        # at the script's line: the caller's line would be in the command's code
        warnings.warn_explicit(text, UserWarning, str(first_run.path), start)
    return first_run.result


def _proven(
    script: FirstRun, process: dict[str, Any], existing: Json | None, check: float
) -> tuple[Json, Proof]:
    """The model of a script at the start of its first run, proved to behave like it."""
    diagram = read_diagram(script)
    content = pvm.model(diagram, existing)
    blocks = {n: p.value for n, p in diagram.parts.items() if isinstance(p.value, Block)}
    job = Job(
        text=pvm.text(content),
        path=script.path,
        # the script has imported them already
        toolboxes=[f"{t.package}:{t.import_path}" for t in diagram.toolboxes],
        process=process,
        blocks=list(blocks),
        expressions=[e for name in blocks for e in diagram.parts[name].target.params.values()],
        seeded=script.generators.set,
        unseeded=diagram.unseeded,
        run={
            "duration": diagram.duration,
            "reset": bool(script.run_start and script.run_start.arguments.get("reset")),
            "adaptive": True,
        },
    )
    try:
        return content, prove(script.simulation, blocks, job, check)
    except Difference as difference:
        _refuse(difference, script, diagram)


def _refuse(difference: Difference, script: FirstRun, diagram: Diagram) -> NoReturn:
    """Raise the error for a difference: block, port, time, and the likely line."""
    at = f"at t = {difference.time!r} s"
    if not difference.variable:
        parting = f"{at} the script {difference.script}, and the model {difference.model}"
        script.refuse(parting, script.run_call)
    part = diagram.parts[difference.variable].value
    call = script.built_at(part)
    place = script.last_mention(*script.names_of(part), script.target(part)) or call
    why = "it depends on something that the model does not have, such as the state of a generator "
    why += "of random numbers"
    if place is not call:
        why = f"line {getattr(place, 'lineno', 0)} may change it after it is built"
    if script.states:
        method, line = script.states[-1]
        why = f"{method}() in line {line} changes its state before the run"
    script.refuse(
        f"{script.called(part)} behaves differently in the model: port {difference.port} {at} is "
        f"{difference.script}, and {difference.model} in the model; {why}",
        place,
    )
