"""Run diagrams at the pace of the clock, and count what comes late."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pathsim import Simulation

from .pathsim_internals import Run, replacing_run
from .running import paced, watched_run

# Hz; how often simulated and real time are compared
_TICKS = 30


@dataclass
class Pace:
    """How well runs have kept up with the clock."""

    # s in the diagrams and on the clock
    simulated: float = 0.0
    real: float = 0.0
    # how often the two were compared, and how often the diagram was behind by more than a step
    ticks: int = 0
    late: int = 0
    # the most that it was behind, s
    worst: float = 0.0

    def __str__(self) -> str:
        return (
            f"real time: {self.simulated:.1f} s flown in {self.real:.1f} s, late at {self.late} of "
            f"{self.ticks} ticks, by {1000 * self.worst:.0f} ms at most"
        )


@contextlib.contextmanager
def in_real_time() -> Iterator[Pace]:
    """Context in which ``Simulation.run`` and `fly` keep the pace of the clock."""
    pace = Pace()

    def run(
        usual: Run, sim: Simulation, duration: float, reset: bool, adaptive: bool
    ) -> dict[str, Any]:
        if reset:
            sim.reset()
        began, start, last = time.perf_counter(), sim.time, 0

        def wait(passed: float) -> None:
            nonlocal last
            time.sleep(max(passed - (time.perf_counter() - began), 0.0))
            real = time.perf_counter() - began
            if int(real * _TICKS) > last:
                last = int(real * _TICKS)
                pace.ticks += 1
                if real - passed > sim.dt:
                    pace.late += 1
                    pace.worst = max(pace.worst, real - passed)

        stats = watched_run(sim, duration, False, adaptive, wait)
        pace.simulated += sim.time - start
        pace.real += time.perf_counter() - began
        return stats

    paced.append(pace)
    try:
        with replacing_run(run):
            yield pace
    finally:
        paced.remove(pace)
