"""`Settling`: engines and propellers brought to their steady state in a held flight.

JSBSim's own search, ``get_steady_state``, takes steps of 0.5 s whatever the propeller, and returns
what it has: for a light propeller, whose time constant is shorter, numbers beyond all bounds. A
propeller's speed cannot be written, but a step of JSBSim adds rate times length to it, so a step as
long as the time constant is a step of Newton's method. The time constant follows from the last two
steps (Barzilai and Borwein), starting with a step in which nothing moves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from .airframe import Airframe

# s: first step, in which no propeller moves far; longest step, the lag of the manifold pressure (at
# 5 s the trim of the Boeing314 fails)
_FIRST = 1e-6
_LONGEST = 1.0

# maximum growth of a step, and maximum relative change of a speed in it: an engine whose lag is
# jumped over may stall (Boeing314 at 0.1); with a growth of 100 its trim fails
_GROWTH = 8.0
_LARGE = 0.02

# fraction of a rate that remains after a step that shows a smaller one
_DECAY = 0.7

# smallest relative change of a speed that reveals its time constant
_CLEAR = 1e-7

# rpm, and rpm per s, below which a propeller stands, though JSBSim lets it creep
_STANDS = 1.0

# steps in a row without a change of speed that are a steady state, and maximum steps
_QUIET = 3
_STEPS = 6000

# maximum steps at fixed pitch of an engine whose torque limiter may keep it from settling
_LIMITER = 1000

# steps in a row of the check; an odd number reveals a speed that alternates
_ROW = 41

# a torque limiter may open and close endlessly: rows to detect this, and the relative change per
# row up to which the propellers then count as steady
_ROWS_OF_A_CYCLE = 12
_CYCLE = 1e-4

# s of cranking after which an engine runs if it ever does (p51d: 0.3)
_CRANKING = 2.0

# substeps up to which a propeller can be flown; beyond, its moment of inertia is missing
MOST_SUBSTEPS = 100

# relative change of a speed in a row of flown steps, below which they follow the propeller
_FOLLOWS = 1e-3


class Settling:
    """Settles the engines and propellers of an airframe at its present state.

    ``spend`` is told the steps of JSBSim that each attempt takes; ``over`` stops attempts.
    """

    def __init__(
        self,
        airframe: Airframe,
        spend: Callable[[int], None] = lambda steps: None,
        over: Callable[[], bool] = lambda: False,
    ):
        self._airframe, self._spend, self._over = airframe, spend, over
        speeds, pitches = (airframe.of_engines(name) for name in ("propeller-rpm", "blade-angle"))
        self.required = bool(speeds or pitches)
        self._speeds = airframe.reader_of(speeds)
        self._pitches = airframe.reader_of(pitches)
        self._others = airframe.reader_of(pitches + airframe.of_engines("n1"))
        # 1 / time constant of each propeller, 1/s, at the last clear change
        self.rates = [0.0] * len(speeds)
        self._engines = [int(name.partition("[")[2].partition("]")[0]) for name in speeds]
        # whether an engine may have a torque limiter, and whether it has opened and closed
        self._has_limiter, self._limited = airframe.has_kind("turboprop"), False
        # whether the last attempt ended in a steady state, and the remaining steps
        self.steady, self._remaining = True, _STEPS

    def start(self, crank: bool = True) -> None:
        """Restart engines that have stopped, for example at a low throttle of an earlier guess."""
        airframe = self._airframe
        if not airframe.not_running():
            return
        # a propeller at rest has rates of 10^7 / s, whose steps are too short to show any other
        self.rates = [0.0] * len(self.rates)
        with airframe.governors_off():
            airframe.start_engines()
        pistons = [e.number for e in airframe.engine_list if e.type == "piston"]
        idle = [i for i in airframe.not_running() if i in pistons]
        if not idle or not crank:
            return
        # JSBSim's start uses steps of 0.5 s, in which some engines stall: crank them instead
        for i in idle:
            airframe.crank(i, starter=True)
        with airframe.held():
            for _ in range(round(_CRANKING / airframe.dt)):
                airframe.fdm.run()
                if not airframe.not_running():
                    break
        for i in idle:
            airframe.crank(i, starter=False)

    def settle(self, tolerance: float = 1e-10) -> bool:
        """Settle until a row of steps changes nothing by more than a relative tolerance."""
        rows: list[list[float]] = []
        cycles, still, was_fixed = False, True, False
        self.steady, self._remaining = False, _STEPS
        with self._airframe.held():
            while self._remaining > 0 and not self._over():
                # at first, and where a governor has reached the end of its range; the long steps
                # would keep a torque limiter from settling
                slow = len(rows) == _ROWS_OF_A_CYCLE and not cycles
                if (still and not was_fixed and not self._limited) or slow:
                    self._settle_at_fixed_pitch(tolerance)
                start, pitch = self._all(), self._pitches()
                # the check, and the only steps in which governors and the model's systems act
                self._run(_ROW, min(self._airframe.dt, self._time_constant()))
                rows.append(self._all())
                change, cycles = _change(rows[-1], start), _limit_cycles(rows)
                if change <= tolerance or (cycles and change <= _CYCLE):
                    self.steady = True
                    break
                was_fixed, still = still, pitch == self._pitches()
        self._limited = cycles
        return self.steady

    def _all(self) -> list[float]:
        """Speeds, blade angles and n1; a propeller that stands has no speed."""
        return [x if abs(x) >= _STANDS else 0.0 for x in self._speeds()] + self._others()

    def _time_constant(self) -> float:
        """The time constant of the fastest propeller, s, up to the longest step."""
        fastest = max(self.rates, default=0.0)
        return min(1.0 / fastest, _LONGEST) if fastest > 0.0 else _LONGEST

    def _run(self, steps: int, dt: float) -> None:
        fdm = self._airframe.fdm
        fdm.set_dt(dt)
        try:
            for _ in range(steps):
                fdm.run()
        finally:
            fdm.set_dt(self._airframe.dt)
        self._remaining -= steps
        self._spend(steps)

    def _settle_at_fixed_pitch(self, tolerance: float) -> None:
        """Steps as long as the time constant of the fastest propeller, governors off."""
        speeds, dt, quiet = self._speeds(), _FIRST, 0
        slopes: list[tuple[float, float]] = []  # speeds before a step, and their rates in it
        reserve = max(self._remaining - _LIMITER, 0) if self._has_limiter else 0
        with self._airframe.governors_off():
            while quiet < _QUIET and self._remaining > reserve:
                self._run(1, dt)
                new_speeds, previous = self._speeds(), slopes
                slopes = [(a, (b - a) / dt) for a, b in zip(speeds, new_speeds, strict=True)]
                self._learn(previous, slopes)
                speeds = new_speeds
                # the relative change per s
                pairs = zip(speeds, slopes, strict=True)
                paces = [abs(rate) / max(abs(x), 1.0) for x, (_, rate) in pairs]
                pace = max(paces)
                if not math.isfinite(pace):
                    break
                longest = self._time_constant()
                # a step too short for a change says nothing
                is_quiet = dt >= 0.1 * longest and all(
                    rate * dt <= tolerance or max(abs(x), rate) < _STANDS
                    for x, rate in zip(speeds, paces, strict=True)
                )
                quiet = quiet + 1 if is_quiet else 0
                dt = min(longest, _GROWTH * dt, _LARGE / max(pace, 1e-9))

    def _learn(
        self, previous: list[tuple[float, float]], slopes: list[tuple[float, float]]
    ) -> None:
        """Update the rates of the propellers from two steps, if these are clear."""
        for i, ((x, dx), (y, dy)) in enumerate(zip(previous, slopes, strict=False)):
            if abs(y - x) > _CLEAR * max(abs(y), 1.0):
                # a propeller that follows a lagging engine shows the rate of the engine, or seems
                # unstable, as beyond a kink of its tables: lower its rate slowly
                self.rates[i] = max((dx - dy) / (y - x), _DECAY * self.rates[i])

    @property
    def per_step(self) -> float:
        """Rate of the fastest propeller times the flight's step.

        A step multiplies a deviation of the speed by 1 minus this: it grows above 2.
        """
        return max(self.rates, default=0.0) * self._airframe.dt

    def too_light(self) -> tuple[int, int] | None:
        """A propeller that flown steps cannot follow, and substeps of each that can; or None.

        It flies them from the steady state, which it may leave.
        """
        # without a steady state the rates are those of a disturbance, turbulence for one
        if not self.steady or not self.per_step > 2.0 or self._follows(1):
            return None
        substeps = 2 ** math.ceil(math.log2(self.per_step))
        while substeps <= MOST_SUBSTEPS and not self._follows(substeps):
            substeps *= 2
        return self._engines[self.rates.index(max(self.rates))], substeps

    def _follows(self, substeps: int) -> bool:
        """Whether the speeds stay in flown steps divided into substeps."""
        airframe, self._remaining = self._airframe, _STEPS
        with airframe.held(), airframe.governors_off():
            self._settle_at_fixed_pitch(1e-10)
            speeds = self._speeds()
            # enough for any growth to show
            self._run(10 * _ROW, airframe.dt / substeps)
            return _change(self._speeds(), speeds) <= _FOLLOWS


def _change(new: Sequence[float], old: Sequence[float]) -> float:
    """The maximum relative change; infinite if one is not finite."""
    pairs = zip(new, old, strict=True)
    change = max((abs(a - b) / max(abs(a), 1.0) for a, b in pairs), default=0.0)
    return change if math.isfinite(change) else math.inf


def _limit_cycles(rows: Sequence[list[float]]) -> bool:
    """Whether quantities oscillate: steps between rows do not decay, and the drift stays small."""
    few = np.array(rows[-_ROWS_OF_A_CYCLE:])
    if len(few) < _ROWS_OF_A_CYCLE:
        return False
    steps = abs(np.diff(few, axis=0)).max(axis=1)
    far = abs(few - few[0]).max(axis=1)
    half = len(steps) // 2
    return bool(steps[half:].max() > 0.5 * steps[:half].max() and far.max() < 0.25 * steps.sum())
