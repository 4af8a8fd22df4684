"""Prove a model by flight: fly it beside its script, in a process of its own."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import sys
import time
import types
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

from pathsim import Simulation
from pathsim.blocks import Block

from .._core.pathsim_internals import each_sample
from ..errors import DiagramError
from .rehearsal import Difference, Ended, Job, Parting, Row, rehearse, row

_AT_ONCE = 200  # rows


@dataclass(frozen=True)
class Proof:
    """What was compared, and found equal, bit for bit."""

    steps: int
    signals: int  # outputs of blocks
    time: float  # until when, s
    whole: bool  # the run was flown to its end

    def __str__(self) -> str:
        return f"same for {self.steps:,} steps, {self.signals} signals" + (
            "" if self.whole else f", to t = {self.time:.6g} s only (--check all: to the end)"
        )


class Rehearsal:
    """Builds the models of a script and flies the last beside it, each in a process of its own.

    These know nothing of the script but the model. As a context: they end with it.
    """

    def __init__(self, script: str | Path) -> None:
        self.script = script
        # where the script begins
        self.surroundings = {
            "environment": dict(os.environ),
            "folder": os.getcwd(),
            "path": list(sys.path),
        }
        self._process: Any = None

    def __enter__(self) -> Rehearsal:
        return self

    def __exit__(self, *_: Any) -> None:
        self._end()

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()

    def differences(self, job: Job) -> list[Difference]:
        """Build a model; where it is not as its script's diagram is."""
        self._end()
        self._pipe, theirs = _processes().Pipe()
        self._process = _processes().Process(target=rehearse, args=(theirs, job))
        # the process would import the main program
        with patch.dict(sys.modules, __main__=types.ModuleType("__main__")):
            self._process.start()
        theirs.close()
        return self._answer()

    def fly(
        self, simulation: Simulation, run: Mapping[str, Any], blocks: Sequence[Block], limit: float
    ) -> Proof | Parting:
        """Fly a simulation beside the model built last, for ``limit`` s of processing at most."""
        rows: list[Row] = []
        reached, steps, end = 0.0, -1, time.process_time() + limit

        def take(t: float) -> None:
            nonlocal reached, steps
            rows.append(row(t, blocks))
            reached, steps = t, steps + 1
            if len(rows) >= _AT_ONCE:
                self._send(rows)
                rows.clear()
            if time.process_time() > end:
                raise Ended

        try:
            with each_sample(simulation, take):
                Simulation.run(simulation, **run)
            whole = True
        except Ended:
            whole = False
        if rows:
            self._send(rows)
        self._send(whole)
        parting = self._answer()
        signals = sum(len(block.outputs) for block in blocks)
        return parting or Proof(steps, signals, reached, whole)

    def _send(self, value: Any) -> None:
        with contextlib.suppress(ConnectionError):  # its answer is missing then
            self._pipe.send(value)

    def _answer(self) -> Any:
        try:
            return self._pipe.recv()
        except (EOFError, ConnectionError):
            raise DiagramError(
                "the model ends the process in which it flies: its code must not", path=self.script
            ) from None


@functools.cache
def _processes() -> Any:
    """Makes processes that know nothing of this one; where there are forks, with imports made."""
    if "forkserver" not in multiprocessing.get_all_start_methods():
        return multiprocessing.get_context("spawn")
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([rehearse.__module__, "pathview.converter"])
    return context
