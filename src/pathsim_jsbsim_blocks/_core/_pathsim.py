"""All uses of PathSim's internals, in one place.

`tests/core/test_pathsim_seam.py` has a test for each name here, which shows what a new version of
PathSim has changed.
"""

from __future__ import annotations

import functools
import logging
import math
import warnings
from collections.abc import Generator, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from pathsim import Simulation, Subsystem
from pathsim.events import Event
from pathsim.solvers._solver import Solver
from pathsim.utils.logger import LoggerManager
from pathsim.utils.progresstracker import ProgressTracker
from pathsim.utils.register import Register


def values(register: Register) -> list[float]:
    """The values in a block's inputs or outputs."""
    return register._data.tolist()


def show(register: Register, y: Sequence[float]) -> None:
    """Put values into the first ports."""
    register._data[: len(y)] = y


def port_names(register: Register) -> dict[str, int]:
    """Name and number of each named port."""
    return register._mapping


def port_number(register: Register, port: str | int) -> int:
    """Number of a port that is given by name or number."""
    return register._map(port)


def own_events(subsystem: Subsystem) -> list[Event]:
    """Events of a subsystem itself, without those of the blocks inside."""
    return subsystem._events


class WiredRegister(Register):
    """Inputs that record which ports are connected: PathSim looks up their numbers."""

    __slots__ = ["wired"]

    def __init__(self, size: int | None = None, mapping: dict[str, int] | None = None):
        super().__init__(size, mapping)
        self.wired: set[int] = set()

    def _map(self, key: Any) -> Any:
        port = super()._map(key)
        self.wired.add(port)
        return port


# PathSim counts the stages of a step from 0
_BEFORE_STAGES = -1


def step_begins(engine: Solver) -> None:
    """Mark the start of a step in the engine of the simulation."""
    engine._stage = _BEFORE_STAGES


def without_stages(engine: Solver) -> bool:
    """Whether no solver stage was evaluated since the start of the step.

    A diagram without continuous states has none: its first evaluation in a step is that of the
    step's end. (The buffers of implicit solvers start counting at once; the answer is no then.)
    """
    return engine._stage == _BEFORE_STAGES


class ClockEvent(Event):
    """Event of a sampled block, which marks when values are still propagating to it."""

    def __init__(self) -> None:
        super().__init__()
        self.settling = False
        # inside a subsystem
        self.nested = False


class Settling(Event):
    """One more pass through the graph after a block in a subsystem has acted.

    A subsystem without direct feed-through is evaluated before its surroundings, so what enters it
    needs another pass to reach the blocks inside. It is resolved last, so that changes by other
    events at that time reach them too.
    """

    def __init__(self) -> None:
        super().__init__()
        self.clocks: list[ClockEvent] = []

    def detect(self, t: float) -> tuple[bool, bool, float]:
        settling = any(clock.settling and bool(clock) for clock in self.clocks)
        return settling, settling, math.inf

    def resolve(self, t: float) -> None:
        """No action; resolving any event triggers the graph pass we need."""


_events_of_blocks = Subsystem.events.fget
_settling: WeakKeyDictionary[Subsystem, Settling] = WeakKeyDictionary()


def _events(subsystem: Subsystem) -> list[Event]:
    """Events of the blocks inside and, where blocks sample there, the pass that they need.

    The simulation collects events recursively through its subsystems. This is the only call that
    sees a subsystem together with the blocks at any depth in it, so this function replaces
    `Subsystem.events`. Subsystems without sampled blocks are not affected.
    """
    events = _events_of_blocks(subsystem)
    clocks = [event for event in events if isinstance(event, ClockEvent)]
    if clocks:
        for clock in clocks:
            clock.nested = True
        settling = _settling.setdefault(subsystem, Settling())
        settling.clocks = clocks
        events.append(settling)
    return events


Subsystem.events = property(_events, doc=Subsystem.events.__doc__)


def tracker(sim: Simulation, duration: float) -> ProgressTracker:
    """The tracker with which `Simulation.run` logs progress and counts steps."""
    return ProgressTracker(duration, "TRANSIENT", logger=sim.logger, log=sim.log)


def run_loop(
    sim: Simulation, duration: float, reset: bool, adaptive: bool, progress: ProgressTracker
) -> Generator[dict[str, Any], None, None]:
    """The loop of `Simulation.run`, which yields after every step."""
    return sim._run_loop(duration, reset, adaptive, tracker=progress)


def is_running(sim: Simulation) -> bool:
    """Whether the run is still active: `Simulation.stop` has not been called."""
    return sim._active


def keep_warnings_visible() -> None:
    """Stop PathSim from redirecting Python's warnings.

    The first `Simulation` redirects all warnings into `logging`, where no handler shows them.
    """
    redirect = getattr(LoggerManager, "_setup_root_logger", None)
    if redirect is None or hasattr(redirect, "__wrapped__"):
        return
    if LoggerManager._initialized and _lost():
        logging.captureWarnings(False)

    @functools.wraps(redirect)
    def without_redirection(self: LoggerManager) -> None:
        shown = warnings.showwarning
        redirect(self)
        if warnings.showwarning is not shown:
            logging.captureWarnings(False)

    LoggerManager._setup_root_logger = without_redirection


def _lost() -> bool:
    """Whether warnings are redirected to `logging` and no handler shows them."""
    loggers = (logging.Logger.manager.loggerDict.get("py.warnings"), logging.root)
    return warnings.showwarning.__module__ == logging.__name__ and all(
        isinstance(handler, logging.NullHandler)
        for logger in loggers
        for handler in getattr(logger, "handlers", ())
    )
