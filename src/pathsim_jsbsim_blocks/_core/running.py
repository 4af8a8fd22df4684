"""`fly`: run a diagram as `Simulation.run` does, at less cost per step."""

from __future__ import annotations

import functools
import math
import sys
from typing import TYPE_CHECKING, Any

from pathsim import Simulation, StopSimulation

from . import _pathsim
from .checks import number, positive
from .realtime import is_real_time

if TYPE_CHECKING:
    from tqdm import tqdm

# relative; a step count this close to a whole number is rounded to it
_ROUNDING = 1e-9
_BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} s in {elapsed}, {rate_noinv_fmt}"
_SECONDS_BEFORE_BAR = 2.0


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
        if the duration is not positive and finite
    """
    duration = number("duration", positive("duration", duration))
    if is_real_time():
        return sim.run(duration, reset)
    start = 0.0 if reset else sim.time
    tracker = _pathsim.tracker(sim, duration)
    with (
        tracker,
        _bar_class()(
            total=duration,
            unit=" s",
            bar_format=_BAR,
            leave=False,
            delay=0.0 if progress else _SECONDS_BEFORE_BAR,
            # without a console (pythonw) there is no stderr
            disable=sys.stderr is None or (None if progress is None else not progress),
        ) as bar,
    ):
        adaptive = sim.engine.is_adaptive
        loop = _pathsim.run_loop(sim, duration, reset, adaptive, tracker)
        for made in loop:
            bar.update(sim.time - start - bar.n)
            if not adaptive:
                # PathSim's loop has made the start and the first step, with the step of the run:
                # sim.dt may be another one since
                dt = made["dt"]
                loop.close()
                _steps(sim, dt, _whole(duration / dt) - 1, start, duration, tracker, bar)
    return tracker.stats


@functools.cache
def _bar_class() -> type[tqdm]:
    from tqdm import tqdm

    class Bar(tqdm):
        # tqdm starts a thread that watches its bars. If Ctrl-C leaves tqdm's lock held, that thread
        # blocks, and the process cannot end
        monitor_interval = 0

    return Bar


def _whole(steps: float) -> int:
    """Number of steps that reach a duration."""
    return math.ceil(steps * (1 - _ROUNDING))


def _steps(
    sim: Simulation, dt: float, count: int, start: float, duration: float, tracker: Any, bar: tqdm
) -> None:
    step, shown = _pathsim.fixed_step(sim, dt), not bar.disable
    update = tracker.update if sim.log else functools.partial(_count, tracker.stats)
    try:
        for _ in range(count):
            if not _pathsim.is_running(sim):
                break
            success = step()
            passed = sim.time - start
            update(passed / duration, success)
            if shown:
                bar.update(passed - bar.n)
    except StopSimulation as stop:
        sim.logger.info(f"STOP (StopSimulation: '{stop}')")
        sim.stop()
    if not _pathsim.is_running(sim):
        tracker.interrupt()


def _count(stats: dict[str, Any], progress: float, success: bool) -> None:
    """What remains of the tracker's update where nothing is logged."""
    stats["total_steps"] += 1
    stats["successful_steps"] += success
