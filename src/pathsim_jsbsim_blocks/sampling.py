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
result is kept when the next step begins, so the order of blocks and events does not matter.

In a step without solver stages the first evaluation of the graph is the one at the step's end, and
both kinds act there: one pass through the graph instead of two. Whether a step has stages is known
only to the `Simulation`; blocks inside a `Subsystem`, in adaptive runs and in diagrams with
continuous states act in the resolution of an event, which is always right.
"""

from __future__ import annotations

import math
import sys
import warnings
import weakref
from typing import Any

from pathsim import Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from .checks import positive

BEFORE_OTHER_EVENTS = math.nextafter(1.0, 0.0)


class SampleClock(Event):
    """Event on the sample instants of one block.

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
        super().__init__()
        self.reset()

    def __bool__(self) -> bool:
        return self._active and self._block._active

    def reset(self) -> None:
        super().reset()
        self.period = self._block.T
        self.start = 0.0
        self.index = self._first
        self.step_start = 0.0
        self._detected_at = 0.0

    def instant(self, index: int) -> float:
        """Time of sample ``index`` in s."""
        return self.start + index * self.period

    def slack(self, t: float) -> float:
        """How far the diagram's accumulated clock may be from an instant, in s."""
        return max(1e-13, min(1e-9 * abs(t), 0.01 * self.period))

    def due(self, t: float) -> int:
        """Number of instants up to ``t`` at which the block has not acted yet."""
        limit = t + self.slack(t)
        n = 0
        while self.start + (self.index + n) * self.period <= limit:
            n += 1
        return n

    def buffer(self, t: float) -> None:
        self.step_start = t
        self._block.begin_step(t)
        if t > self.instant(self.index) + self.slack(t):
            # switched off for a while, or reset to a later time: go on from here
            self.start = t - (self.index - 1) * self.period

    def estimate(self, t: float) -> float:
        return self.instant(self.index) - t

    def detect(self, t: float) -> tuple[bool, bool, float]:
        if self._block.acted_in_update:
            return False, False, 1.0
        instant = self.instant(self.index)
        tol = self.slack(t)
        if instant > t + tol:
            return False, False, 1.0
        self._detected_at = t
        if abs(instant - t) <= tol:
            return True, True, BEFORE_OTHER_EVENTS
        return True, False, (instant - self.step_start) / (t - self.step_start)

    def resolve(self, t: float) -> None:
        self._block.act(self._detected_at)

    def to_checkpoint(self, prefix: str) -> tuple[dict, dict]:
        json_data, npz_data = super().to_checkpoint(prefix)
        json_data.update(period=self.period, start=self.start, index=self.index)
        return json_data, npz_data

    def load_checkpoint(self, prefix: str, json_data: dict, npz: Any) -> None:
        super().load_checkpoint(prefix, json_data, npz)
        self.period, self.start = json_data["period"], json_data["start"]
        self.index = json_data["index"]


class SampledBlock(Block):
    """Base of all blocks that act at a sample period T (s)."""

    linearizable = False

    def __init__(self, T: float, first: int):
        super().__init__()
        self.T = positive("T", T)
        self.clock = SampleClock(self, first)
        self.events = [self.clock]
        self._simulation: weakref.ref[Simulation] | None = None
        self._one_pass = False
        self._armed = False
        self.acted_in_update = False
        self._warned = False

    def set_solver(self, Solver, parent, **solver_args) -> None:
        # Only a block that stands in a Simulation itself, not in a Subsystem, may act in update()
        owner = sys._getframe(1).f_locals.get("self")
        self._simulation = weakref.ref(owner) if isinstance(owner, Simulation) else None

    def reset(self) -> None:
        super().reset()
        self._armed = False
        self.acted_in_update = False

    def begin_step(self, t: float) -> None:
        """A step of the diagram starts at ``t``; all blocks hold their values at ``t``."""
        simulation = self._simulation() if self._simulation is not None else None
        self._one_pass = (simulation is not None and not simulation._blocks_dyn
                          and not simulation.engine.is_adaptive)
        self._armed = True
        self.acted_in_update = False

    def act(self, t: float) -> None:
        """Act on all instants up to ``t``."""
        raise NotImplementedError

    def _warn_of_late_instants(self, t: float) -> None:
        clock = self.clock
        if self._warned or abs(clock.instant(clock.index) - t) <= clock.slack(t):
            return
        self._warned = True
        warnings.warn(
            f"{type(self).__name__} samples every {clock.period:.9g} s, but the diagram's step "
            f"from {clock.step_start:.9g} s to {t:.9g} s jumps over a sample instant: time is "
            "kept, but the inputs there are not known. Use a dt that divides T.",
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

    def update(self, t: float) -> None:
        if not self._armed:
            return
        self._armed = False
        clock = self.clock
        if not self._latched:
            start = clock.step_start
            if start >= clock.instant(clock.index - 1) - clock.slack(start):
                self.latch()
                self._latched = True
        if self._one_pass:
            self.acted_in_update = True
            self.act(t)

    def act(self, t: float) -> None:
        n = self.clock.due(t)
        if not n:
            return
        self._warn_of_late_instants(t)
        for _ in range(n):
            self.advance()
            self.clock.index += 1
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

    A subclass implements `initial_state` and the pure function `sample`.
    """

    def __init__(self, T: float):
        super().__init__(T, first=0)
        self._start_law()

    def _start_law(self) -> None:
        self._state = self._next_state = self.initial_state()
        # the first instant is t = 0, which every first evaluation of the graph belongs to
        self._due = 1

    def initial_state(self) -> Any:
        """State before the first sample."""
        raise NotImplementedError

    def sample(self, u: list[float], state: Any) -> tuple[list[float], Any]:
        """Outputs at an instant and the state after it, from the inputs and the state before."""
        raise NotImplementedError

    def reset(self) -> None:
        super().reset()
        self._start_law()

    def begin_step(self, t: float) -> None:
        if self._due:
            clock = self.clock
            # a step that starts before the instant is a rejected one taken anew
            if t >= clock.instant(clock.index) - clock.slack(t):
                self._state = self._next_state
                clock.index += self._due
            self._due = 0
        super().begin_step(t)

    def update(self, t: float) -> None:
        if self._armed:
            self._armed = False
            if self._one_pass:
                self.acted_in_update = True
                self.act(t)
        if self._due:
            state = self._state
            u = self.inputs._data.tolist()
            for _ in range(self._due):
                y, state = self.sample(u, state)
            self._next_state = state
            self.outputs.update_from_array(y)

    def act(self, t: float) -> None:
        self._due = self.clock.due(t)
        if self._due:
            self._warn_of_late_instants(t)
