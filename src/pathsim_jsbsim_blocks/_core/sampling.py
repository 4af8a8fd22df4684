"""The one mechanism by which blocks sample at a period T.

PathSim evaluates a diagram several times per step: at every solver stage, at the end of the step,
and again after every event. It also evaluates it between runs (`to_statespace`, plots), and repeats
a step that was rejected, or that an exception or Ctrl-C has ended. A sampled block must act at its
sample instants ``t_k = start + k T`` only, and exactly once at each. Two kinds exist:

- `SampledPlant` reads its inputs at t_k, holds them over [t_k, t_k+1) and shows its new outputs
  at t_k+1 (no direct feed-through): the aircraft.
- `SampledLaw` computes its outputs at t_k from its inputs at t_k and holds them (direct
  feed-through at the sample instants): controllers.

Instants are counted by an integer, never by adding T. What a block has computed is stored under the
number of its instant, and an evaluation shows the values of its own time: going back to the start
of a step shows the values from before it. An instant is over when a step starts at it or after it;
the clock then goes on to the next one by a single assignment, which no interrupt can split.

A plant acts exactly once per instant. A law may be evaluated several times at one instant, always
from the state before that instant; the last result counts, so the order of blocks and events does
not matter.

Blocks act when an event is resolved, which is always correct: events are resolved in steps only,
never by a look at the diagram. But every event costs one more pass through the graph, a quarter of
a step. In a fixed step without solver stages the first evaluation is the one at the step's end;
blocks that are not in a subsystem show their outputs there, and need no event.
`SampleClock.one_pass` is the switch. A plant may then not act in the evaluation, which could be a
look; it acts when the step starts.

Most steps of most diagrams lead from one instant to the next in one pass. Five methods see each of
them: `buffer`, `update`, `detect`, `sample` and the plant's `advance`. They deal with that case in
line and leave all others to a second method, because a call costs as much as the arithmetic.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple
from weakref import WeakSet

from pathsim import Simulation
from pathsim.blocks import Block
from pathsim.events import Event
from pathsim.exceptions import LinearizationError

from . import checkpoint  # noqa: F401  (what sampled blocks save has a digest)
from .callers import warn_user
from .checks import number, positive, refuse
from .continuous import Matrices, continuous_equivalent
from .pathsim_internals import (
    ClockEvent,
    WiredRegister,
    before_runs,
    show,
    show_without_stages,
    step_begins,
    values,
    without_stages,
)
from .wiring import contents, name_of

# s; catches typos such as T=1e-9
SHORTEST_PERIOD = 1e-6

# PathSim resolves the events of a step in the order of their place in it
BEFORE_OTHER_EVENTS = math.nextafter(1.0, 0.0)

NOT_DETECTED = False, False, 1.0


def _period(T: Any) -> float:
    return number("T", positive("T", T), low=SHORTEST_PERIOD)


class Instant(NamedTuple):
    """The instant that a block waits for, and when it and the one before it are reached."""

    k: int
    time: float
    due_from: float
    due_until: float
    latest_from: float
    latest_until: float


class SampleClock(ClockEvent):
    """Event on the sample instants of one block, the count of them, and what was computed there.

    What every step changes is kept here: a block checks each attribute that is set. ``first`` is
    the index of the first instant at which the block acts.
    """

    def __init__(self, block: SampledBlock, first: int):
        self._block = block
        self.first = first
        # the fields of an `Instant`; as a plain tuple it is made and read in a third of the time
        self.instant: tuple[int, float, float, float, float, float]
        # the last step had solver stages, so the next one probably has them too
        self.stages = False
        self.dt = 0.0
        super().__init__()
        self.reset()
        self.forget()

    def reset(self) -> None:
        super().reset()
        if not self._block:
            self.off()
        self.period = _period(self._block.T)
        self.step_start = -math.inf
        # between the start of a step and its end
        self.in_step = False
        self.settling = False
        self.reached = 0.0
        self.begin_at(0.0, self.first)

    def forget(self) -> None:
        """Nothing has been computed, and no instant reached."""
        # what belongs to the instants around the next one, by index
        self.results: dict[int, Any] = {}
        self.sampled = self.index - 1
        self.resolved = False
        # end of the step in which the outputs were shown without an event
        self.acted_at: float | None = None
        # whether the step under way has one evaluation, at its end, unless a stage comes before it.
        # In a subsystem, what enters comes one evaluation late; adaptive runs may reject the step
        self.one_pass = False

    @property
    def next(self) -> Instant:
        return Instant(*self.instant)

    @property
    def index(self) -> int:
        return self.instant[0]

    def begin_at(self, t: float, index: int) -> None:
        """Let the sample before ``index`` be at ``t`` (the first, if there is none before)."""
        self.start = t - max(index - 1, 0) * self.period
        self.go_to(index)

    def go_to(self, index: int) -> None:
        time = self.start + index * self.period
        slack = self._slack(time)
        latest = self.start + max(index - 1, 0) * self.period
        before = self._slack(latest)
        self.instant = index, time, time - slack, time + slack, latest - before, latest + before

    def go_on(self) -> None:
        """Wait for the sample after that waited for until now."""
        k, _, due_from, due_until, _, _ = self.instant
        k += 1
        period = self.period
        time = self.start + k * period
        slack, longest = 1e-13 + 1e-9 * time, 0.01 * period  # `_slack`, in line
        if slack > longest:
            slack = longest
        self.instant = k, time, time - slack, time + slack, due_from, due_until

    def _slack(self, time: float) -> float:
        """How far the diagram's accumulated clock may be from an instant."""
        slack, longest = 1e-13 + 1e-9 * time, 0.01 * self.period
        return slack if slack < longest else longest

    def due(self, t: float) -> int:
        """Number of instants up to ``t`` that are not over yet."""
        due_from = self.instant[2]
        if t < due_from:
            return 0
        return 1 + int((t - due_from) / self.period)

    def buffer(self, t: float) -> None:
        """All blocks hold their final values at ``t``, where the next step starts."""
        block = self._block
        k, _, _, due_until, _, _ = self.instant
        if self.acted_at == t <= due_until and self.sampled == k:
            # the last step showed instant k in one pass: what holds for it holds for this one
            self.go_on()
            self.results.pop(k - 1, None)
            self.acted_at = None
        else:
            block.start_step(t)
        self.step_start = t
        self.in_step = True

    def estimate(self, t: float) -> float:
        return self.start + self._block.awaited * self.period - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        if not self.in_step or t <= self.step_start:
            # a run begins, maybe after one that ended within a step
            self.in_step = False
            self.settling = True
            return NOT_DETECTED
        self.in_step = False
        block = self._block
        _, time, due_from, due_until, _, _ = self.instant
        self.settling = settling = t >= due_from
        if not settling or self.acted_at == t <= due_until or block.has_acted(t):
            return NOT_DETECTED
        self.reached = t
        if t <= due_until:
            return True, True, BEFORE_OTHER_EVENTS
        return True, False, (time - self.step_start) / (t - self.step_start)

    def resolve(self, t: float) -> None:
        self._block.act(self.reached)


class PlantClock(SampleClock):
    """Clock of a plant, which acts when a step starts that is evaluated at its end only."""

    _block: SampledPlant

    def forget(self) -> None:
        super().forget()
        # index of the instant up to which the inputs are kept, and the inputs
        self.latched: tuple[int, list[float]] = (0, [])
        # index of the instant to which the plant is or was on its way
        self.begun = 0

    def buffer(self, t: float) -> None:
        block = self._block
        k, _, _, due_until, _, _ = self.instant
        if self.acted_at == t <= due_until and self.sampled == k:
            # as for any block
            self.go_on()
            results = self.results
            results.pop(k - 1, None)
            self.acted_at = None
            self.step_start = t
            self.in_step = True
            # the step before had one evaluation, so this one has
            k += 1
            latched, u = self.latched
            if latched == k and t + self.dt >= self.instant[2] and k not in results:
                # an interrupt before the result is kept leaves it to be done
                results[k] = block.advance(k, u)
                return
        else:
            block.start_step(t)
            self.step_start = t
            self.in_step = True
        block.step_started(t)


class SampledBlock(Block):
    """Base of all blocks that act at a sample period T (s)."""

    linearizable = False
    _clock: type[SampleClock] = SampleClock

    def __init__(self, T: float, first: int):
        super().__init__()
        self.T = _period(T)
        self.clock = self._clock(self, first)
        self.events: list[Event] = [self.clock]
        self._engine: Any = None
        # engine of the simulation that ran it last, and of those that ran it before
        self._runs_in: Any = None
        self._left: WeakSet[Any] = WeakSet()
        self._warned = False
        self._forget()

    def _forget(self) -> None:
        """Nothing has been computed, and no instant reached."""
        self.clock.forget()

    @property
    def awaited(self) -> int:
        """Index of the first instant that was not reached yet."""
        clock = self.clock
        return max(clock.index, clock.sampled + 1)

    def linearize(self, t: float) -> Any:
        """Refused: a sampled block goes on sampling. `to_statespace` gives its linear model."""
        raise LinearizationError(
            f"{type(self).__name__} samples, and has no linear stand-in to run in its place: "
            "to_statespace gives the linear model of the diagram"
        )

    def set_solver(self, Solver: Any, parent: Any, **solver_args: Any) -> None:
        """PathSim calls this when the block comes into a simulation, with that one's engine."""
        self._finish()
        self.clock.acted_at = None
        self._engine = parent
        self.clock.nested = False

    def enter(self, sim: Simulation, reset: bool) -> None:
        """Follow the simulation that begins to run.

        A block may go on in another simulation, but not come back to one whose clock has stood
        still since: that is refused, unless the block begins anew.
        """
        engine = sim.engine
        if engine in self._left and not reset and self.awaited > self.clock.first:
            why = f"{name_of(self)} has gone on in another simulation since this one ran: two "
            why += "simulations cannot share it. Build a block for each, or reset this one first"
            refuse("blocks", self, why)
        if engine is not self._engine:
            self.set_solver(sim.Solver, engine)
        if self._runs_in is not None:
            self._left.add(self._runs_in)
        self._left.discard(engine)
        self._runs_in = engine

    def reset(self) -> None:
        super().reset()
        self._forget()

    def sample(self, t: float, dt: float) -> None:
        """PathSim calls this once when a run begins and at the end of every step."""
        clock = self.clock
        clock.dt, clock.resolved = dt, False
        k, _, due_from, due_until, _, _ = clock.instant
        if t >= due_from:
            clock.sampled = k if t <= due_until and k in clock.results else self._latest(t)

    def start_step(self, t: float) -> None:
        clock = self.clock
        k, _, due_from, _, _, _ = clock.instant
        if t < due_from:
            if t == clock.step_start:
                # the step is repeated: its end was not reached, whatever was recorded there
                clock.sampled = k - 1
        elif clock.sampled < k:
            clock.sampled = self._latest(t)
        if clock.sampled >= k:
            self._finish()
        clock.resolved, clock.acted_at = False, None
        k, _, _, due_until, latest_from, _ = clock.instant
        if t > due_until or t < latest_from:
            # switched off for a while, another time, another simulation: go on from here
            clock.begin_at(t, k)
        engine = self._engine
        clock.one_pass = not (clock.stages or clock.nested or engine.is_adaptive)
        step_begins(engine)

    def _latest(self, t: float) -> int:
        """Index of the latest instant up to ``t`` of which there is a result."""
        k = self.clock.index
        latest = k - 1 + self.clock.due(t)
        return max((i for i in self.clock.results if k <= i <= latest), default=k - 1)

    def _finish(self) -> None:
        """Let the instants that were reached be over."""
        clock = self.clock
        sampled = clock.sampled
        k = clock.index
        if sampled == k:
            clock.go_on()
        elif sampled > k:
            clock.go_to(sampled + 1)
        for i in range(k - 1, sampled):
            clock.results.pop(i, None)

    def _shown(self, t: float) -> int:
        """Index of the instant whose outputs belong to ``t``."""
        clock = self.clock
        k, _, due_from, due_until, _, _ = clock.instant
        if t < due_from:
            return k - 1
        if clock.sampled < k and not clock.resolved:
            if not (clock.one_pass and without_stages(self._engine)):
                return k - 1
            clock.acted_at = t
        return k if t <= due_until else k - 1 + clock.due(t)

    def has_acted(self, t: float) -> bool:
        """Whether the outputs at ``t``, the end of a step, are shown already."""
        clock = self.clock
        if clock.acted_at == t:
            return True
        clock.stages = not without_stages(self._engine)
        return False

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix, recordings)
        kept = ("period", "start", "index", "sampled", "step_start")
        json_data.update({name: getattr(self.clock, name) for name in kept})
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        clock = self.clock
        if json_data["period"] != clock.period:
            why = f"the checkpoint is of a {type(self).__name__} with T = {json_data['period']!r}, "
            refuse("T", clock.period, f"{why}this one has T = {clock.period!r}")
        super().load_checkpoint(prefix, json_data, npz)
        clock.in_step = False
        clock.start, clock.step_start = json_data["start"], json_data["step_start"]
        clock.go_to(json_data["index"])
        self._forget()
        clock.sampled = json_data["sampled"]

    def act(self, t: float) -> None:
        """Act on all instants up to ``t``, the end of the step."""
        clock = self.clock
        if t > clock.next.due_until:
            self._warn_of_late_instants(t)
        clock.resolved = True

    def _warn_of_late_instants(self, t: float) -> None:
        if self._warned:
            return
        self._warned = True
        warn_user(
            f"{type(self).__name__} samples every {self.clock.period:.9g} s, but the diagram's "
            f"step from {self.clock.step_start:.9g} s to {t:.9g} s jumps over a sample instant: "
            "time is kept, but the inputs there are not known. Use a dt that divides T."
        )


def _enter(sim: Simulation, reset: bool) -> None:
    for block in contents(sim)[0]:
        if isinstance(block, SampledBlock):
            block.enter(sim, reset)


before_runs.append(_enter)


class SampledPlant(SampledBlock):
    """Base of sampled blocks without direct feed-through: y[k+1] = f(x[k], u[k]).

    A subclass implements `latch` (the inputs to keep) and `advance` (one period with these inputs;
    returns the outputs). `advance` is called again for the same period if it was interrupted.
    """

    _clock = PlantClock

    def __init__(self, T: float):
        super().__init__(T, first=1)

    def __len__(self) -> int:
        return 0

    @property
    def samples(self) -> int:
        """Number of sample periods advanced since the start or the last reset."""
        return self.awaited - 1

    def start_from(self, y: list[float]) -> None:
        """Show the outputs at the instant before the next one."""
        clock = self.clock
        clock.results[clock.index - 1] = y
        show(self.outputs, y)

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        k, _, due_from, due_until, latest_from, latest_until = clock.instant
        if due_from <= t <= due_until and k in clock.results:
            clock.dt, clock.resolved = dt, False
            clock.sampled = k
            clock.latched = k + 1, self.latch()
            return
        super().sample(t, dt)
        if clock.sampled >= k:
            clock.latched = clock.sampled + 1, self.latch()
        elif latest_from <= t <= latest_until and k not in clock.results:
            # a run begins at an instant: values may have been edited since the last one
            clock.latched = k, self.latch()

    def step_started(self, t: float) -> None:
        """Act where the step that has started at ``t`` is evaluated at its end only."""
        clock = self.clock
        k, _, due_from, _, _, _ = clock.instant
        results = clock.results
        if k not in results:
            latched, u = clock.latched
            if latched != k:
                u = self.latch()
                clock.latched = k, u
            if clock.one_pass and t + clock.dt >= due_from:
                results[k] = self.advance(k, u)

    def update(self, t: float) -> None:
        clock = self.clock
        k, _, due_from, due_until, _, _ = clock.instant
        results = clock.results
        if k not in results:
            return
        if (
            clock.one_pass
            and due_from <= t <= due_until
            and clock.sampled < k
            and not clock.resolved
            and show_without_stages(self._engine, self.outputs, results[k])
        ):
            clock.acted_at = t
        else:
            shown = self._shown(t)
            if shown not in results:
                shown, clock.acted_at = max(results), None
            show(self.outputs, results[shown])

    def act(self, t: float) -> None:
        super().act(t)
        clock = self.clock
        index = clock.index
        for i in range(index, index + clock.due(t)):
            if i not in clock.results:
                clock.results[i] = self.advance(i, clock.latched[1])

    def latch(self) -> list[float]:
        raise NotImplementedError

    def advance(self, index: int, u: list[float]) -> list[float]:
        raise NotImplementedError


class SampledLaw(SampledBlock):
    """Base of sampled blocks with direct feed-through: y[k], x[k+1] = f(u[k], x[k]).

    A subclass implements `initial_state` and the pure function `law`; states are numbers or
    (nested) tuples of numbers.
    """

    inputs: WiredRegister

    def __init__(self, T: float):
        super().__init__(T, first=0)
        self.inputs = WiredRegister(
            len(self.inputs), self.input_port_labels and dict(self.input_port_labels)
        )

    def _forget(self) -> None:
        super()._forget()
        # outputs at an instant, and the state after it
        self.clock.results[-1] = None, self.initial_state()

    def initial_state(self) -> Any:
        """State before the first sample."""
        raise NotImplementedError

    def law(self, u: list[float], state: Any) -> tuple[list[float], Any]:
        """Outputs at an instant and the state after it, from the inputs and the state before."""
        raise NotImplementedError

    def update(self, t: float) -> None:
        clock = self.clock
        k, _, due_from, due_until, _, _ = clock.instant
        if (
            clock.one_pass
            and due_from <= t <= due_until
            and clock.sampled < k
            and not clock.resolved
            and without_stages(self._engine)
        ):
            clock.acted_at = t
            before = clock.results[k - 1]
            y, state = self.law(values(self.inputs), before[1])
            clock.results = {k - 1: before, k: (y, state)}
            show(self.outputs, y)
        else:
            self._show_anywhere(t)

    def _show_anywhere(self, t: float) -> None:
        clock = self.clock
        k, results = clock.index, clock.results
        shown = max(self._shown(t), 0)  # the first instant is the first evaluation of the graph
        if shown >= k > clock.sampled:
            before = results[k - 1]
            u, state = values(self.inputs), before[1]
            for _ in range(k, shown + 1):
                y, state = self.law(u, state)
            clock.results = {k - 1: before, shown: (y, state)}
            show(self.outputs, y)
        elif len(results) > 1:
            y, _ = results[max(i for i in results if i <= max(shown, k - 1))]
            if y is not None:
                show(self.outputs, y)

    def to_statespace(self, t: float) -> Matrices:
        """A, B, C, D of the continuous equivalent about the present state, without the hold.

        A LinearizationError tells where there is none.
        """
        u = values(self.inputs)
        results = self.clock.results
        latest = max(results)
        _, state = results[latest]
        if latest < 0:
            # bumpless: the first sample engages the law where it is
            _, state = self.law(u, state)
        return continuous_equivalent(self.law, u, state, self.clock.period, type(self).__name__)

    def has_acted(self, t: float) -> bool:
        acted = super().has_acted(t)
        if acted and t > self.clock.next.due_until:
            self._warn_of_late_instants(t)
        return acted

    def to_checkpoint(self, prefix: str, recordings: bool = False) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix, recordings)
        results = [[i, y, state] for i, (y, state) in self.clock.results.items()]
        json_data.update(results=results, states=_STATES)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        if json_data.get("states") != _STATES:
            why = "the checkpoint is of another version of this package, whose "
            why += f"{type(self).__name__} keeps another state: fly to that time again"
            refuse("path", prefix, why)
        super().load_checkpoint(prefix, json_data, npz)
        form = self.initial_state()
        self.clock.results = {i: (y, _like(form, state)) for i, y, state in json_data["results"]}


# raised where a law keeps another state than in the version before
_STATES = 3


def _like(form: Any, state: Any) -> Any:
    """JSON makes lists of the tuples that a law's state consists of."""
    if not isinstance(state, list):
        return state
    if not isinstance(form, tuple) or len(form) != len(state):
        return tuple(_like(None, part) for part in state)
    parts = map(_like, form, state)
    return type(form)(*parts) if hasattr(form, "_fields") else tuple(parts)
