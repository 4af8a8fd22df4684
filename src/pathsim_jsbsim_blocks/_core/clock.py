"""The clock of a sampled block: when it acts, on PathSim's own events.

The order of PathSim's calls, and what a block does at an instant, are described in `sampling`.

A solver's stage at t_k belongs to the period before. So a block acts from its tick, an event, to
``sample``. A step without stages has one evaluation, at its end, so blocks act from its start: this
saves an evaluation per block, and a ZeroCrossing detects the change. This is not done with an
adaptive solver, whose search for a crossing would not converge at a jump.

The results of a step at t_k (`SampleClock.ahead`) are stored beside those before t_k (``now``)
until PathSim starts a step or a run at t_k or later. If one starts earlier, the step to t_k was not
completed, and is repeated from ``now``.

A signal into a subsystem reaches the blocks inside one evaluation late per level of subsystems.
`Settling` requests these further evaluations, after all ticks.
"""

from __future__ import annotations

import math
import sys
from enum import Enum, auto
from typing import Any
from weakref import WeakKeyDictionary

from pathsim.events import Event, Schedule

from .callers import calling_simulation
from .checks import number, positive, refuse
from .pathsim_internals import begin_stepping
from .wiring import name_of, warn_of_wiring

# s; catches typos such as T=1e-9
SHORTEST_PERIOD = 1e-6

# PathSim resolves the events of a step by their relative time in it; with this one, other events
# at the same time follow the tick
_BEFORE_OTHERS = math.nextafter(1.0, 0.0)

_NOT_DETECTED = False, False, 1.0


def sample_period(T: Any) -> float:
    return number("T", positive("T", T), low=SHORTEST_PERIOD)


class Settling(Event):
    """Further evaluations after the ticks of a step, for the blocks in subsystems.

    One per simulation; a block lists it among its events once per enclosing subsystem. The
    evaluation before PathSim detects events clears both counts, so an interrupt leaves no trace.

    Attributes
    ----------
    depth, asked : int
        evaluations that the blocks need, and those requested already
    """

    depth = asked = 0

    def detect(self, t: float) -> tuple[bool, bool, float]:
        asks = self.asked < self.depth
        self.asked += asks
        return asks, asks, math.inf

    def resolve(self, t: float) -> None:
        """An evaluation follows every event."""

    def off(self) -> None:
        """No action: the other blocks still need it."""


# by the engine of the simulation, which PathSim gives to each of its blocks
settlings: WeakKeyDictionary[Any, Settling] = WeakKeyDictionary()


class Phase(Enum):
    """What an evaluation of a block means, between two of PathSim's calls.

    =========  ==========================================  ======================================
    phase      the block                                   becomes
    =========  ==========================================  ======================================
    IDLE       is in no run, and ignores ``sample``        BETWEEN as a run begins (``detect``)
    BETWEEN    waits for a step                            START at a run's first tick
                                                           (``resolve``), STEP at ``buffer``
    START      acts, at the first instant of a run         BETWEEN at ``sample``
    STEP       is in the period before the next instant    INSTANT at the tick
    INSTANT    acts, at an instant that ends the period    BETWEEN at ``sample``, STEP at the first
                                                           stage, if the step has stages after all
    =========  ==========================================  ======================================

    A step without stages begins in INSTANT. A rejected or interrupted step begins again at
    ``buffer``, an interrupted run at ``detect``, from any phase. `SampleClock.leave` leads to IDLE.
    """

    IDLE = auto()
    BETWEEN = auto()
    START = auto()
    STEP = auto()
    INSTANT = auto()


# module constants: the members are compared several times per step
IDLE, BETWEEN, START, STEP, INSTANT = Phase


class SampleClock(Schedule):
    """The instants of a block, counted by an integer, and the results at them.

    Attributes
    ----------
    start, period : float
        time of instant 0 and T, s
    now : tuple
        values before the next instant: its index, the outputs, and the held inputs of a
        `SampledPlant` or the state of a `SampledLaw`. One assignment, which no interrupt can split
    ahead : tuple or None
        likewise for the next instant, if its tick was resolved but ``sample`` has not run
    due, end, slack : float
        evaluations from ``due`` to ``end`` count as the next instant, s; tolerance for the rounding
        of the diagram's time, a sum of steps, s
    reached : float
        time at which the block was last sampled, or from which a step starts, s; -inf before
    phase, first_phase : Phase
        present phase, and that in which a step starts
    depth : int
        number of subsystems around the block
    begun : tuple
        index of the period that an aircraft has begun to fly, and its ground contact at the start
    """

    def __init__(self, block: Any):  # a `SampledBlock`
        super().__init__(t_period=block.T)
        # not in the block, where setting an attribute is slower: every step changes them
        self.block, self.depth, self.first_phase = block, 0, STEP
        self.settling: Any = None
        self.reset()

    def reset(self) -> None:
        super().reset()
        if not self.block:
            # `Block.off` resets the block after its events are off
            self.off()
        self.period = self.t_period = sample_period(self.block.T)
        self.start = 0.0
        self.begun: tuple[int, Any] = 0, None
        self._set((0, None, None))

    def _set(self, values: tuple[int, Any, Any]) -> None:
        """Continue from ``values``, at any time."""
        self.ahead: Any = None
        self.now = values
        self.leave()

    def _keep(self) -> None:
        """Make the last sample final and wait for the next instant."""
        if self.ahead and self.reached >= self.due:
            self.now, self.ahead = self.ahead, None
        time, most = self.start + self.now[0] * self.period, 0.01 * self.period
        slack = 1e-13 + 1e-9 * abs(time)
        self.slack = slack = slack if slack < most else most
        self.due, self.end = time - slack, time + slack

    def next(self) -> float:
        """Time of the next instant."""
        return self.start + self.now[0] * self.period

    def at_latest(self, t: float) -> bool:
        """Whether ``t`` is the latest instant."""
        return abs(t - self.next() + self.period) <= self.slack

    @property
    def latest(self) -> tuple[int, Any, Any]:
        """Values after the instant at which the block was last sampled."""
        return self.ahead if self.ahead and self.reached >= self.due else self.now

    def count(self, t: float) -> int:
        """Number of instants from the next one to ``t``."""
        return 1 + int((t - self.due) / self.period)

    def leave(self) -> None:
        """Called when the block is added to a simulation, at any time."""
        self._keep()
        self.reached, self.phase = -math.inf, IDLE

    def join(self, t: float) -> None:
        """Make samples up to ``t`` final.

        The block restarts its count at ``t`` if that does not follow its last instant: its flight
        begins, it was switched off for a while, or it comes from another simulation.
        """
        if t >= self.due:
            self._keep()
        if not (self.due - 1.01 * self.period <= t < self.due and self.now[0]):
            self._keep()
            self.start = t - max(self.now[0] - 1, 0) * self.period
            self._keep()

    def buffer(self, t: float) -> None:
        """A step starts at ``t``."""
        if t > self.reached:
            self._begin(t)
        self.join(t)
        self.reached, self.phase = t, self.first_phase

    def _begin(self, t: float) -> None:
        """Sample at ``t``, the start of a step that belongs to no run."""
        block = self.block
        if self.reached == -math.inf:
            if not block._engine.history:
                begin_stepping(calling_simulation(block._engine))
            else:
                # the block was switched on, or added to the diagram, during a run
                self.join(t)
                self.phase = START
                block.update(t)
                block.sample(t, 0.0)
        if t > self.reached:
            why = f"{name_of(block)} was not sampled at {t:.9g} s, where the diagram continues: "
            refuse("pss", t, f"{why}Simulation.pss cannot fly a {type(block).__name__}")

    def estimate(self, t: float) -> float:
        self.join(t)
        return self.next() - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        begins = not (self.phase in (STEP, INSTANT) and self.reached < t)
        if begins:
            # a run begins, maybe after one that ended within a step
            self.join(t)
            self.phase = BETWEEN
            if (sim := calling_simulation(self.block._engine)) is not None:
                warn_of_wiring(sim)
            self.block._run_begins()
        due = t >= self.due
        if self.depth and (due or (begins and self.at_latest(t))):
            self.settling.depth = max(self.settling.depth, self.depth)
        if not due or (self.phase is INSTANT and t <= self.end):
            return _NOT_DETECTED
        time, self.end = self.next(), max(t, self.end)
        if t <= time + self.slack:
            return True, True, _BEFORE_OTHERS
        return True, False, (time - self.reached) / (t - self.reached)

    def resolve(self, t: float) -> None:
        self.phase = INSTANT if self.phase in (STEP, INSTANT) else START

    def to_checkpoint(self, prefix: str) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix)
        values = [_plain(part) for part in self.latest]
        json_data.update(period=self.period, start=self.start, now=values)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        period, kind = json_data["period"], type(self.block).__name__
        if period != self.period:
            why = f"the checkpoint is of a {kind} with T = {period!r}, but this one has T = "
            refuse("T", self.period, f"{why}{self.period!r}")
        super().load_checkpoint(prefix, json_data, npz)
        self.start = json_data["start"]
        self._set(tuple(_rebuilt(part) for part in json_data["now"]))  # type: ignore[arg-type]


def _plain(value: Any) -> Any:
    """A state for JSON: a tuple as a list, with the name of its class first."""
    if not isinstance(value, tuple):
        return value
    kind = type(value)
    return {"tuple": [kind.__module__, kind.__qualname__], "of": [_plain(part) for part in value]}


def _rebuilt(value: Any) -> Any:
    if not isinstance(value, dict):
        return value
    module, name = value["tuple"]
    kind, parts = getattr(sys.modules.get(module), name, None), map(_rebuilt, value["of"])
    if kind is tuple:
        return tuple(parts)
    if not (isinstance(kind, type) and issubclass(kind, tuple)):
        why = f"the checkpoint is of another version: {module} has no state {name}"
        refuse("checkpoint", name, why)
    return kind(*parts)
