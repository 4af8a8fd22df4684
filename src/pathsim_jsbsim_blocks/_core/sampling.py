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

The clock of a block, `SampleClock`, tells when it acts.
"""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Mapping
from copy import copy
from typing import TYPE_CHECKING, Any, ClassVar

from pathsim.events import Event
from pathsim.exceptions import LinearizationError

from .callers import depth_in_subsystems, warn_user
from .clock import (
    BETWEEN,
    IDLE,
    INSTANT,
    START,
    STEP,
    SampleClock,
    Settling,
    sample_period,
    settlings,
)
from .parameters import Parametric
from .pathsim_internals import WiredRegister, port_names, show, values
from .pathsim_types import Block

if TYPE_CHECKING:
    from .continuous import Matrices


class SampledBlock(Block):
    """Base of the blocks that act at a sample period T (s); see `SampledPlant`, `SampledLaw`."""

    linearizable = False
    _warned = False
    _engine: Any = None

    def __init__(self, T: float):
        super().__init__()
        self.T = sample_period(T)
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
        self._engine = parent
        clock.first_phase = INSTANT if parent.is_explicit and not parent.is_adaptive else STEP
        if self.events:
            clock.depth = depth_in_subsystems()
            clock.settling = settlings.setdefault(parent, Settling())
            events = [event for event in self.events if not isinstance(event, Settling)]
            self.events = [*events, *clock.depth * [clock.settling]]

    def _run_begins(self) -> None:
        """Called when a run begins."""

    def _act(self, t: float) -> tuple[int, Any, Any]:
        """Act at the next instant, and all others up to ``t``; return index, outputs and state."""
        raise NotImplementedError

    def update(self, t: float) -> None:
        clock = self.clock
        if clock.depth:
            clock.settling.depth = clock.settling.asked = 0
        phase = clock.phase
        if (phase is INSTANT or phase is START) and clock.due <= t <= clock.end:
            clock.ahead = self._act(t)
            y = clock.ahead[1]
        else:
            if phase is INSTANT and t <= clock.reached:
                # the first stage of a step; others follow, maybe at the step's end
                clock.phase = STEP
            y = clock.now[1] if t < clock.due else clock.latest[1]
        if y is not None:
            show(self.outputs, y)

    def sample(self, t: float, dt: float) -> None:
        clock = self.clock
        # a block added within a step begins with the next one
        if clock.phase is not IDLE:
            clock.reached, clock.phase = t, BETWEEN

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
        phase = clock.phase
        if (phase is INSTANT or phase is START) and t >= clock.due:
            i, y, _ = clock.ahead
            clock.ahead = i, y, self.latch(t)
        elif phase not in (STEP, INSTANT) and clock.at_latest(t):
            # a run begins at an instant: values may have been edited since the last run
            i, y, _ = clock.now
            clock.now = i, y, self.latch(t)
        # as in `SampledBlock.sample`; calling it would double the time
        if phase is not IDLE:
            clock.reached, clock.phase = t, BETWEEN


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
        if self.events and (new_period := sample_period(self.T)) != present:
            # a new T acts at the next reset; building with it now detects errors
            try:
                self.clock.period = new_period
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
        from .continuous import at_limit, continuous_equivalent

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
