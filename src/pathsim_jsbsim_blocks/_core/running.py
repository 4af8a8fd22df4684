"""`fly`: run a diagram as `Simulation.run` does, at less cost per step."""

from __future__ import annotations

import contextlib
import functools
import inspect
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any
from unittest.mock import patch

from pathsim import Simulation, StopSimulation

from . import pathsim_internals
from .checks import must_be, number, positive, refuse
from .pathsim_internals import Run
from .progress import progress_bar

if TYPE_CHECKING:
    from tqdm import tqdm

# relative; a step count this close to a whole number is rounded to it
_ROUNDING = 1e-9

# contexts in which ``Simulation.run`` keeps the pace of the clock, and `fly` is that method
paced: list[object] = []


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
    if paced:
        return sim.run(duration, reset)
    if _begin:
        run = Beginning(sim, "fly", {"duration": duration, "reset": reset})
        _begin[-1](run)
        duration = run.arguments["duration"]
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


def with_progress() -> contextlib.AbstractContextManager[Any]:
    """Context in which ``Simulation.run`` shows the progress bar of `fly`."""

    def run(
        usual: Run, sim: Simulation, duration: float, reset: bool, adaptive: bool
    ) -> dict[str, Any]:
        # where it logs, PathSim itself shows the progress
        return (usual if sim.log else watched_run)(sim, duration, reset, adaptive)

    return pathsim_internals.replacing_run(run)


@contextlib.contextmanager
def intercepted_runs(begin: Callable[[Beginning], None], *methods: str) -> Iterator[None]:
    """Context in which ``begin`` is called before each run: by `fly`, ``Simulation.run``, others.

    It may change the arguments of the run, or raise. ``methods`` are further ones of
    ``Simulation``; calls of one by another do not count.
    """
    running: list[Simulation] = []

    def intercepted(name: str) -> Callable[..., Any]:
        usual = getattr(Simulation, name)
        signature = inspect.signature(usual)

        @functools.wraps(usual)
        def method(sim: Simulation, *args: Any, **kwargs: Any) -> Any:
            if sim in running:
                return usual(sim, *args, **kwargs)
            call = signature.bind(sim, *args, **kwargs)
            call.apply_defaults()
            begin(Beginning(sim, name, call.arguments))
            running.append(sim)
            try:
                return usual(*call.args, **call.kwargs)
            finally:
                running.remove(sim)

        return method

    _begin.append(begin)
    try:
        with contextlib.ExitStack() as stack:
            for name in ("run", *methods):
                stack.enter_context(patch.object(Simulation, name, intercepted(name)))
            yield
    finally:
        _begin.remove(begin)


@dataclass
class Beginning:
    """A run that begins: of which simulation, by which method or `fly`, with which arguments."""

    simulation: Simulation
    method: str
    arguments: dict[str, Any]


_begin: list[Callable[[Beginning], None]] = []


@contextlib.contextmanager
def with_duration(duration: float | None) -> Iterator[Runs]:
    """Context in which the one run of a script, with ``Simulation.run`` or `fly`, has a duration.

    A second run is refused. With None, runs are counted only.
    """
    if duration is not None:
        duration = number("duration", positive("duration", duration))
    runs = Runs()

    def begin(run: Beginning) -> None:
        runs.begun += 1
        if duration is not None:
            if runs.begun > 1:
                why = f"which of its runs is to last {duration:g} s is not clear"
                refuse("duration", duration, f"the script runs more than once: {why}")
            run.arguments["duration"] = duration

    with intercepted_runs(begin):
        yield runs


@dataclass
class Runs:
    """How many runs have begun."""

    begun: int = 0


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
