"""Contexts in which the command runs a script: a duration, progress, real time."""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pathsim import Simulation

from .._core.callers import keep_warnings_visible
from .._core.checks import number, positive, refuse
from .._core.pathsim_internals import ON
from .._core.progress import progress_bar
from .._core.running import watched_run
from .._core.wiring import warn_of_wiring
from ..scripts.runs import RunStart, intercepted_runs, replaced_runs

# Hz, rate at which simulated and real time are compared
_TICKS = 30


def with_duration(duration: float | None) -> contextlib.AbstractContextManager[None]:
    """Context that sets the duration of a script's only run, s; a second run is refused.

    None leaves the durations as they are.
    """
    if duration is None:
        return contextlib.nullcontext()
    seconds, runs = number("duration", positive("duration", duration)), itertools.count()

    def begin(run: RunStart) -> None:
        if next(runs):
            why = f"it is not clear which run should last {seconds:g} s"
            refuse("duration", duration, f"the script runs more than once: {why}")
        run.arguments["duration"] = seconds

    return intercepted_runs(begin)


def with_progress() -> contextlib.AbstractContextManager[None]:
    """Context in which ``Simulation.run`` makes the checks of `fly` and shows progress.

    It refuses a step that is not positive, and warns about unconnected ports.
    """

    def around(
        usual: Callable[..., Any], sim: Simulation, name: str, values: dict[str, Any]
    ) -> Any:
        keep_warnings_visible()
        if sim.dt is not None:
            number("dt", positive("dt", sim.dt))
        warn_of_wiring(sim)
        # a simulation that logs shows its progress itself
        return (usual if name == "fly" or sim.log else watched_run)(sim, **values)

    return replaced_runs(around)


@dataclass
class Pace:
    """How well runs have kept up with the clock."""

    simulated: float = 0.0  # s of simulated time
    real: float = 0.0  # s of real time
    worst: float = 0.0  # s, maximum delay of a diagram

    def __str__(self) -> str:
        return (
            f"real time: {self.simulated:.1f} s flown in {self.real:.1f} s, late by "
            f"{1000 * self.worst:.0f} ms at most"
        )


@contextlib.contextmanager
def in_real_time() -> Iterator[Pace]:
    """Context in which ``Simulation.run`` and `fly` are PathSim's ``run_realtime``."""
    pace = Pace()

    def around(_: Any, sim: Simulation, name: str, values: dict[str, Any]) -> dict[str, Any]:
        if values["reset"]:
            # `run_realtime` would read its start time before resetting
            sim.reset()
        # unlike `run`, it does not restart a simulation that was stopped
        setattr(sim, ON, True)
        duration, began, start = values["duration"], time.perf_counter(), sim.time
        adaptive = values.get("adaptive", True)
        with progress_bar(duration) as bar:
            for _ in sim.run_realtime(duration, adaptive=adaptive, tickrate=_TICKS):
                elapsed = sim.time - start
                delay = min(time.perf_counter() - began, duration) - elapsed
                pace.worst = max(pace.worst, delay)
                bar.update(elapsed - bar.n)
        flown, real = sim.time - start, time.perf_counter() - began
        pace.simulated += flown
        pace.real += real
        steps = round(flown / sim.dt)
        return {"total_steps": steps, "successful_steps": steps, "runtime_ms": 1000 * real}

    with replaced_runs(around):
        yield pace
