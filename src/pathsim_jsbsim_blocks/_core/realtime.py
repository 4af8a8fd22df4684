"""Run diagrams at the pace of the clock, and count what comes late."""

from __future__ import annotations

import contextlib
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from pathsim import Simulation

from .pathsim_internals import Run, activate, replacing_run, run_in_real_time
from .progress import progress_bar


@dataclass
class Pace:
    """How well runs have kept up with the clock.

    Attributes
    ----------
    simulated, real : float
        duration in the diagrams and on the clock, s
    ticks, late : int
        how often the two were compared, and how often the diagram was behind by more than a step
    worst : float
        the most that it was behind, s
    """

    simulated: float = 0.0
    real: float = 0.0
    ticks: int = 0
    late: int = 0
    worst: float = 0.0

    def __str__(self) -> str:
        return (
            f"real time: {self.simulated:.1f} s flown in {self.real:.1f} s, late at {self.late} of "
            f"{self.ticks} ticks, by {1000 * self.worst:.0f} ms at most"
        )


_paces: list[Pace] = []


def is_real_time() -> bool:
    """Whether runs keep the pace of the clock now."""
    return bool(_paces)


@contextlib.contextmanager
def in_real_time() -> Iterator[Pace]:
    """Context in which ``Simulation.run`` and `fly` run by PathSim's ``run_realtime``.

    Yields
    ------
    Pace
        of all runs in the context
    """
    pace = Pace()
    _paces.append(pace)

    def run(
        usual: Run, sim: Simulation, duration: float, reset: bool, adaptive: bool
    ) -> dict[str, Any]:
        # before run_realtime: it takes the time and whether the run is active from before its reset
        if reset:
            sim.reset()
        activate(sim)
        began, start = time.perf_counter(), sim.time

        def tick() -> None:
            bar.update(sim.time - start - bar.n)
            pace.ticks += 1
            behind = time.perf_counter() - began - (sim.time - start)
            # after the last step the clock goes on
            if behind > sim.dt and sim.time - start < duration:
                pace.late += 1
                pace.worst = max(pace.worst, behind)

        with progress_bar(duration) as bar:
            stats = run_in_real_time(sim, duration, adaptive, tick)
        real = time.perf_counter() - began
        pace.simulated += sim.time - start
        pace.real += real
        return stats

    try:
        with replacing_run(run):
            yield pace
    finally:
        _paces.remove(pace)
