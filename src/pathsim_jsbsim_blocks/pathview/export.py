"""Turn a diagram script into a PathView model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .._core.checks import as_path
from ..errors import DiagramError
from . import pvm
from .diagram import Diagram
from .generate import to_python
from .reader import read_diagram
from .script import Script, quiet
from .shape import Json
from .toolboxes import registry_for, required_toolboxes


def export_script(script: str | Path, out: str | Path | None = None) -> Path:
    """Write a PathSim script as a PathView model.

    The script is imported, which builds its simulation and does not run it. Blocks, wires, events
    and solver settings are read from the simulation, parameters from the source as written.

    Parameters
    ----------
    script : str or Path
        a script that builds a ``Simulation`` at its top level
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
        if the script fails, says what PathView cannot (file, line and reason), or the model
        cannot be written
    """
    script = as_path("script", script)
    out = script.parent / f"{script.stem}.pvm" if out is None else as_path("out", out)
    pvm.write(out, pvm.text(script_model(script, pvm.read(out) if out.exists() else None)))
    return out


def script_model(script: str | Path, existing: Json | None = None) -> Json:
    """The content of a script's model, after a rehearsal of what PathView does with it."""
    live = Script(script)
    diagram = read_diagram(live)
    content = pvm.model(diagram, existing)
    _validate(diagram)
    _rebuild(content, live)
    return content


def _validate(diagram: Diagram) -> None:
    """PathView's own check before a run: every parameter, with the code alone, without blocks."""
    namespace: dict[str, Any] = {"np": np}
    with quiet():
        _run(diagram.context, namespace, "exec", diagram, "the code context", None)
        todo = list(diagram.graph.nodes)
        for node in todo:
            for name, value in node.params.items():
                _run(value, namespace, "eval", diagram,
                     f"parameter {name!r} of {node.name!r}", node.line)
            todo += node.graph.nodes if node.graph else []


def _run(code: str, namespace: dict[str, Any], mode: str, diagram: Diagram, what: str,
         line: int | None) -> None:
    try:
        exec(compile(code, what, mode), namespace)
    except Exception as error:
        raise DiagramError(f"PathView cannot evaluate {what} before the blocks exist: "
                           f"{type(error).__name__}: {error}", path=diagram.path,
                           line=line) from error


def _rebuild(content: Json, script: Script) -> None:
    """Build the model's diagram once, and compare it with the script's."""
    # the script has imported its toolboxes already
    imported = [f"{t.package}:{t.import_path}" for t in required_toolboxes(content, script.path)]
    registry = registry_for(content, script.path, trust_toolboxes=imported)
    code = to_python(content, registry, script.path)
    namespace: dict[str, Any] = {"__name__": "rebuilt"}
    try:
        with quiet():
            exec(compile(code, "model", "exec"), namespace)
    except Exception as error:
        raise DiagramError(f"PathView cannot build this model: {type(error).__name__}: {error}",
                           path=script.path) from error
    for what, count in (("blocks and states", lambda sim: sim.size),
                        ("wires", lambda sim: sum(len(c) * len(c.targets)
                                                  for c in sim.connections))):
        here, there = count(script.simulation), count(namespace["sim"])
        if here != there:
            raise DiagramError(f"the model has {there} {what}, the script {here}",
                               path=script.path)
