"""Prove a model by flight: fly it beside its script, in a separate process."""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import sys
import time
import types
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from unittest.mock import patch

import numpy as np
from pathsim import Simulation

from .._core.pathsim_internals import each_sample
from ..errors import DiagramError
from .rehearsal import Difference, Ended, Job, Row, rehearse, row

_AT_ONCE = 200  # rows


@dataclass(frozen=True)
class Proof:
    """What was compared, and found equal, bit for bit."""

    steps: int
    signals: int  # outputs of blocks
    time: float  # until when, s
    whole: bool  # the run was flown to its end
    lost: str = ""  # a signal that is NaN at the end

    def __str__(self) -> str:
        return (
            f"same for {self.steps:,} steps, {self.signals} signals"
            + ("" if self.whole else f", to t = {self.time:.6g} s only (--check all: to the end)")
            + (f"; the run ends with NaN in {self.lost}" if self.lost else "")
        )


class Rehearsal:
    """A process in which a script's model flies; it knows nothing of the script but the model.

    As a context: it ends with it.
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
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._pipe.close()

    def build(self, job: Job) -> Difference | None:
        """Build the model; where it is not as its script's diagram is."""
        self._pipe, theirs = _processes().Pipe()
        process = _processes().Process(target=rehearse, args=(theirs, job))
        # the process would import the main program
        with patch.dict(sys.modules, __main__=types.ModuleType("__main__")):
            process.start()
        self._process = process
        theirs.close()
        return self._answer()

    def fly(
        self, simulation: Simulation, run: dict[str, Any], blocks: dict[str, Any], limit: float
    ) -> Proof | Difference:
        """Fly a simulation beside the model, for ``limit`` s of processing at most."""
        rows: list[Row] = []
        reached, steps, end = 0.0, -1, time.process_time() + limit

        def take(t: float) -> None:
            nonlocal reached, steps
            rows.append(row(t, blocks.values()))
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
        signals = sum(len(block.outputs) for block in blocks.values())
        lost = (n for n, b in blocks.items() if np.isnan(b.outputs.to_array()).any())
        return self._answer() or Proof(steps, signals, reached, whole, next(lost, ""))

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
