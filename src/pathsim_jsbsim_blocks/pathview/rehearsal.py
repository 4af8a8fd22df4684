"""Build a model from its text, in a separate process, and fly it beside its script.

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
import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from pathsim.blocks import Block

from .._core.pathsim_internals import each_sample, port_names
from .._core.seeding import seed_blocks
from .generate import to_python
from .toolboxes import registry_for

# the outputs of all blocks when the simulation samples: time, and the values of each block
Row = tuple[float, tuple[bytes, ...]]


@dataclass
class Job:
    """A model, and what its script has when its first run begins."""

    text: str  # of the model file
    path: str  # the script, for messages
    toolboxes: list[str]  # what the model may import
    process: dict[str, Any]  # environment, folder and import path before the script ran
    blocks: list[str]  # PathView's variables
    parameters: dict[str, dict[str, str]]  # expressions by PathView's variables, and name
    seeded: bool  # whether the script has seeded NumPy's global generator
    unseeded: list[str]  # blocks that draw random numbers without a seed, by variable
    run: dict[str, Any]  # arguments of the run


@dataclass
class Difference(Exception):
    """Where the model is not, or does not fly, as the script's diagram."""

    variable: str = ""  # a block or event
    name: str = ""  # of an output or a parameter
    here: str = ""
    there: str = ""
    time: float | None = None
    error: str = ""


class Ended(BaseException):
    """The flight was not to go on to its end."""


# both sides ---------------------------------------------------------------------------------------


def row(t: float, blocks: Iterable[Block]) -> Row:
    return float(t), tuple(block.outputs.to_array().tobytes() for block in blocks)


def seed_unseeded(blocks: Iterable[Block], seeded: bool) -> None:
    """Give blocks without a seed the same random numbers on both sides.

    NumPy's global generator, too, unless the script has seeded it.
    """
    for number, block in enumerate(blocks):
        seed_blocks([block], number)
    if not seeded:
        np.random.seed(0)  # noqa: NPY002


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
    with _as_in_pathview():
        namespace: dict[str, Any] = {}
        try:
            difference = _not_evaluated(job)
            if difference is None:
                namespace = _built(job)
        except (Exception, SystemExit) as error:
            difference = Difference(error=error_text(error))
        pipe.send(difference)
        if difference is None:
            rows = _rows(pipe)
            pipe.send(_flown(namespace, job, rows))
            with contextlib.suppress(Ended):
                for _ in rows:
                    pass


def _not_evaluated(job: Job) -> Difference | None:
    """PathView's own check before a run: every parameter, with the code alone, without blocks."""
    namespace: dict[str, Any] = {"np": np, "__name__": "pathview"}
    try:
        code = json.loads(job.text)["codeContext"]["code"]
        exec(compile(code, "code", "exec", dont_inherit=True), namespace)
    except (Exception, SystemExit) as error:
        return Difference(name="the code", error=error_text(error))
    for variable, parameters in job.parameters.items():
        for name, expression in parameters.items():
            try:
                eval(compile(expression, name, "eval", dont_inherit=True), namespace)
            except (Exception, SystemExit) as error:
                return Difference(variable, name, error=error_text(error))
    return None


def _built(job: Job) -> dict[str, Any]:
    """The names of the model's script, which it builds."""
    path, content = Path(job.path), json.loads(job.text)
    code = to_python(content, registry_for(content, path, trust_toolboxes=job.toolboxes), path)
    namespace: dict[str, Any] = {"__name__": "pathview"}
    exec(compile(code, "model", "exec", dont_inherit=True), namespace)
    if job.run["reset"]:
        namespace["sim"].reset()
    return namespace


def _flown(namespace: dict[str, Any], job: Job, rows: Iterator[Row]) -> Difference | None:
    """Fly the model beside the script; where they part."""
    simulation, blocks = namespace["sim"], {name: namespace[name] for name in job.blocks}
    seed_unseeded([blocks[name] for name in job.unseeded], job.seeded)

    def take(t: float) -> None:
        theirs, mine = next(rows, None), row(t, blocks.values())
        if theirs is None:
            raise Difference(here="has ended", there="goes on", time=t)
        if mine != theirs and (found := _parting(blocks, theirs, mine)):
            raise found

    try:
        with each_sample(simulation, take):
            simulation.run(**job.run)
        rest = next(rows, None)
    except Ended:
        return None
    except Difference as difference:
        return difference
    except BaseException as error:
        fails = f"fails: {error_text(error)}"
        return Difference(here="goes on", there=fails, time=simulation.time)
    return rest and Difference(here="goes on", there="has ended", time=rest[0])


def _parting(blocks: Mapping[str, Block], theirs: Row, mine: Row) -> Difference | None:
    """The first output that is another one; NaN is equal to NaN."""
    if theirs[0] != mine[0]:
        return Difference(here="samples then", there=f"samples at {mine[0]!r}", time=theirs[0])
    for (name, block), *both in zip(blocks.items(), theirs[1], mine[1], strict=True):
        here, there = map(np.frombuffer, both)
        if len(here) != len(there):
            counts = f"has {len(here)} outputs", f"has {len(there)}"
            return Difference(name, "", *counts, time=theirs[0])
        unlike = (here.view("i8") != there.view("i8")) & ~(np.isnan(here) & np.isnan(there))
        if unlike.any():
            port = int(np.flatnonzero(unlike)[0])
            names = port_names(block.outputs).items()
            label = next((n for n, k in names if k == port), str(port))
            values = repr(float(here[port])), repr(float(there[port]))
            return Difference(name, label, *values, time=theirs[0])
    return None


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
