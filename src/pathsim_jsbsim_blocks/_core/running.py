"""`fly`: run a diagram as `Simulation.run` does, at less cost per step."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pathsim import Simulation, StopSimulation

from . import pathsim_internals
from .checks import must_be, number, positive
from .progress import progress_bar

if TYPE_CHECKING:
    from tqdm import tqdm

# relative; a step count this close to a whole number is rounded to it
_ROUNDING = 1e-9

# ``fly``: what is called in place of `fly` in this thread, with it and its arguments
in_place = threading.local()


def fly(
    sim: Simulation, duration: float = 10.0, reset: bool = False, progress: bool | None = None
) -> dict[str, Any]:
    """Run a diagram as ``sim.run(duration, reset)`` does, in less time.

    The trajectory is the same, bit for bit. Fixed steps are counted: 3600 s at 120 Hz are 432,000
    steps, and rounding makes ``run`` take one more. Most is saved in a diagram without continuous
    states and algebraic loops, where the order of blocks and connections is worked out once and not
    at every step. With an adaptive solver this is PathSim's own loop.

    Parameters
    ----------
    sim : pathsim.Simulation
        the diagram
    duration : float
        simulated time to run for, s
    reset : bool
        start again from the initial state
    progress : bool, optional
        show a progress bar on stderr, with simulated time, real time and their ratio; default is
        after 2 s where stderr is a terminal

    Returns
    -------
    dict
        what ``run`` returns: "total_steps", "successful_steps", "runtime_ms"

    Raises
    ------
    ParameterError
        if the duration or the step is not positive and finite, or ``sim`` is no simulation
    """
    if not isinstance(sim, Simulation):
        must_be("sim", sim, "a Simulation")
    duration = number("duration", positive("duration", duration))
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
        for made in loop:
            bar.update(sim.time - start - bar.n)
            if not adaptive:
                # PathSim's loop has made the start and the first step, with the step of the run:
                # sim.dt may be another one since
                dt = made["dt"]
                loop.close()
                count = math.ceil(duration / dt * (1 - _ROUNDING)) - 1
                _fixed_steps(loop, sim, dt, count, start, duration, tracker, bar)
    return tracker.stats


class Pieces:
    """A run from the initial state, made in pieces; in between, values may be edited.

    Each piece is what ``sim.run(count * sim.dt)`` makes, bit for bit, without the checks with which
    a run begins. The simulation, with a fixed step, is reset.
    """

    def __init__(self, sim: Simulation):
        self._sim, self._dt = sim, number("dt", positive("dt", sim.dt))
        self._steps = pathsim_internals.run_loop(
            sim, sim.dt, True, False, pathsim_internals.tracker(sim, sim.dt)
        )
        self._steps.close()
        sim.reset()
        self._step = pathsim_internals.fixed_step(sim, self._dt)

    def show(self) -> None:
        """Show what follows from the values as they are now."""
        with self._steps:
            self._steps.go_on()
            pathsim_internals.show_edited(self._sim, self._dt)

    def run(self, count: int) -> bool:
        """Make a piece of ``count`` steps, and tell whether nothing has stopped the diagram."""
        sim, steps, step = self._sim, self._steps, self._step
        try:
            with steps:
                steps.go_on()
                pathsim_internals.show_edited(sim, self._dt)
                for _ in range(count):
                    if not steps.go_on():
                        break
                    step()
        except StopSimulation:
            sim.stop()
        return pathsim_internals.is_running(sim)


def watched_run(
    sim: Simulation,
    duration: float,
    reset: bool,
    adaptive: bool,
    after: Callable[[float], object] = lambda passed: None,
) -> dict[str, Any]:
    """``Simulation.run`` with a progress bar; ``after`` each step gets the simulated time in s."""
    start = 0.0 if reset else sim.time
    tracker = pathsim_internals.tracker(sim, duration)
    with tracker, progress_bar(duration) as bar:
        for _ in pathsim_internals.run_loop(sim, duration, reset, adaptive, tracker):
            bar.update(sim.time - start - bar.n)
            after(sim.time - start)
    return tracker.stats


def _fixed_steps(
    steps: pathsim_internals.Steps,
    sim: Simulation,
    dt: float,
    count: int,
    start: float,
    duration: float,
    tracker: Any,
    bar: tqdm,
) -> None:
    step, shown = pathsim_internals.fixed_step(sim, dt), not bar.disable
    update = tracker.update if sim.log else functools.partial(_count, tracker.stats)
    try:
        with steps:
            for _ in range(count):
                if not steps.go_on():
                    break
                success = step()
                passed = sim.time - start
                update(passed / duration, success)
                if shown:
                    bar.update(passed - bar.n)
    except StopSimulation as stop:
        sim.logger.info(f"STOP (StopSimulation: '{stop}')")
        sim.stop()
    if not pathsim_internals.is_running(sim):
        tracker.interrupt()


def _count(stats: dict[str, Any], progress: float, success: bool) -> None:
    """What remains of the tracker's update where nothing is logged."""
    stats["total_steps"] += 1
    stats["successful_steps"] += success
