"""Blocks that act at a sample period T, on PathSim's own events.

PathSim makes a step in this order: ``buffer`` of every event; the solver's stages, if the diagram
has continuous states; an evaluation of all blocks at the end of the step; ``detect`` of every
event, and for each detected event ``resolve`` and another evaluation; ``sample`` of every block.
A run begins with an evaluation, ``detect`` and ``sample``. A step may be rejected, or interrupted
by Ctrl-C, and repeated, and a diagram is also evaluated between runs (`to_statespace`, plots). A
sampled block must act once at each instant ``t_k = start + k T``, and at no other time:

- `SampledPlant` reads its inputs at t_k, holds them over [t_k, t_k+1) and shows its new outputs at
  t_k+1: no direct feed-through. It reads its inputs in ``sample``, when they are final.
- `SampledLaw` computes its outputs at t_k from its inputs at t_k and holds them: direct
  feed-through at the instants. Each evaluation at t_k repeats this from the state before the
  instant, so that the order of blocks does not matter.

A solver's stage at t_k belongs to the period before. So a clock is open from its tick, an event, to
``sample``. A step without stages has one evaluation, at its end, so clocks are open from its start:
this saves an evaluation per block, and a ZeroCrossing detects the change. This is not done with an
adaptive solver, whose search for a crossing would not converge at a jump.

The results of a step at t_k (`SampleClock.ahead`) are stored beside those before t_k (``now``)
until PathSim starts a step or a run at t_k or later. If one starts earlier, the step to t_k was not
completed, and is repeated from ``now``.

A signal into a subsystem reaches the blocks inside one evaluation late per level of subsystems.
`Settling` requests these further evaluations, after all ticks.
"""

from __future__ import annotations

import inspect
import math
import sys
import warnings
from collections.abc import Mapping
from copy import copy
from typing import Any, ClassVar
from weakref import WeakKeyDictionary

from pathsim.events import Event, Schedule
from pathsim.exceptions import LinearizationError

from .callers import calling_simulation, depth_in_subsystems, warn_user
from .checks import number, positive, refuse
from .continuous import Matrices, at_limit, continuous_equivalent
from .parameters import Parametric
from .pathsim_internals import WiredRegister, begin_stepping, port_names, show, values
from .pathsim_types import Block
from .wiring import name_of, warn_of_wiring

# s; catches typos such as T=1e-9
SHORTEST_PERIOD = 1e-6

# PathSim resolves the events of a step by their relative time in it; with this one, other events
# at the same time follow the tick
_BEFORE_OTHERS = math.nextafter(1.0, 0.0)

_NOT_DETECTED = False, False, 1.0


def _period(T: Any) -> float:
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
_settling: WeakKeyDictionary[Any, Settling] = WeakKeyDictionary()


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
        time at which the block was last sampled, or from which a step starts, s; -inf if a run
        has only begun, nan before the first event
    stepping : bool
        whether a step has started there, and has not sampled the block
    open : bool
        whether an evaluation at the next instant makes the block act
    at_end : bool
        whether a step without stages is evaluated at its end only
    depth : int
        number of subsystems around the block
    begun : tuple
        index of the period that an aircraft has begun to fly, and its ground contact at the start
    """

    def __init__(self, block: SampledBlock):
        super().__init__(t_period=block.T)
        # not in the block, where setting an attribute is slower: every step changes them
        self.block, self.depth, self.at_end = block, 0, False
        self.settling: Any = None
        self.reset()

    def reset(self) -> None:
        super().reset()
        if not self.block:
            # `Block.off` resets the block after its events are off
            self.off()
        self.period = self.t_period = _period(self.block.T)
        self.start, self.begun = 0.0, (0, None)
        self._set((0, None, None))

    def _set(self, now: tuple[int, Any, Any]) -> None:
        """Continue from ``now``, at any time."""
        self.ahead: Any = None
        self.now = now
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
        self.reached, self.stepping, self.open = math.nan, False, False

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
        if not t <= self.reached:
            self._begin(t)
        self.join(t)
        self.reached, self.stepping, self.open = t, True, self.at_end

    def _begin(self, t: float) -> None:
        """Sample at ``t``, the start of a step that belongs to no run."""
        block = self.block
        if not self.reached > -math.inf:
            if not block._engine.history:
                begin_stepping(calling_simulation(block._engine))
            else:
                # the block was switched on, or added to the diagram, during a run
                self.join(t)
                self.reached, self.open = -math.inf, True
                block.update(t)
                block.sample(t, 0.0)
        if not t <= self.reached:
            why = f"{name_of(block)} was not sampled at {t:.9g} s, where the diagram continues: "
            refuse("pss", t, f"{why}Simulation.pss cannot fly a {type(block).__name__}")

    def estimate(self, t: float) -> float:
        self.join(t)
        return self.next() - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        begins = not (self.stepping and self.reached < t)
        if begins:
            # a run begins, maybe after one that ended within a step
            self.join(t)
            self.open = False
            if math.isnan(self.reached):
                self.reached = -math.inf
            if (sim := calling_simulation(self.block._engine)) is not None:
                warn_of_wiring(sim)
            self.block._run_begins()
        due = t >= self.due
        if self.depth and (due or (begins and self.at_latest(t))):
            self.settling.depth = max(self.settling.depth, self.depth)
        if not due or (self.open and t <= self.end):
            return _NOT_DETECTED
        time, self.end = self.next(), max(t, self.end)
        if t <= time + self.slack:
            return True, True, _BEFORE_OTHERS
        return True, False, (time - self.reached) / (t - self.reached)

    def resolve(self, t: float) -> None:
        self.open = True

    def to_checkpoint(self, prefix: str) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix)
        now = [_plain(part) for part in self.latest]
        json_data.update(period=self.period, start=self.start, now=now)
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


class SampledBlock(Block):
    """Base of the blocks that act at a sample period T (s); see `SampledPlant`, `SampledLaw`."""

    linearizable = False
    _warned = False
    _engine: Any = None

    def __init__(self, T: float):
        super().__init__()
        self.T = _period(T)
        self.clock = SampleClock(self)
        self.events: list[Event] = [self.clock]

    def linearize(self, t: float) -> Any:
        """Refused: a sampled block keeps sampling. `to_statespace` gives its linear model.

        PathSim has linearised the blocks before it; they are restored.
        """
        for caller in inspect.stack(context=0):
            if caller.function == "linearize":
                caller.frame.f_locals["self"].delinearize()
        raise LinearizationError(
            f"{type(self).__name__} is sampled and cannot run as a linear block: "
            "to_statespace gives the linear model of the diagram"
        )

    def set_solver(self, Solver: Any, parent: Any, **solver_args: Any) -> None:
        """Called by PathSim when the block is added to a simulation, with its engine."""
        clock = self.clock
        clock.leave()
        if parent is self._engine:
            return
        self._engine, clock.at_end = parent, parent.is_explicit and not parent.is_adaptive
        if self.events:
            clock.depth = depth_in_subsystems()
            clock.settling = _settling.setdefault(parent, Settling())
            others = [event for event in self.events if not isinstance(event, Settling)]
            self.events = [*others, *clock.depth * [clock.settling]]

    def _run_begins(self) -> None:
        """Called when a run begins."""

    def _act(self, t: float) -> tuple[int, Any, Any]:
        """Act at the next instant, and all others up to ``t``; return index, outputs and state."""
        raise NotImplementedError

    def update(self, t: float) -> None:
        clock = self.clock
        if clock.depth:
            clock.settling.depth = clock.settling.asked = 0
        if clock.open and clock.due <= t <= clock.end:
            clock.ahead = self._act(t)
            y = clock.ahead[1]
        else:
            if t <= clock.reached:
                # the first stage of a step; others follow, maybe at the step's end
                clock.open = False
            y = clock.now[1] if t < clock.due else clock.latest[1]
        if y is not None:
            show(self.outputs, y)

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        # a block added within a step begins with the next one
        if clock.stepping or not math.isnan(clock.reached):
            clock.reached, clock.stepping, clock.open = t, False, False

    def _late(self, t: float) -> int:
        """Number of instants up to ``t``, more than one; warn once."""
        clock = self.clock
        if not self._warned:
            self._warned = True
            warn_user(
                f"{type(self).__name__} samples every {clock.period:.9g} s, but the diagram's "
                f"step to {t:.9g} s jumps over a sample instant: time stays correct, but inputs "
                "are updated only at steps. Use a dt that divides T."
            )
        return clock.count(t)


class SampledPlant(SampledBlock):
    """Base of sampled blocks without direct feed-through: y[k+1] = f(x[k], u[k]).

    A subclass implements `advance`, and calls `start_from` with its first outputs when it is built
    and at the end of ``reset``.

    Parameters
    ----------
    T : float
        sample period in s
    """

    def __len__(self) -> int:
        return 0

    @property
    def samples(self) -> int:
        """Number of sample periods advanced since the start or the last reset."""
        return max(self.clock.latest[0] - 1, 0)

    def start_from(self, y: list[float]) -> None:
        """Show these outputs at the latest instant."""
        clock = self.clock
        clock.now = clock.now[0], y, clock.now[2]
        show(self.outputs, y)

    def latch(self, t: float) -> list[float]:
        """The inputs at ``t``, to be held."""
        return values(self.inputs)

    def advance(self, index: int, u: list[float]) -> list[float]:
        """One period with the inputs ``u``: the outputs at the instant ``index``.

        It is called again for the same period if an exception or Ctrl-C interrupted it.
        """
        raise NotImplementedError

    def _act(self, t: float) -> tuple[int, Any, Any]:
        clock = self.clock
        k, y, u = clock.now
        i, end = k, k + (1 if t <= clock.due + 2 * clock.slack else self._late(t))
        if clock.ahead:
            # a rejected or interrupted step has advanced it already
            i, y, _ = clock.ahead
        while i < end:
            if i:
                y = self.advance(i, u)
            i += 1
            clock.ahead = i, y, None
        return clock.ahead

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        if clock.open and t >= clock.due:
            i, y, _ = clock.ahead
            clock.ahead = i, y, self.latch(t)
        elif not (clock.stepping and clock.reached < t) and clock.at_latest(t):
            # a run begins at an instant: values may have been edited since the last run
            i, y, _ = clock.now
            clock.now = i, y, self.latch(t)
        # as in `SampledBlock.sample`; calling it would double the time
        if clock.stepping or not math.isnan(clock.reached):
            clock.reached, clock.stepping, clock.open = t, False, False


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

    def _begin(self) -> None:
        SampledBlock.__init__(self, self.T)
        names = dict(self.input_port_labels) if self.input_port_labels else None
        self.inputs = WiredRegister(len(self.inputs), names)
        self.clock.now = 0, None, self.initial_state()

    def _needed(self) -> tuple[str, ...]:
        """Inputs that must be connected; it may depend on which others are."""
        return self.measured

    def _run_begins(self) -> None:
        """Warn once about unconnected inputs that must be connected."""
        if self._wires_seen:
            return
        self._wires_seen = True
        missing = [name for name in self._needed() if name not in self.inputs.wired]
        if missing:
            warn_user(
                f"{type(self).__name__} measures 0 at unconnected inputs: {', '.join(missing)}"
            )

    def _configure(self) -> None:
        super()._configure()
        present = self.clock.period
        if self.events and (asked := _period(self.T)) != present:
            # a new T acts at the next reset; building with it now detects errors
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
            self._configure()

    def initial_state(self) -> Any:
        """State before the first sample: a number, or a (nested, named) tuple of numbers."""
        raise NotImplementedError

    def law(self, u: list[float], state: Any) -> tuple[list[float], Any]:
        """Outputs at an instant and the state after it, from the inputs and the state before."""
        raise NotImplementedError

    def _act(self, t: float) -> tuple[int, Any, Any]:
        clock, u = self.clock, values(self.inputs)
        k, _, state = clock.now
        y, state = self.law(u, state)
        if t <= clock.due + 2 * clock.slack:
            return k + 1, y, state
        count = self._late(t)
        for _ in range(1, count):
            y, state = self.law(u, state)
        return k + count, y, state

    def to_statespace(self, t: float) -> Matrices:
        """A, B, C, D of the continuous equivalent about the present state, without the hold.

        A LinearizationError is raised if none exists; a warning is given if the law is at a limit.
        """
        u, (k, _, state) = values(self.inputs), self.clock.latest
        if k == 0:
            # the first sample engages the law, without a bump, at the present values
            _, state = self.law(u, state)
        name = type(self).__name__
        model = continuous_equivalent(self.law, u, state, self.clock.period, name)
        inputs, outputs = port_names(self.inputs), port_names(self.outputs)
        # references are the inputs with a parameter of the same name
        references = {n: i for n, i in inputs.items() if n in vars(self._checked)}
        commands = {n: outputs[n] for n in self.commands or [*outputs][:1]}
        with warnings.catch_warnings():
            # the copy would repeat warnings that the block has already issued
            warnings.simplefilter("ignore")
            idle = at_limit(copy(self).law, u, state, model, references, commands)
        if idle:
            why = f"{name} is at a limit or on a ramp: in its linear model "
            warn_user(f"{why}{' and '.join(idle)} has no effect")
        return model
