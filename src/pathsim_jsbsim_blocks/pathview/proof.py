"""Prove a model by flight: fly it beside its script, in a process of its own."""

from __future__ import annotations

import atexit
import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from pathsim import Simulation
from pathsim.blocks import Block

from .._core._pathsim import each_sample
from ..errors import DiagramError
from .rehearsal import Difference, Ended, Job, Parting, Row, receive, row, send, serve

_AT_ONCE = 200  # rows
_FORKS = hasattr(os, "fork")


@dataclass(frozen=True)
class Proof:
    """What was compared, and found equal, bit for bit.

    Attributes
    ----------
    steps : int
        steps of the simulation
    signals : int
        outputs of blocks
    time : float
        until when, s
    whole : bool
        whether the run was flown to its end
    """

    steps: int
    signals: int
    time: float
    whole: bool

    def __str__(self) -> str:
        return f"same for {self.steps:,} steps, {self.signals} signals" + (
            "" if self.whole else f", to t = {self.time:.6g} s only (--check all: to the end)"
        )


class Rehearsal:
    """A process that builds the model of a script and flies it beside the script.

    It is started before the script, of which it knows nothing but the model. As a context: where
    it is left by another error than a refusal, the process ends; otherwise it waits for the next
    model.
    """

    _idle: ClassVar[subprocess.Popen[bytes] | None] = None

    def __init__(self, script: str | Path) -> None:
        self.script = script
        # where the script begins
        self.surroundings = {
            "environment": dict(os.environ),
            "folder": os.getcwd(),
            "path": list(sys.path),
        }

    def __enter__(self) -> Rehearsal:
        self._process, Rehearsal._idle = Rehearsal._idle or self._started(), None
        return self

    def __exit__(self, kind: type[BaseException] | None, *details: Any) -> None:
        # a refusal comes before the flight or after its end
        if _FORKS and (kind is None or issubclass(kind, DiagramError)):
            Rehearsal._idle = self._process
        else:
            # the model flies in a copy of the process, which is in its group
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self._process.pid, signal.SIGKILL) if _FORKS else self._process.kill()
            self._process.communicate()

    def _started(self) -> subprocess.Popen[bytes]:
        program = (
            f"import sys; sys.path[:] = {sys.path!r}; from {serve.__module__} import serve; serve()"
        )
        process = subprocess.Popen(
            [sys.executable, "-c", program],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for this process, which ends the other
        )
        # it ends where its input does
        atexit.register(process.communicate)
        return process

    def differences(self, job: Job) -> list[Difference]:
        """Build a model; where it is not as its script's diagram is."""
        if self._process.poll() is not None:
            self._process = self._started()
        return self._answer(job)

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
        parting = self._answer(whole)
        signals = sum(len(block.outputs) for block in blocks)
        return parting or Proof(steps, signals, reached, whole)

    def _send(self, value: Any) -> None:
        with contextlib.suppress(BrokenPipeError):  # its answer is missing then
            send(self._process.stdin, value)  # type: ignore[arg-type]

    def _answer(self, value: Any) -> Any:
        self._send(value)
        try:
            return receive(self._process.stdout)  # type: ignore[arg-type]
        except EOFError:
            self._process.wait()
            raise DiagramError(
                "the model ends the process in which it flies: its code must not", path=self.script
            ) from None
