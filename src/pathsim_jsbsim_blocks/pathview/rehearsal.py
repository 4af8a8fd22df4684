"""Build a model in a process of its own, and fly it beside its script.

`rehearse` is the program of that process; `proof` is the other side.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import signal
import sys
import traceback
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from pathsim import Simulation, Subsystem
from pathsim.blocks import Block

from .._core.pathsim_internals import each_sample, own_events, port_names
from .diagram import ends
from .frozen import Frozen
from .generate import to_python
from .plain import MODEL, attributes, text_of
from .shape import Json
from .toolboxes import registry_for

# the outputs of all blocks when the simulation samples: time, and the values of each block
Row = tuple[float, tuple[bytes, ...]]
SETTINGS = "settings"


@dataclass
class Job:
    """A model, and what its script has when its first run begins, as texts."""

    text: str  # of the model file
    path: str  # the script, for messages
    toolboxes: list[str]  # what the model may import
    process: dict[str, Any]  # environment, folder and import path before the script ran
    now: float  # time at which the clock is frozen
    parts: dict[str, dict[str, str]]  # attributes of blocks and events, by PathView's variables
    parameters: dict[str, dict[str, str]]  # expressions by part, or SETTINGS, and name
    settings: dict[str, str]  # of the solver
    names: dict[str, str]  # what the model's code needs
    structure: dict[str, str]  # see `structure`
    run: dict[str, Any]  # arguments of the run


@dataclass
class Difference:
    """Where the model is not as the script's diagram is, or what of it cannot be evaluated."""

    variable: str  # a part of the diagram, SETTINGS, or empty
    name: str  # an attribute or parameter, a part of the structure, or a name of the code
    here: str = ""
    there: str = ""
    error: str = ""
    line: int = 0  # of the code


@dataclass
class Parting(Exception):
    """The first output, in time, at which the flight of the model leaves that of the script."""

    variable: str
    port: str
    time: float
    here: str
    there: str


class Ended(BaseException):
    """The flight was not to go on to its end."""


# both sides ---------------------------------------------------------------------------------------


def blocks_of(parts: Mapping[str, Any]) -> dict[str, Block]:
    return {name: part for name, part in parts.items() if isinstance(part, Block)}


def row(t: float, blocks: Iterable[Block]) -> Row:
    return float(t), tuple(block.outputs.to_array().tobytes() for block in blocks)


def structure(simulation: Simulation, parts: Mapping[str, Any]) -> dict[str, str]:
    """Blocks, events and active wires of the simulation and each subsystem; how it is solved."""
    names = {id(part): name for name, part in parts.items()}

    def inside(system: Any, events: Iterable[Any]) -> str:
        wires = [
            f"{names.get(id(source))}[{out}]-{names.get(id(target))}[{into}]"
            for connection in filter(None, system.connections)
            for source, out, target, into in ends(connection)
        ]
        members = [str(names.get(id(part))) for part in (*system.blocks, *events)]
        return ", ".join(sorted(wires) + sorted(members))

    solver = ("dt", "dt_min", "dt_max", "Solver", "tolerance_fpi", "iterations_max")
    inner = {name: part for name, part in parts.items() if isinstance(part, Subsystem)}
    return {
        "connections": inside(simulation, simulation.events),
        **{f"connections of {name}": inside(s, own_events(s)) for name, s in inner.items()},
        **{name: text_of(getattr(simulation, name)) for name in solver},
        "on": str(bool(simulation)),
        "engine": str(attributes(simulation.engine)),
        "np.seterr": str([kind for kind, how in np.geterr().items() if how == "raise"]),
    }


# the model's side ---------------------------------------------------------------------------------


def rehearse(pipe: Connection, job: Job) -> None:
    """The program of the model's process."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the script's process ends this one
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    os.environ.clear()
    os.environ.update(job.process["environment"])
    sys.path[:] = job.process["path"]
    with contextlib.suppress(OSError):
        os.chdir(job.process["folder"])
    frozen = Frozen(job.now)
    with _as_in_pathview(), frozen.applied():
        content = json.loads(job.text)
        namespace: dict[str, Any] = {}
        differences = _evaluated(content, job)
        if not differences:
            try:
                namespace = _built(content, job, frozen)
                differences = _compared(namespace, job)
            except Exception as error:
                differences = [Difference("", "", error=error_text(error))]
        pipe.send(differences)
        if not differences:
            rows = _rows(pipe)
            pipe.send(_flown(namespace, job, rows))
            with contextlib.suppress(Ended):
                for _ in rows:
                    pass


def _evaluated(content: Json, job: Job) -> list[Difference]:
    """PathView's own check before a run: every parameter, with the code alone, without blocks."""
    namespace: dict[str, Any] = {"np": np, "__name__": MODEL}
    try:
        exec(compile(content["codeContext"]["code"], "code", "exec", dont_inherit=True), namespace)
    except (Exception, SystemExit) as error:
        lines = [
            line
            for frame, line in traceback.walk_tb(error.__traceback__)
            if frame.f_code.co_filename == "code" and frame.f_code.co_name == "<module>"
        ]
        return [Difference("", "the code", error=error_text(error), line=lines[0] if lines else 0)]
    found = []
    for variable, parameters in job.parameters.items():
        for name, expression in parameters.items():
            try:
                value = eval(compile(expression, name, "eval", dont_inherit=True), namespace)
                if variable == SETTINGS and repr(float(value)) != job.settings[name]:
                    found.append(Difference(variable, name, job.settings[name], repr(value)))
            except (Exception, SystemExit) as error:
                found.append(Difference(variable, name, error=error_text(error)))
    return found


def _built(content: Json, job: Job, frozen: Frozen) -> dict[str, Any]:
    """The names of the model's script, which it builds."""
    path = Path(job.path)
    code = to_python(content, registry_for(content, path, trust_toolboxes=job.toolboxes), path)
    namespace: dict[str, Any] = {"__name__": MODEL}
    frozen.begin()
    exec(compile(code, "model", "exec", dont_inherit=True), namespace)
    if job.run["reset"]:
        namespace["sim"].reset()
    frozen.begin()
    return namespace


def _compared(namespace: dict[str, Any], job: Job) -> list[Difference]:
    """Plain values that differ: the flight need not reach a limit for that."""
    parts = {name: namespace[name] for name in job.parts}
    both: list[tuple[str, dict[str, str], dict[str, str]]] = [
        (name, mine, attributes(parts[name])) for name, mine in job.parts.items()
    ]
    both.append(("", job.structure, structure(namespace["sim"], parts)))
    names = job.names.keys() & namespace.keys()
    both.append(("", job.names, {name: text_of(namespace[name]) for name in names}))
    return [
        Difference(variable, name, mine.get(name, "absent"), theirs.get(name, "absent"))
        for variable, mine, theirs in both
        for name in {**mine, **theirs}
        if mine.get(name) != theirs.get(name)
    ]


def _flown(namespace: dict[str, Any], job: Job, rows: Iterator[Row]) -> Parting | None:
    """Fly the model beside the script, and say where they part."""
    simulation, blocks = namespace["sim"], blocks_of({name: namespace[name] for name in job.parts})

    def take(t: float) -> None:
        theirs, mine = next(rows, None), row(t, blocks.values())
        if theirs is None:
            raise Parting("", "", t, "has ended", "goes on")
        if mine != theirs:
            raise _parting(blocks, theirs, mine)

    try:
        with each_sample(simulation, take):
            simulation.run(**job.run)
        rest = next(rows, None)
    except Ended:
        return None
    except Parting as parting:
        return parting
    except BaseException as error:
        return Parting("", "", simulation.time, "goes on", f"fails: {error_text(error)}")
    return rest and Parting("", "", rest[0], "goes on", "has ended")


def _parting(blocks: Mapping[str, Block], theirs: Row, mine: Row) -> Parting:
    if theirs[0] != mine[0]:
        return Parting("", "", theirs[0], "samples then", f"samples at {mine[0]!r}")
    pairs = zip(blocks.items(), theirs[1], mine[1], strict=True)
    (name, block), *both = next(pair for pair in pairs if pair[1] != pair[2])
    here, there = map(np.frombuffer, both)
    if len(here) != len(there):
        return Parting(name, "", theirs[0], f"has {len(here)} outputs", f"has {len(there)}")
    port = int(np.flatnonzero(here.view("i8") != there.view("i8"))[0])
    label = next((n for n, k in port_names(block.outputs).items() if k == port), str(port))
    return Parting(name, label, theirs[0], repr(float(here[port])), repr(float(there[port])))


def _rows(pipe: Connection) -> Iterator[Row]:
    """The script's rows as they come; `Ended` where its flight is not to go on."""
    while not isinstance(message := pipe.recv(), bool):
        yield from message
    if not message:
        raise Ended


def error_text(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}"


@contextlib.contextmanager
def _as_in_pathview() -> Iterator[None]:
    """PathView's process: other arguments, no output."""
    logging.disable(logging.INFO)
    with (
        patch.object(sys, "argv", ["pathview", "serve", "--port", "5000"]),
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(io.StringIO()),
        warnings.catch_warnings(),
    ):
        warnings.simplefilter("ignore")
        yield
