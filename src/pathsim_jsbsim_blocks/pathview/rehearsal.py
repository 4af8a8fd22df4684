"""Build a model in a process of its own, and fly it beside its script.

`serve` is the program of that process; `proof` is the other side.
"""

from __future__ import annotations

import contextlib
import io
import json
import logging
import os
import pickle
import struct
import sys
import traceback
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO
from unittest.mock import patch

import numpy as np
from pathsim import Simulation, Subsystem
from pathsim.blocks import Block

from .._core._pathsim import each_sample, own_events, port_names, port_number
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
    """A model, and what its script has when its first run begins.

    Attributes
    ----------
    text : str
        the model file's text
    path : str
        the script, for messages
    toolboxes : list of str
        what the model may import
    process : dict
        environment, folder and import path of the script's process before the script ran
    now : float
        time at which the clock is frozen
    parts : dict
        the attributes of each block and event as texts, by its variable in PathView's script
    parameters : dict
        expressions by part, or SETTINGS, and name
    settings, names : dict
        settings of the solver, and what the model's code needs, as texts
    structure : dict
        see `structure`
    run : dict
        arguments of the run
    """

    text: str
    path: str
    toolboxes: list[str]
    process: dict[str, Any]
    now: float
    parts: dict[str, dict[str, str]]
    parameters: dict[str, dict[str, str]]
    settings: dict[str, str]
    names: dict[str, str]
    structure: dict[str, str]
    run: dict[str, Any]


@dataclass
class Difference:
    """Where the model is not as the script's diagram is.

    ``variable`` is a part of the diagram, SETTINGS, or empty; ``name`` an attribute or parameter
    of it, a part of the structure or a name of the code. ``error`` says what cannot be evaluated,
    ``line`` which line of the code.
    """

    variable: str
    name: str
    here: str = ""
    there: str = ""
    error: str = ""
    line: int = 0


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


def send(stream: BinaryIO, value: Any) -> None:
    data = pickle.dumps(value)
    stream.write(struct.pack("<Q", len(data)) + data)
    stream.flush()


def receive(stream: BinaryIO) -> Any:
    """The next value; EOFError where the other side has gone."""

    def exactly(size: int) -> bytes:
        parts = []
        while size:
            parts.append(stream.read(size))
            if not parts[-1]:
                raise EOFError
            size -= len(parts[-1])
        return b"".join(parts)

    return pickle.loads(exactly(struct.unpack("<Q", exactly(8))[0]))


def blocks_of(parts: Mapping[str, Any]) -> dict[str, Block]:
    return {name: part for name, part in parts.items() if isinstance(part, Block)}


def row(t: float, blocks: Iterable[Block]) -> Row:
    return float(t), tuple(block.outputs.to_array().tobytes() for block in blocks)


def structure(simulation: Simulation, parts: Mapping[str, Any]) -> dict[str, str]:
    """Blocks, events and active wires of the simulation and each subsystem; how it is solved."""
    names = {id(part): name for name, part in parts.items()}

    def inside(system: Any, events: Iterable[Any]) -> str:
        wires = [
            f"{names.get(id(c.source.block))}[{port_number(c.source.block.outputs, out)}]-"
            f"{names.get(id(target.block))}[{port_number(target.block.inputs, into)}]"
            for c in system.connections
            if c
            for target in c.targets
            for out, into in zip(c.source.ports, target.ports, strict=True)
        ]
        members = [str(names.get(id(part))) for part in (*system.blocks, *events)]
        return ", ".join(sorted(wires) + sorted(members))

    solver = ("dt", "dt_min", "dt_max", "Solver", "tolerance_fpi", "iterations_max", "_active")
    return {
        "connections": inside(simulation, simulation.events),
        **{
            f"connections of {name}": inside(part, own_events(part))
            for name, part in parts.items()
            if isinstance(part, Subsystem)
        },
        **{name: text_of(getattr(simulation, name)) for name in solver},
        "engine": str(attributes(simulation.engine)),
    }


# the model's side ---------------------------------------------------------------------------------


def serve() -> None:
    """Rehearse one model after the other, each in a copy of this process that knows no other."""
    # what a model prints must not come between the replies
    replies = os.fdopen(os.dup(1), "wb")
    requests = os.fdopen(os.dup(0), "rb", buffering=0)
    for standard, flag in ((0, os.O_RDONLY), (1, os.O_WRONLY)):
        os.dup2(os.open(os.devnull, flag), standard)
    from pathview import converter as converter  # loaded before the copies are made

    while True:
        try:
            job = receive(requests)
        except EOFError:
            return
        child = os.fork() if hasattr(os, "fork") else 0
        if child:
            _, status = os.waitpid(child, 0)
            if status:  # where the requests stand is not known
                return
        else:
            _rehearse(job, requests, replies)
            os._exit(0)


def _rehearse(job: Job, requests: BinaryIO, replies: BinaryIO) -> None:
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
                differences = [Difference("", "", error=said(error))]
        send(replies, differences)
        if not differences:
            rows = _rows(requests)
            send(replies, _flown(namespace, job, frozen, rows))
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
        return [Difference("", "the code", error=said(error), line=lines[0] if lines else 0)]
    found = []
    for variable, parameters in job.parameters.items():
        for name, expression in parameters.items():
            try:
                value = eval(compile(expression, name, "eval", dont_inherit=True), namespace)
                if variable == SETTINGS and repr(float(value)) != job.settings[name]:
                    found.append(Difference(variable, name, job.settings[name], repr(value)))
            except (Exception, SystemExit) as error:
                found.append(Difference(variable, name, error=said(error)))
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


def _flown(
    namespace: dict[str, Any], job: Job, frozen: Frozen, rows: Iterator[Row]
) -> Parting | None:
    """Fly the model beside the script, and say where they part."""
    simulation, blocks = namespace["sim"], blocks_of({name: namespace[name] for name in job.parts})

    def take(t: float) -> None:
        theirs, mine = next(rows, None), row(t, blocks.values())
        if theirs is None:
            raise Parting("", "", t, "has ended", "goes on")
        if mine != theirs:
            raise _parting(blocks, theirs, mine)

    frozen.begin()
    try:
        with each_sample(simulation, take):
            simulation.run(**job.run)
        rest = next(rows, None)
    except Ended:
        return None
    except Parting as parting:
        return parting
    except BaseException as error:
        return Parting("", "", simulation.time, "goes on", f"fails: {said(error)}")
    return rest and Parting("", "", rest[0], "goes on", "has ended")


def _parting(blocks: Mapping[str, Block], theirs: Row, mine: Row) -> Parting:
    if theirs[0] != mine[0]:
        return Parting("", "", theirs[0], "samples then", f"samples at {mine[0]!r}")
    name = next(n for n, a, b in zip(blocks, theirs[1], mine[1], strict=True) if a != b)
    i = list(blocks).index(name)
    here, there = (np.frombuffer(r[1][i]) for r in (theirs, mine))
    if len(here) != len(there):
        return Parting(name, "", theirs[0], f"has {len(here)} outputs", f"has {len(there)}")
    port = next(k for k, (x, y) in enumerate(zip(here, there, strict=True)) if repr(x) != repr(y))
    labels = {k: label for label, k in port_names(blocks[name].outputs).items()}
    return Parting(
        name,
        labels.get(port, str(port)),
        theirs[0],
        repr(float(here[port])),
        repr(float(there[port])),
    )


def _rows(requests: BinaryIO) -> Iterator[Row]:
    """The script's rows as they come; `Ended` where its flight is not to go on."""
    while not isinstance(message := receive(requests), bool):
        yield from message
    if not message:
        raise Ended


def said(error: BaseException) -> str:
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
