"""Prove a model by flight, built from its text in a separate process and compared with its script.

`fly_model` runs in that process, `prove` in the script's.
"""

from __future__ import annotations

import contextlib
import functools
import json
import logging
import multiprocessing
import os
import random
import signal
import sys
import time
import types
import warnings
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from pathsim import Simulation
from pathsim.blocks import Block

from .._core.pathsim_internals import each_sample, port_names
from .._seeding import draws_from_shared, seed_blocks
from ..errors import DiagramError
from .generate import checked, to_python
from .toolboxes import registry_for

_AT_ONCE = 200  # rows

# the outputs of all blocks when the simulation samples: time, and the values of each block
Row = tuple[float, tuple[bytes, ...]]


@dataclass
class Job:
    """A model, and the state of its script when the first run begins."""

    text: str  # of the model file
    path: Path  # the script, for messages
    toolboxes: list[str]  # that the model may import
    process: dict[str, Any]  # `surroundings` before the script ran
    blocks: list[str]  # PathView's variables
    expressions: list[str]  # of all parameters
    seeded: set[str]  # modules whose shared generator the script has seeded
    unseeded: list[str]  # blocks that draw random numbers without a seed, by variable
    run: dict[str, Any]  # arguments of the run


@dataclass(frozen=True)
class Proof:
    """The extent of a comparison that agreed bit for bit."""

    steps: int
    signals: int  # outputs of blocks
    time: float  # s, end of the comparison
    complete: bool  # the run was flown to its end

    def __str__(self) -> str:
        return f"same for {self.steps:,} steps, {self.signals} signals" + (
            "" if self.complete else f", to t = {self.time:.6g} s only (--check all: to the end)"
        )


@dataclass
class Difference(Exception):
    """The first difference between the flights of the script's diagram and of the model."""

    time: float
    script: str
    model: str
    variable: str = ""  # a block
    port: str = ""


class _Ended(BaseException):
    """The time to compare is over."""


def surroundings() -> dict[str, Any]:
    """The process state in which a script starts."""
    return {"environment": dict(os.environ), "folder": os.getcwd(), "path": list(sys.path)}


# the model's side ---------------------------------------------------------------------------------


def fly_model(pipe: Connection, job: Job) -> None:
    """Send the reason why the model cannot be built, or "", its rows, and how its flight ended."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the script's process ends this one
    _be_pathview(job.process)
    rows: list[Row] = []

    def take(t: float) -> None:
        rows.append(_row(t, blocks))
        if len(rows) >= _AT_ONCE:
            pipe.send(rows)
            rows.clear()

    end = "has ended"
    try:
        variables = _built(job)
        blocks = [variables[name] for name in job.blocks]
        _seed([variables[name] for name in job.unseeded], job.seeded)
        pipe.send("")
        with each_sample(variables["sim"], take):
            variables["sim"].run(**job.run)
    except BaseException as error:
        end = f"fails: {type(error).__name__}: {error}"
    pipe.send(rows)
    pipe.send(end)


def _be_pathview(process: Mapping[str, Any]) -> None:
    """Imitate PathView's process in the script's initial state: other arguments, no output."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    os.environ.clear()
    os.environ.update(process["environment"])
    sys.path[:] = process["path"]
    with contextlib.suppress(OSError):
        os.chdir(process["folder"])
    sys.argv = ["pathview", "serve", "--port", "5000"]
    logging.disable(logging.INFO)
    warnings.simplefilter("ignore")


def _built(job: Job) -> dict[str, Any]:
    """Build the model and return the namespace of its script."""
    content = json.loads(job.text)
    # PathView evaluates parameters before it builds blocks, so they may only use the code
    namespace: dict[str, Any] = {"np": np, "__name__": "pathview"}
    exec(compile(content["codeContext"]["code"], "code", "exec", dont_inherit=True), namespace)
    for expression in job.expressions:
        eval(compile(expression, expression, "eval", dont_inherit=True), namespace)
    registry = registry_for(content, job.path, trust_toolboxes=job.toolboxes)
    code = to_python(checked(content, registry, job.path), registry, job.path)
    namespace = {"__name__": "pathview"}
    exec(compile(code, "model", "exec", dont_inherit=True), namespace)
    if job.run["reset"]:
        namespace["sim"].reset()
    return namespace


# the script's side --------------------------------------------------------------------------------


def prove(simulation: Simulation, blocks: Mapping[str, Block], job: Job, limit: float) -> Proof:
    """Fly a simulation beside its model, for ``limit`` s of processing at most.

    It raises a `Difference` at the first that occurs, and a `DiagramError` if the model cannot fly.
    """
    pipe, theirs = _processes().Pipe()
    process = _processes().Process(target=fly_model, args=(theirs, job))
    # the process would import the main program
    with patch.dict(sys.modules, __main__=types.ModuleType("__main__")):
        process.start()
    theirs.close()
    try:
        if failure := _received(pipe, job.path):
            reason = failure.removeprefix("fails: ")
            raise DiagramError(f"the model cannot be built: {reason}", path=job.path)
        _seed([blocks[name] for name in job.unseeded], job.seeded)
        return _compared(simulation, blocks, job, pipe, time.process_time() + limit)
    finally:
        process.kill()
        process.join()
        pipe.close()


def _compared(
    simulation: Simulation, blocks: Mapping[str, Block], job: Job, pipe: Connection, end: float
) -> Proof:
    rows = _rows(pipe, job.path)
    time_reached, steps, complete = 0.0, -1, True

    def take(t: float) -> None:
        nonlocal time_reached, steps
        mine, theirs = _row(t, blocks.values()), next(rows)
        if isinstance(theirs, str):
            raise Difference(t, "continues", theirs)
        if mine != theirs:
            _part(blocks, mine, theirs)
        time_reached, steps = t, steps + 1
        if time.process_time() > end:
            raise _Ended

    try:
        with each_sample(simulation, take):
            Simulation.run(simulation, **job.run)
        if not isinstance(last := next(rows), str):
            raise Difference(last[0], "has ended", "continues")
        if last.startswith("fails"):
            raise Difference(time_reached, "has ended", last)
    except _Ended:
        complete = False
    signals = sum(len(block.outputs) for block in blocks.values())
    return Proof(steps, signals, time_reached, complete)


def _part(blocks: Mapping[str, Block], mine: Row, theirs: Row) -> None:
    """Raise for the first output that differs; NaN equals NaN."""
    if mine[0] != theirs[0]:
        raise Difference(mine[0], "samples then", f"samples at {theirs[0]!r}")
    for (name, block), *both in zip(blocks.items(), mine[1], theirs[1], strict=True):
        ours, values = map(np.frombuffer, both)
        if len(ours) != len(values):
            raise Difference(mine[0], f"has {len(ours)} outputs", f"has {len(values)}", name)
        unlike = (ours.view("i8") != values.view("i8")) & ~(np.isnan(ours) & np.isnan(values))
        if unlike.any():
            port = int(np.flatnonzero(unlike)[0])
            label = next((n for n, k in port_names(block.outputs).items() if k == port), str(port))
            raise Difference(
                mine[0], repr(float(ours[port])), repr(float(values[port])), name, label
            )


def _rows(pipe: Connection, path: Path) -> Iterator[Row | str]:
    """The model's rows as they arrive, then how its flight ended."""
    while not isinstance(message := _received(pipe, path), str):
        yield from message
    yield message


def _received(pipe: Connection, path: Path) -> Any:
    try:
        return pipe.recv()
    except (EOFError, ConnectionError):
        why = "the model's code ends the process in which it runs, which it must not do"
        raise DiagramError(why, path=path) from None


@functools.cache
def _processes() -> Any:
    """Starts processes with no state of this one; a fork server, if available, saves imports."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([fly_model.__module__, "pathview.converter"])
    return context


# both sides ---------------------------------------------------------------------------------------


def _row(t: float, blocks: Iterable[Block]) -> Row:
    return float(t), tuple(block.outputs.to_array().tobytes() for block in blocks)


def _seed(blocks: Sequence[Block], modules: Collection[str]) -> None:
    """Give blocks without a seed the same random numbers on both sides.

    The generators of modules, too, unless the script has seeded them.
    """
    seed_blocks(blocks, 0)
    if "numpy" not in modules:
        np.random.seed(0)  # noqa: NPY002
    if "random" not in modules:
        random.seed(0)
    for block in filter(draws_from_shared, blocks):
        block.sample(0.0, 0.0)  # replaces the numbers drawn when it was built
