"""Blocks that act at a sample period T, on PathSim's own events.

PathSim makes a step in this order: ``buffer`` of every event; the solver's stages, if the diagram
has continuous states; an evaluation of all blocks at the end of the step; ``detect`` of every
event, and for each that is found ``resolve`` and another evaluation; ``sample`` of every block.
A step may be rejected and repeated, and a diagram is evaluated between runs too (`to_statespace`,
plots). A sampled block must act once at each instant ``t_k = start + k T``, and nowhere else:

- `SampledPlant` reads its inputs at t_k, holds them over [t_k, t_k+1) and shows its new outputs at
  t_k+1: no direct feed-through. It acts when its tick is resolved and reads its inputs in
  ``sample``, where they are final.
- `SampledLaw` computes its outputs at t_k from its inputs at t_k and holds them: direct
  feed-through at the instants. From its tick to ``sample`` it is open: each evaluation computes it
  again, from the state before the instant, so that the order of blocks does not matter.

A step without solver stages has one evaluation, at its end. Blocks act there in place of the event:
this saves an evaluation per block, and a ZeroCrossing sees the change. Not with an adaptive solver,
whose search for a crossing would not end at a jump; with an implicit one, the first evaluation of a
step with stages is at its end too.

What enters a subsystem from outside reaches the blocks inside one evaluation late, for each level
of subsystems. `Settling` asks for so many more, after all ticks.

What a tick has computed is kept beside what was sampled last (`SampleClock.ahead`, ``now``), and
an evaluation before the instant shows the latter: a rejected or interrupted step is repeated
without acting twice.
"""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Mapping
from copy import copy
from typing import Any, ClassVar
from weakref import WeakKeyDictionary

from pathsim.events import Event, Schedule
from pathsim.exceptions import LinearizationError

from .callers import depth_in_subsystems, warn_user
from .checks import number, positive, refuse
from .continuous import Matrices, at_limit, continuous_equivalent
from .parameters import Parametric
from .pathsim_internals import WiredRegister, port_names, show, values
from .pathsim_types import Block

# s; catches typos such as T=1e-9
SHORTEST_PERIOD = 1e-6

# PathSim resolves the events of a step in the order of their place in it: other events at the same
# time come after the tick
_BEFORE_OTHERS = math.nextafter(1.0, 0.0)

_NOT_DETECTED = False, False, 1.0


def _period(T: Any) -> float:
    return number("T", positive("T", T), low=SHORTEST_PERIOD)


class Settling(Event):
    """Further evaluations after the ticks of a step, for the blocks in subsystems.

    There is one for each simulation; a block has it in its events once for each subsystem around.
    """

    depth = given = 0
    wanted = False

    def buffer(self, t: float) -> None:
        self.wanted, self.given = False, 0

    def detect(self, t: float) -> tuple[bool, bool, float]:
        asked = self.wanted and self.given < self.depth
        self.given += asked
        return asked, asked, math.inf

    def resolve(self, t: float) -> None:
        self.buffer(t)

    def off(self) -> None:
        """The other blocks still need it."""


# by the engine of the simulation, which PathSim gives to each of its blocks
_settling: WeakKeyDictionary[Any, Settling] = WeakKeyDictionary()


class SampleClock(Schedule):
    """The instants of a block, counted by an integer, and what was computed at them.

    Attributes
    ----------
    start, period : float
        time of instant 0 and T, s
    index : int
        the next instant
    now : tuple
        of the latest instant: the next one's index, the outputs shown, and what `SampledPlant`
        holds or the state of a `SampledLaw`. One assignment, which no interrupt can split
    ahead : tuple or None
        the same of the next instant, where its tick came and ``sample`` did not
    """

    def __init__(self, block: SampledBlock):
        super().__init__(t_period=block.T)
        # here, because every step changes them: setting an attribute of a block is checked
        self.block, self.settling = block, Settling()
        self.now: tuple[int, Any, Any] = (block.first, None, None)
        self.reset()

    def reset(self) -> None:
        super().reset()
        if not self.block:
            # `Block.off` resets the block after its events are off
            self.off()
        self.period = self.t_period = _period(self.block.T)
        # length of the last step, and start of that which has reached the latest instant
        self.start = self.dt = self.since = 0.0
        self.ahead: Any = None
        # outputs before the latest instant, and those in the block's register
        self.before: Any = None
        self.shown: Any = None
        # whether the law is evaluated; the period that a plant has begun
        self.open, self.begun = False, 0
        self.counting = self.in_step = self.first = self.acted = False
        self.step_start = self.reached = 0.0
        self.go_to(self.block.first)

    def go_to(self, index: int) -> None:
        """Wait for an instant."""
        self.index, period = index, self.period
        time = self.start + index * period
        # how far the diagram's clock, to which PathSim adds dt at each step, may be from it
        slack, most = 1e-13 + 1e-9 * abs(time), 0.01 * period
        self.slack = slack = slack if slack < most else most
        self.due_from = time - slack

    def next(self) -> float:
        """Time of the next instant."""
        return self.start + self.index * self.period

    def at_latest(self, t: float) -> bool:
        """Whether ``t`` is the latest instant."""
        return abs(t - self.next() + self.period) <= self.slack

    def outputs_at(self, t: float) -> Any:
        """The outputs of the latest instant, or those before it where a step is repeated."""
        return self.before if t < self.due_from - 1.01 * self.period else self.now[1]

    def count(self, t: float) -> int:
        """Number of instants from the next one to ``t``."""
        return 1 + int((t - self.due_from) / self.period)

    def join(self, t: float) -> None:
        """Count from ``t`` on where this is another time than that of the block.

        The block was switched off for a while, or comes from another simulation. A step that was
        interrupted starts again before the latest instant.
        """
        if self.index != self.now[0]:
            self.go_to(self.now[0])
        if not self.counting or not self.since - 0.01 * self.period <= t < self.due_from:
            self.counting, self.since = True, t
            self.start = t - max(self.index - 1, 0) * self.period
            self.go_to(self.index)
            if self.at_latest(t):
                self.block.sample(t, self.dt)

    def buffer(self, t: float) -> None:
        """A step starts at ``t``, where all blocks have their final values."""
        self.join(t)
        if t >= self.due_from:
            # the first instant of a diagram that is stepped without a run
            self.block.act(t)
            self.block.update(t)
            self.block.sample(t, self.dt)
        self.step_start, self.in_step, self.acted = t, True, False
        self.first = self.block.acts_first

    def estimate(self, t: float) -> float:
        return self.next() - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        if not self.in_step or t <= self.step_start:
            # a run begins, maybe after one that ended within a step
            self.in_step = False
            self.join(t)
            self.settle.wanted = True
            self.block.run_begins()
        if t < self.due_from:
            # a step that was interrupted is repeated: the inputs are read again
            self.settle.wanted |= self.at_latest(t)
            return _NOT_DETECTED
        self.settle.wanted = True
        if self.acted:
            return _NOT_DETECTED
        self.reached, time = t, self.next()
        if t <= time + self.slack or not self.in_step:
            return True, True, _BEFORE_OTHERS
        return True, False, (time - self.step_start) / (t - self.step_start)

    def resolve(self, t: float) -> None:
        self.block.act(self.reached)

    def to_checkpoint(self, prefix: str) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix)
        now = [_plain(part) for part in self.now]
        json_data.update(period=self.period, start=self.start, now=now)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        period, kind = json_data["period"], type(self.block).__name__
        if period != self.period:
            why = f"the checkpoint is of a {kind} with T = {period!r}, this one has T = "
            refuse("T", self.period, f"{why}{self.period!r}")
        super().load_checkpoint(prefix, json_data, npz)
        self.start = json_data["start"]
        self.now = tuple(_rebuilt(part) for part in json_data["now"])  # type: ignore[assignment]
        self.before, self.ahead, self.shown = self.now[1], None, None
        self.open = self.in_step = self.first = self.acted = False
        self.counting = True
        self.go_to(self.now[0])
        self.since = self.next() - self.period


def _plain(value: Any) -> Any:
    """A state as JSON has it: a tuple as a list, with the name of its class first."""
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
        why = f"the checkpoint is of another version: there is no state {name} in {module}"
        refuse("checkpoint", name, why)
    return kind(*parts)


class SampledBlock(Block):
    """Base of the blocks that act at a sample period T (s); see `SampledPlant`, `SampledLaw`."""

    linearizable = False
    # index of the first instant at which it acts
    first = 0
    # whether it acts in the first evaluation of a step, where that is at the step's end
    acts_first = False
    _warned = False
    _engine: Any = None

    def __init__(self, T: float):
        super().__init__()
        self.T = _period(T)
        self.clock = SampleClock(self)
        self.events: list[Event] = [self.clock]

    def linearize(self, t: float) -> Any:
        """Refused: a sampled block goes on sampling. `to_statespace` gives its linear model."""
        raise LinearizationError(
            f"{type(self).__name__} samples, and has no linear stand-in to run in its place: "
            "to_statespace gives the linear model of the diagram"
        )

    def set_solver(self, Solver: Any, parent: Any, **solver_args: Any) -> None:
        """PathSim calls this when the block comes into a simulation, with that one's engine."""
        self.acts_first = parent.is_explicit and not parent.is_adaptive
        if parent is self._engine:
            return
        self._engine, clock = parent, self.clock
        clock.in_step, clock.since = False, clock.next() - clock.period
        # its time may be an earlier one
        clock.before = clock.now[1]
        if self.events:
            depth, settle = depth_in_subsystems(), _settling.setdefault(parent, Settling())
            settle.depth, clock.settle = max(depth, settle.depth), settle
            others = [event for event in self.events if not isinstance(event, Settling)]
            self.events = [*others, *depth * [settle]]

    def run_begins(self) -> None:
        """Called when a run begins."""

    def evaluated_first(self, t: float) -> None:
        """Act in the first evaluation of a step where that is at the step's end."""
        clock = self.clock
        clock.first = False
        # nothing is done where a step was interrupted before, and this is a look at the future
        if t >= clock.due_from and t - clock.step_start <= 1.000001 * clock.dt:
            clock.acted = True
            self.act(t)

    def act(self, t: float) -> None:
        """The next instant is reached, and all others up to ``t``."""
        raise NotImplementedError

    def warn_of_late(self, t: float) -> None:
        """Warn once that a step to ``t`` ends after the instant."""
        clock = self.clock
        if not self._warned:
            self._warned = True
            warn_user(
                f"{type(self).__name__} samples every {clock.period:.9g} s, but the diagram's "
                f"step to {t:.9g} s jumps over a sample instant: time is kept, but the inputs "
                "there are not known. Use a dt that divides T."
            )


class SampledPlant(SampledBlock):
    """Base of sampled blocks without direct feed-through: y[k+1] = f(x[k], u[k]).

    A subclass implements `advance`, and calls `start_from` with its first outputs when it is built
    and at the end of ``reset``.

    Parameters
    ----------
    T : float
        sample period in s
    """

    first = 1

    def __len__(self) -> int:
        return 0

    def reset(self) -> None:
        super().reset()
        self.clock.now = 1, [], None

    @property
    def samples(self) -> int:
        """Number of sample periods advanced since the start or the last reset."""
        return self.clock.now[0] - 1

    def start_from(self, y: list[float]) -> None:
        """Show these outputs at the latest instant."""
        clock = self.clock
        clock.now = clock.now[0], y, clock.now[2]
        clock.before = clock.shown = y
        show(self.outputs, y)

    def latch(self, t: float) -> list[float]:
        """The inputs at ``t``, held from now on."""
        return values(self.inputs)

    def advance(self, index: int, u: list[float]) -> list[float]:
        """One period with the inputs ``u``: the outputs at the instant ``index``.

        It is called again for the same period if an exception or Ctrl-C has ended it.
        """
        raise NotImplementedError

    def act(self, t: float) -> None:
        clock = self.clock
        k, y, u = clock.now
        i, last = k, k
        if t > clock.due_from + 2 * clock.slack:
            self.warn_of_late(t)
            last = k - 1 + clock.count(t)
        if clock.ahead is not None:
            # acted in a step that was rejected or interrupted
            i = max(clock.ahead[0], k)
        while i <= last:
            y = self.advance(i, u)
            i += 1
            clock.ahead = i, y

    def update(self, t: float) -> None:
        clock = self.clock
        if clock.first:
            self.evaluated_first(t)
        y = clock.ahead[1] if clock.ahead and t >= clock.due_from else clock.outputs_at(t)
        if y is not clock.shown:
            clock.shown = y
            show(self.outputs, y)

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        clock.dt = dt
        clock.in_step = clock.first = False
        if clock.ahead is not None and t >= clock.due_from:
            i, y = clock.ahead
            u, clock.before = self.latch(t), clock.now[1]
            clock.now = i, y, u
            clock.ahead = None
            clock.since = t - dt
            clock.go_to(i)
        elif clock.at_latest(t):
            # a run begins at an instant: values may have been edited since the last one
            i, y, _ = clock.now
            clock.now = i, y, self.latch(t)


class SampledLaw(Parametric, SampledBlock):
    """Base of sampled blocks with direct feed-through: y[k], x[k+1] = f(u[k], x[k]).

    A subclass is a dataclass with a field ``T``, the sample period in s. It implements
    `initial_state` and `law`, a plain function without side effects: it may be called several times
    at an instant, always with the state before it. `build` makes what the law needs, for the period
    ``self.clock.period``: parameters take effect at the next sample, a new T at the next reset.
    """

    inputs: WiredRegister
    # inputs that must be connected
    measured: ClassVar[tuple[str, ...]] = ()
    # outputs that must be connected, and the input that can switch each off; "" if none can
    commands: ClassVar[Mapping[str, str]] = {}
    _wires_seen = False

    def begin(self) -> None:
        SampledBlock.__init__(self, self.T)
        names = dict(self.input_port_labels) if self.input_port_labels else None
        self.inputs = WiredRegister(len(self.inputs), names)
        self.clock.now = 0, None, self.initial_state()

    def needed(self) -> tuple[str, ...]:
        """Inputs that must be connected, given the others that are."""
        return self.measured

    def run_begins(self) -> None:
        """Warn once of inputs that must be connected and are not."""
        if self._wires_seen:
            return
        self._wires_seen = True
        missing = [name for name in self.needed() if name not in self.inputs.wired]
        if missing:
            warn_user(
                f"{type(self).__name__} measures 0 where no wire comes in: {', '.join(missing)}"
            )

    def configure(self) -> None:
        super().configure()
        present = self.clock.period
        if self.events and (asked := _period(self.T)) != present:
            # it acts at the next reset, and is tried now
            try:
                self.clock.period = asked
                self.build()
            finally:
                self.clock.period = present
                self.build()

    def reset(self) -> None:
        period = self.clock.period
        super().reset()
        self.clock.now = 0, None, self.initial_state()
        if self.clock.period != period:
            self.configure()

    def initial_state(self) -> Any:
        """State before the first sample: a number, or a (nested, named) tuple of numbers."""
        raise NotImplementedError

    def law(self, u: list[float], state: Any) -> tuple[list[float], Any]:
        """Outputs at an instant and the state after it, from the inputs and the state before."""
        raise NotImplementedError

    def act(self, t: float) -> None:
        clock = self.clock
        clock.open = True
        if t > clock.due_from + 2 * clock.slack:
            self.warn_of_late(t)

    def update(self, t: float) -> None:
        clock = self.clock
        if clock.first:
            self.evaluated_first(t)
        if clock.open and t >= clock.due_from:
            u = values(self.inputs)
            k, _, state = clock.now
            y, state = self.law(u, state)
            k += 1
            if t > clock.due_from + 2 * clock.slack:
                for _ in range(1, clock.count(t)):
                    y, state = self.law(u, state)
                    k += 1
            clock.ahead, clock.shown = (k, y, state), y
            show(self.outputs, y)
        else:
            y = clock.outputs_at(t)
            if y is not clock.shown:
                clock.shown = y
                if y is not None:
                    show(self.outputs, y)

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        clock.dt = dt
        clock.in_step = clock.first = False
        if clock.open and clock.ahead is not None and t >= clock.due_from:
            clock.before = clock.now[1]
            clock.now = clock.ahead
            clock.open = False
            clock.ahead = None
            clock.since = t - dt
            clock.go_to(clock.now[0])

    def to_statespace(self, t: float) -> Matrices:
        """A, B, C, D of the continuous equivalent about the present state, without the hold.

        A LinearizationError tells where there is none, a warning where the law is at a limit.
        """
        u, (k, _, state) = values(self.inputs), self.clock.now
        if k == 0:
            # bumpless: the first sample engages the law where it is
            _, state = self.law(u, state)
        name = type(self).__name__
        model = continuous_equivalent(self.law, u, state, self.clock.period, name)
        inputs, outputs = port_names(self.inputs), port_names(self.outputs)
        # a reference has a parameter of its name
        references = {n: i for n, i in inputs.items() if n in vars(self.checked)}
        commands = {n: outputs[n] for n in self.commands or [*outputs][:1]}
        with warnings.catch_warnings():
            # what a block warns of once, its copy would here
            warnings.simplefilter("ignore")
            idle = at_limit(copy(self).law, u, state, model, references, commands)
        if idle:
            why = f"{name} is at a limit, a ramp or a stop: in its linear model there "
            warn_user(f"{why}{' and '.join(idle)} does not act")
        return model
