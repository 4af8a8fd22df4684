"""Contexts in which the runs of a script are counted, changed, watched or kept in real time.

They replace public methods of ``Simulation`` that start or step a run, only for calls of the thread
that entered the context, and restore them at its end; `fly` looks into `running.in_place`. No other
part of the package replaces anything in PathSim.
"""

from __future__ import annotations

import contextlib
import functools
import inspect
import itertools
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pathsim import Simulation

from .._core.callers import keep_warnings_visible
from .._core.checks import number, positive, refuse
from .._core.pathsim_internals import ON
from .._core.progress import progress_bar
from .._core.running import in_place, watched_run
from .._core.wiring import warn_of_wiring

# called with the original method, the simulation, the method's name or "fly", and the arguments
Around = Callable[[Callable[..., Any], Simulation, str, dict[str, Any]], Any]

# Hz, rate at which simulated and real time are compared
_TICKS = 30


@dataclass
class _Layer:
    """A context of one thread."""

    around: Around
    methods: tuple[str, ...]


_layers: dict[int, list[_Layer]] = {}  # by thread, outermost first
_usual: dict[str, Callable[..., Any]] = {}  # the methods that are replaced
_running = threading.local()
_lock = threading.Lock()


@contextlib.contextmanager
def replaced_runs(around: Around, *methods: str) -> Iterator[None]:
    """Context in which ``around`` is called for each ``Simulation.run`` and `fly`.

    ``methods`` are further ones of ``Simulation``; calls of one by another do not count.
    """
    thread, layer = threading.get_ident(), _Layer(around, ("fly", "run", *methods))
    outer = getattr(in_place, "fly", None)
    with _lock:
        _layers.setdefault(thread, []).append(layer)
        _put_in_place()
    in_place.fly = _flight
    try:
        yield
    finally:
        in_place.fly = outer
        with _lock:
            _layers[thread].remove(layer)
            _put_in_place()


def _put_in_place() -> None:
    """Replace the methods that a context of any thread needs, and put back the others."""
    needed = {m for layers in _layers.values() for layer in layers for m in layer.methods}
    for name in needed - {"fly"} - _usual.keys():
        _usual[name] = getattr(Simulation, name)
        setattr(Simulation, name, _replacing(name, _usual[name]))
    for name in _usual.keys() - needed:
        setattr(Simulation, name, _usual.pop(name))


def _replacing(name: str, usual: Callable[..., Any]) -> Callable[..., Any]:
    signature = inspect.signature(usual)

    @functools.wraps(usual)
    def replaced(sim: Simulation, *args: Any, **kwargs: Any) -> Any:
        call = signature.bind(sim, *args, **kwargs)
        call.apply_defaults()
        return _through(name, usual, sim, dict([*call.arguments.items()][1:]))

    return replaced


def _flight(fly: Callable[..., Any], sim: Simulation, **arguments: Any) -> Any:
    return _through("fly", fly, sim, arguments)


def _through(
    name: str, usual: Callable[..., Any], sim: Simulation, values: dict[str, Any], depth: int = 0
) -> Any:
    """Call a method through the contexts of this thread, the innermost first."""
    running = vars(_running).setdefault("simulations", [])
    layers = [x for x in _layers.get(threading.get_ident(), ())[::-1] if name in x.methods]
    if sim in running or depth == len(layers):
        running.append(sim)
        try:
            return usual(sim, **values)
        finally:
            running.remove(sim)

    def further(sim: Simulation, **arguments: Any) -> Any:
        return _through(name, usual, sim, arguments, depth + 1)

    return layers[depth].around(further, sim, name, values)


@dataclass
class RunStart:
    """The start of a run: its simulation, the method's name or "fly", and the arguments."""

    simulation: Simulation
    method: str
    arguments: dict[str, Any]


def intercepted_runs(
    begin: Callable[[RunStart], None], *methods: str
) -> contextlib.AbstractContextManager[None]:
    """Context in which ``begin`` is called before each run; it may change arguments, or raise."""

    def around(
        usual: Callable[..., Any], sim: Simulation, name: str, values: dict[str, Any]
    ) -> Any:
        begin(RunStart(sim, name, values))
        return usual(sim, **values)

    return replaced_runs(around, *methods)


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
                passed = sim.time - start
                behind = min(time.perf_counter() - began, duration) - passed
                pace.worst = max(pace.worst, behind)
                bar.update(passed - bar.n)
        flown, real = sim.time - start, time.perf_counter() - began
        pace.simulated += flown
        pace.real += real
        steps = round(flown / sim.dt)
        return {"total_steps": steps, "successful_steps": steps, "runtime_ms": 1000 * real}

    with replaced_runs(around):
        yield pace
