"""The one mechanism by which blocks sample at a period T.

PathSim evaluates a diagram several times per step: at every solver stage, at the end of the
step, and again after every event. A sampled block must act on its sample instants
``t_k = start + k T`` only, and exactly once on each. Two kinds exist:

- `SampledPlant` reads its inputs at t_k, holds them over [t_k, t_k+1) and shows its new outputs
  at t_k+1 (no direct feed-through): the aircraft.
- `SampledLaw` computes its outputs at t_k from its inputs at t_k and holds them (direct
  feed-through at the sample instants): controllers.

Instants are counted by an integer, never by adding T. A plant acts once and for good. A law may
be evaluated several times at one instant, always from the state before that instant; the last
result is kept when the step is over, so the order of blocks and events does not matter.

In a step without solver stages the first evaluation of the graph is the one at the step's end, and
both kinds act there: one pass through the graph instead of two, and no event. Whether a step has
stages is known only to the `Simulation`; blocks inside a `Subsystem`, in adaptive runs and in
diagrams with continuous states act in the resolution of an event, which is always right.

A `Subsystem` without direct feed-through is evaluated before its surroundings, so what enters it
needs one more pass for each level to reach a block inside; `Settling` events ask for these.
"""

from __future__ import annotations

import math
import sys
import warnings
import weakref
from collections.abc import Callable
from typing import Any

from pathsim import Simulation, Subsystem
from pathsim.blocks import Block
from pathsim.events import Event

from ..errors import ParameterError
from .checkpoint import seal
from .checks import number, positive

# s; more samples than these nobody waits for
SHORTEST_PERIOD = 1e-6

# PathSim resolves the events of a step in the order of their place in it
BEFORE_OTHER_EVENTS = math.nextafter(1.0, 0.0)
AFTER_OTHER_EVENTS = math.inf


def _period(T: Any) -> float:
    return number("T", positive("T", T), low=SHORTEST_PERIOD)


class SampleClock(Event):
    """Event on the sample instants of one block, and the count of them.

    Parameters
    ----------
    block : SampledBlock
        the block that samples
    first : int
        index of the first instant at which the block acts
    """

    def __init__(self, block: SampledBlock, first: int):
        self._block = block
        self._first = first
        self.due_from = self.due_until = 0.0
        super().__init__()
        self.reset()

    def __bool__(self) -> bool:
        return self._active and self._block._active

    def reset(self) -> None:
        super().reset()
        self.period = _period(self._block.T)
        self.step_start = 0.0
        # between the start of a step and its end; a run begins outside of any step
        self.in_step = False
        # the graph's values at this time may still be on their way to the block
        self.settling = False
        self._detected_at = 0.0
        self.begin_at(0.0, self._first)

    def begin_at(self, t: float, index: int) -> None:
        """Let the sample before ``index`` be at ``t`` (the first, if there is none before)."""
        self.start = t - max(index - 1, 0) * self.period
        self.go_to(max(index - 1, 0))
        self.go_to(index)

    def go_to(self, index: int) -> None:
        """Wait for sample ``index``, the one after that waited for until now."""
        self.latest_from, self.latest_until = self.due_from, self.due_until
        self.index = index
        self.next = self.start + index * self.period
        # how far the diagram's accumulated clock may be from an instant
        slack = min(1e-13 + 1e-9 * self.next, 0.01 * self.period)
        self.due_from = self.next - slack
        self.due_until = self.next + slack

    def due(self, t: float) -> int:
        """Number of instants up to ``t`` at which the block has not acted yet."""
        if t < self.due_from:
            return 0
        return 1 + math.floor((t - self.due_from) / self.period)

    def buffer(self, t: float) -> None:
        self.in_step = True
        self._block.step_starts(t)

    def estimate(self, t: float) -> float:
        return self.next - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        if not self.in_step:
            self.settling = True
            return False, False, 1.0
        self.in_step = self.settling = False
        if t < self.due_from:
            return False, False, 1.0
        self._detected_at = t
        self.settling = True
        if t <= self.due_until:
            return True, True, BEFORE_OTHER_EVENTS
        return True, False, (self.next - self.step_start) / (t - self.step_start)

    def resolve(self, t: float) -> None:
        self._block.act(self._detected_at)


class Settling(Event):
    """One more pass through the graph whenever a block in a `Subsystem` has acted.

    It comes last, so that what other events change at that time has reached the block too.
    """

    def __init__(self, clock: SampleClock):
        super().__init__()
        self._clock = clock

    def detect(self, t: float) -> tuple[bool, bool, float]:
        settling = self._clock.settling and bool(self._clock)
        return settling, settling, AFTER_OTHER_EVENTS

    def resolve(self, t: float) -> None:
        """Nothing: the pass that follows every event is all there is to it."""


def _nothing() -> None:
    return None


def _within_a_step() -> bool:
    """Whether a step is under way, or just a look at the graph as in `Simulation.to_statespace`.

    It takes a microsecond, so it is asked only where no step usually leads.
    """
    frame = sys._getframe(2)
    while frame is not None and frame.f_code is not Simulation.timestep.__code__:
        frame = frame.f_back  # type: ignore[assignment]
    return frame is not None


class SampledBlock(Block):
    """Base of all blocks that act at a sample period T (s)."""

    linearizable = False

    def __init__(self, T: float, first: int):
        super().__init__()
        self.T = _period(T)
        self.clock = SampleClock(self, first)
        self._clock_events: list[Event] = [self.clock]
        self.events = self._clock_events
        self._around: Callable[[], Simulation | Subsystem | None] = _nothing
        self.one_pass = False
        self._warned = False

    def set_solver(self, Solver, parent, **solver_args) -> None:
        # the calls come down from the Simulation through each Subsystem around this block
        levels, frame = 0, sys._getframe(1)
        around = frame.f_locals.get("self")
        known = isinstance(around, (Simulation, Subsystem))
        self._around = weakref.ref(around) if known else _nothing
        while isinstance(frame.f_locals.get("self"), Subsystem) and frame.f_back:
            levels, frame = levels + 1, frame.f_back
        simulation = frame.f_locals.get("self")
        if isinstance(simulation, Simulation):
            seal(simulation)
        self._clock_events = [self.clock, *(Settling(self.clock) for _ in range(levels))]
        self._act_in_events(True)

    def _act_in_events(self, yes: bool) -> None:
        self.one_pass = not yes
        self.events = self._clock_events if yes else []

    def reset(self) -> None:
        self._act_in_events(True)
        super().reset()

    def sample(self, t: float, dt: float) -> None:
        """PathSim calls this once when a run begins and at the end of every step."""
        around = self._around()
        one_pass = (isinstance(around, Simulation) and not around._blocks_dyn
                    and not around.engine.is_adaptive)
        if one_pass is not self.one_pass:
            self._act_in_events(not one_pass)
        if one_pass:
            self.step_starts(t)

    def step_starts(self, t: float) -> None:
        """All blocks hold their final values at ``t``, where the next step starts."""
        clock = self.clock
        clock.step_start = t
        if t > clock.due_until or t < clock.latest_from:
            # switched off for a while, another time, another simulation: go on from here
            clock.begin_at(t, clock.index)

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix, recordings)
        clock = self.clock
        json_data.update(period=clock.period, start=clock.start, index=clock.index)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        clock, index = self.clock, json_data["index"]
        if json_data["period"] != clock.period:
            raise ParameterError(
                f"the checkpoint is of a {type(self).__name__} with T = {json_data['period']!r}, "
                f"this one has T = {clock.period!r}", parameter="T", value=clock.period)
        super().load_checkpoint(prefix, json_data, npz)
        clock.begin_at(json_data["start"] + max(index - 1, 0) * clock.period, index)

    def act(self, t: float) -> None:
        """Act on all instants up to ``t``."""
        raise NotImplementedError

    def _warn_of_late_instants(self, t: float) -> None:
        if self._warned:
            return
        self._warned = True
        warnings.warn(
            f"{type(self).__name__} samples every {self.clock.period:.9g} s, but the diagram's "
            f"step from {self.clock.step_start:.9g} s to {t:.9g} s jumps over a sample instant: "
            "time is kept, but the inputs there are not known. Use a dt that divides T.",
            RuntimeWarning, stacklevel=2)


class SampledPlant(SampledBlock):
    """Base of sampled blocks without direct feed-through: y[k+1] = f(x[k], u[k]).

    A subclass implements `latch` (keep the inputs), `advance` (one period with the inputs kept)
    and `publish` (show the outputs).
    """

    def __init__(self, T: float):
        super().__init__(T, first=1)
        self._latched = False

    def __len__(self) -> int:
        return 0

    @property
    def samples(self) -> int:
        """Number of sample periods advanced since the start or the last reset."""
        return self.clock.index - 1

    def reset(self) -> None:
        super().reset()
        self._latched = False

    def step_starts(self, t: float) -> None:
        super().step_starts(t)
        clock = self.clock
        # at the instant itself the latest values count: they may be edited between two runs
        if t >= clock.latest_from and (not self._latched or t <= clock.latest_until):
            self.latch()
            self._latched = True

    def update(self, t: float) -> None:
        if self.one_pass and t >= self.clock.due_from and (
                t <= self.clock.due_until or _within_a_step()):
            self.act(t)

    def act(self, t: float) -> None:
        clock = self.clock
        if t > clock.due_until:
            self._warn_of_late_instants(t)
        while t >= clock.due_from:
            self.advance()
            clock.go_to(clock.index + 1)
        self._latched = False
        self.publish()

    def latch(self) -> None:
        raise NotImplementedError

    def advance(self) -> None:
        raise NotImplementedError

    def publish(self) -> None:
        raise NotImplementedError


class SampledLaw(SampledBlock):
    """Base of sampled blocks with direct feed-through: y[k], x[k+1] = f(u[k], x[k]).

    A subclass implements `initial_state` and the pure function `law`; states are numbers or
    (nested) tuples of numbers.
    """

    def __init__(self, T: float):
        super().__init__(T, first=0)
        self._start_law()

    def _start_law(self) -> None:
        self._state = self._next_state = self.initial_state()
        # the first instant is the first evaluation of the graph
        self._due = 1

    def initial_state(self) -> Any:
        """State before the first sample."""
        raise NotImplementedError

    def law(self, u: list[float], state: Any) -> tuple[list[float], Any]:
        """Outputs at an instant and the state after it, from the inputs and the state before."""
        raise NotImplementedError

    def reset(self) -> None:
        super().reset()
        self._start_law()

    def _commit(self) -> None:
        """What was computed at the instants up to now is final."""
        self._state = self._next_state
        for _ in range(self._due):
            self.clock.go_to(self.clock.index + 1)
        self._due = 0

    def sample(self, t: float, dt: float) -> None:
        if self._due:
            self._commit()
        super().sample(t, dt)

    def step_starts(self, t: float) -> None:
        # a step that starts before the instant is a rejected one taken anew
        if self._due and t >= self.clock.due_from:
            self._commit()
        self._due = 0
        super().step_starts(t)

    def update(self, t: float) -> None:
        if self.one_pass and (t <= self.clock.due_until or _within_a_step()):
            self.act(t)
        if self._due:
            state = self._state
            u = self.inputs._data.tolist()
            for _ in range(self._due):
                y, state = self.law(u, state)
            self._next_state = state
            self.outputs.update_from_array(y)

    def act(self, t: float) -> None:
        self._due = self.clock.due(t)
        if self._due and t > self.clock.due_until:
            self._warn_of_late_instants(t)

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix, recordings)
        json_data.update(state=self._state, next_state=self._next_state, due=self._due)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        super().load_checkpoint(prefix, json_data, npz)
        self._state, self._next_state = map(_tuples, (json_data["state"], json_data["next_state"]))
        self._due = json_data["due"]


def _tuples(state: Any) -> Any:
    """JSON makes lists of the tuples that a law's state consists of."""
    return tuple(map(_tuples, state)) if isinstance(state, list) else state
