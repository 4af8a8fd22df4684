"""`fly`: run a diagram as `Simulation.run` does, at less cost per step."""

from __future__ import annotations

import math
import threading
from typing import Any

from pathsim import Connection, Simulation, StopSimulation
from pathsim.blocks import Block
from pathsim.events import Schedule

from . import pathsim_internals
from .checks import must_be, number, positive
from .clock import SampleClock
from .progress import progress_bar
from .wiring import warn_of_wiring

# relative; a step count this close to a whole number is rounded to it
_ROUNDING = 1e-9

# steps between two updates of the progress bar
_AT_ONCE = 100

# ``fly``: a function called instead of `fly` in this thread, with `fly` and its arguments
in_place = threading.local()


def fly(
    sim: Simulation, duration: float = 10.0, reset: bool = False, progress: bool | None = None
) -> dict[str, Any]:
    """Run a diagram as ``sim.run(duration, reset)`` does, in less time.

    The trajectory is the same, bit for bit. Fixed steps are counted: 3600 s at 120 Hz are 432,000
    steps, whereas rounding makes ``run`` take one more. If a diagram has no continuous states, no
    algebraic loops and no events besides scheduled ones, a step is one loop over the sampled
    blocks, the levels of the graph and the recorders; other steps are PathSim's own. That loop
    evaluates each block once per step, ``run`` twice: functions can count the difference.

    Parameters
    ----------
    sim : pathsim.Simulation
        the diagram
    duration : float
        simulated time to run for, s
    reset : bool
        start again from the initial state
    progress : bool, optional
        show a progress bar on stderr, with simulated time, real time and their ratio; by default
        after 2 s if stderr is a terminal

    Returns
    -------
    dict
        as from ``run``: "total_steps", "successful_steps", "runtime_ms"

    Warns
    -----
    RuntimeWarning
        for probable mistakes in the connections

    Raises
    ------
    ParameterError
        if the duration or the step is not positive and finite, or ``sim`` is not a simulation
    """
    if not isinstance(sim, Simulation):
        must_be("sim", sim, "a Simulation")
    duration = number("duration", positive("duration", duration))
    if sim.dt is not None:
        number("dt", positive("dt", sim.dt))
    call = getattr(in_place, "fly", None)
    if call is not None:
        return call(_fly, sim, duration=duration, reset=reset, progress=progress)
    return _fly(sim, duration, reset, progress)


def _fly(sim: Simulation, duration: float, reset: bool, progress: bool | None) -> dict[str, Any]:
    start = 0.0 if reset else sim.time
    tracker = pathsim_internals.tracker(sim, duration)
    with tracker, progress_bar(duration, progress) as bar:
        adaptive = sim.engine.is_adaptive
        loop = pathsim_internals.run_loop(sim, duration, reset, adaptive, tracker)
        for step in loop:
            warn_of_wiring(sim)
            bar.update(sim.time - start - bar.n)
            if not adaptive:
                # PathSim's loop has done the start and the first step; its dt is the run's step,
                # even if sim.dt has changed since
                loop.close()
                dt, stats = step["dt"], tracker.stats
                remainder = math.ceil(duration / dt * (1 - _ROUNDING)) - 1
                steps = Steps(sim, dt)
                while remainder and sim:
                    # PathSim logs the progress of each step
                    count = steps.make(1 if sim.log else min(remainder, _AT_ONCE))
                    remainder -= count
                    if sim.log and count:
                        tracker.update((sim.time - start) / duration)
                    else:
                        stats["total_steps"] += count
                        stats["successful_steps"] += count
                    bar.update(sim.time - start - bar.n)
        if not sim:
            tracker.interrupt()
    return tracker.stats


def watched_run(
    sim: Simulation, duration: float = 10.0, reset: bool = False, adaptive: bool = True
) -> dict[str, Any]:
    """``Simulation.run`` with a progress bar."""
    start = 0.0 if reset else sim.time
    tracker = pathsim_internals.tracker(sim, duration)
    with tracker, progress_bar(duration) as bar:
        for _ in pathsim_internals.run_loop(sim, duration, reset, adaptive, tracker):
            bar.update(sim.time - start - bar.n)
    return tracker.stats


class Steps:
    """Fixed steps of a simulation, with the results of `Simulation.timestep`."""

    def __init__(self, sim: Simulation, dt: float):
        self._sim, self._dt = sim, dt
        self._look()

    def make(self, count: int) -> int:
        """Make ``count`` steps; return the number made before the simulation was stopped."""
        sim, steps = self._sim, 0
        try:
            while steps < count and sim:
                if sim.graph is self._graph and self._flat:
                    steps += self._make_flat(count - steps)
                    if steps == count or not sim:
                        break
                sim.timestep(self._dt, adaptive=False)
                steps += 1
                if sim.graph is not self._graph:
                    self._look()
        except StopSimulation as stop:
            sim.logger.info(f"STOP (StopSimulation: '{stop}')")
            sim.stop()
        return steps

    def show(self) -> None:
        """Update outputs and recordings after values have been edited."""
        current = self._sim.graph is self._graph and not pathsim_internals.is_dirty(self._sim)
        pathsim_internals.show_edited(self._sim, self._dt, self._levels if current else [])

    def _look(self) -> None:
        """Read the order of blocks and connections from the simulation's graph."""
        sim = self._sim
        self._graph = sim.graph
        clocks = [(b, getattr(b, "clock", None)) for b in sim.blocks]
        self._sampled = [(b, clock) for b, clock in clocks if isinstance(clock, SampleClock)]
        unclocked = [b for b, clock in clocks if not isinstance(clock, SampleClock)]
        self._eventful = [b for b in unclocked if b.events]
        self._recorders = [
            b for b in sim.blocks if getattr(b.sample, "__func__", None) is not Block.sample
        ]
        self._flat = (
            type(sim) is Simulation
            and not sim.graph.has_loops
            and sim.engine.is_explicit
            and not any(b.engine for b in sim.blocks)
            and not any(isinstance(e, SampleClock) for b in self._eventful for e in b.events)
            and all(type(wire) is Connection for wire in sim.connections)
        )
        self._levels = pathsim_internals.levels(sim) if self._flat else []

    def _make_flat(self, count: int) -> int:
        """Make steps until one needs PathSim's own loop; return the number made."""
        sim, dt, graph, steps = self._sim, self._dt, self._graph, 0
        evaluate, sample = pathsim_internals.evaluate, pathsim_internals.sample
        is_dirty = pathsim_internals.is_dirty
        eventful, levels, recorders = self._eventful, self._levels, self._recorders
        clocks = self._sampled
        while steps < count and sim and sim.graph is graph and not is_dirty(sim):
            t = sim.time + dt
            if sim.diagnostics is not None:
                break
            if (eventful or sim.events) and self._other_due(sim.time):
                break
            for block, clock in clocks:
                if t >= clock.due and block:
                    clock.buffer(sim.time)
                    if t > clock.end:
                        clock.end = t
            evaluate(levels, t)
            sample(recorders, t, dt)
            sim.time = t
            steps += 1
        return steps

    def _other_due(self, t: float) -> bool:
        """Whether an event may occur in the step from ``t``, or must be monitored."""
        until = self._dt + 1e-6 * self._dt + 1e-9 * abs(t)
        return any(
            event and not (isinstance(event, Schedule) and event.estimate(t) > until)
            for events in (self._sim.events, *(block.events for block in self._eventful))
            for event in events
        )


class SteppedRun:
    """A run from the initial state in several parts, between which values may be edited.

    Each part equals ``sim.run(count * sim.dt)`` bit for bit. The simulation, which needs a fixed
    step, is reset.
    """

    def __init__(self, sim: Simulation):
        self._sim, self._dt = sim, number("dt", positive("dt", sim.dt))
        sim.reset()
        self._steps = Steps(sim, self._dt)
        self.show = self._steps.show

    def run(self, count: int) -> bool:
        """Make ``count`` steps; return whether the diagram is still active."""
        try:
            self.show()
        except StopSimulation:
            self._sim.stop()
        self._steps.make(count)
        return bool(self._sim)
