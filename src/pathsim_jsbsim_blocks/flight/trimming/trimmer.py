"""`Trimmer`: trims one airframe again and again."""

from __future__ import annotations

import dataclasses
import math
import weakref
from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from ..._core.aircraft_ports import property_of
from ..airframe import Airframe
from . import check, ground, jsbsim
from .check import HandsOff
from .condition import TrimCondition
from .diagnosis import Ending, diagnose, no_fuel, with_throttle_at_end
from .equations import Effort, SteadyFlight, size
from .failure import LIMITS, failure
from .initial import engines_off, fill, initialise, is_initial, properties
from .search import POLISHED, Reached, at_one_limit, descend
from .state import STATE, TrimState, not_finite, read_state

# initial guesses, tried until one leads to a trim: alpha in deg, throttle
_GUESSES = ((3.0, 0.5), (9.0, 0.9), (-1.0, 0.1))

# strengths of JSBSim's turbulence by type, of which milspec and tustin are the last, and its gust
_CULP = 2.0
_TURBULENCE = "atmosphere/turb-gain"
_MILSPEC = "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"
_GUST = "atmosphere/cosine-gust/start"

# bisections of the throttle between too little and too much thrust
_HALVINGS = 10

# factor on the airspeed for the trim from which the last search starts
_FASTER = 1.15


class Seed(NamedTuple):
    """The end of a search, as the start of the next one."""

    names: list[str]
    x: np.ndarray
    slopes: np.ndarray
    has_memory: bool
    in_time: bool
    trimmed: bool

    def set_up(self, flight: SteadyFlight) -> bool:
        """Adapt a flight to the model as its last search did; False if it has other unknowns."""
        without = "elevator" in self.names and "pitch_trim" in flight.names
        if without and not self.trimmed:
            # a pitch trim without effect there, at almost no airspeed, may have one here
            return False
        names = ["elevator" if without and n == "pitch_trim" else n for n in flight.names]
        if names != self.names or len(self.slopes) != len(flight.used):
            return False
        if without:
            flight.without_pitch_trim()
        flight.has_memory = self.has_memory
        return True


class Trimmer:
    """Trims an airframe repeatedly.

    A trim begins with a freshly loaded model. A warm one continues from the last trim, with the
    model in its present state.
    """

    def __init__(self, airframe: Airframe):
        # the table of trimmers must not keep an airframe alive
        self.airframe: Airframe = weakref.proxy(airframe)
        # whether a search has run on the executive, and has left it unfit as a starting point
        self._used = self._spent = False
        self._seed: Seed | None = None
        self._leaves_traces = True
        # whether the last trim used steps of time (`SteadyFlight`)
        self.in_time = False
        # its residuals above their tolerances
        self.excess: dict[str, float] = {}
        # rate of the fastest propeller of the last trim, times the step
        self.per_step = 0.0
        # a twin for short flights
        self._stand_in: Airframe | None = None

    @classmethod
    def of(cls, airframe: Airframe) -> Trimmer:
        """The trimmer of an airframe, the same one each time."""
        if airframe not in _trimmers:
            _trimmers[airframe] = cls(airframe)
        return _trimmers[airframe]

    def trim(
        self,
        condition: TrimCondition,
        setup: Mapping[str, float] | None = None,
        *,
        warm: bool = False,
        fly: float = check.SHORT,
        like: Trimmer | None = None,
    ) -> tuple[TrimState, HandsOff | None]:
        """Trim, and fly a second aircraft from the trim for ``fly`` s; None without a flight.

        There is no flight if the trim repeats the last one of ``like``.
        """
        self._effort, self.excess = Effort(), {}
        by_jsbsim = condition.mode in ("none", "ground") or condition.searched_by == "jsbsim"
        if self._spent or (self._used and (by_jsbsim or not warm)):
            self._renew()
        seed, self._seed = self._seed if warm else None, None
        # unusable until the Newton search succeeds
        is_used, self._used, self._spent = self._used, True, True
        try:
            self._initialise(condition, setup)
            self._refuse_impossible(condition)
            if not by_jsbsim:
                ways = [False, True]
                if like is not None:
                    ways, fly = [like.in_time], 0.0
                elif self.airframe.has_kind("turboprop"):
                    # turboprops have power only if time advances
                    ways = [True]
                return self._by_newton(condition, setup, seed, is_used, ways, fly)
        finally:
            if not by_jsbsim:
                self.airframe.freeze_fuel(False)
        state = self._by_jsbsim(condition)
        if fly <= check.SHORT or condition.mode in ("none", "ground", "pull-up"):
            return state, None
        twin = self.airframe.twin()
        Trimmer(twin).trim(condition, setup)
        return state, check.fly(twin, condition, fly)

    def _renew(self) -> None:
        self.airframe.renew()
        self._used = self._spent = False
        self._seed = None

    def _initialise(self, condition: TrimCondition, setup: Mapping[str, float] | None) -> None:
        """Write a condition, start the engines and initialise; refuse engines without fuel."""
        airframe = self.airframe
        settings = properties(airframe, condition, setup)
        # without a search, initial conditions of a setup replace the condition's
        initial = {}
        if condition.mode == "none":
            initial = {n: v for n, v in settings.items() if is_initial(airframe.canonical(n))}
        airframe.write({n: v for n, v in settings.items() if n not in initial}, "setup")
        airframe.stopped = engines_off(airframe, condition, settings)
        if condition.mode in ("none", "ground"):
            self._start(airframe, condition, initial)
        elif condition.searched_by == "jsbsim":
            self._start(airframe, condition)
            if airframe.without_fuel():
                # on a twin, so that JSBSim's search starts with an unchanged model
                twin = airframe.twin()
                twin.resemble(airframe)
                with twin.fuel_frozen():
                    self._start_with_fuel(twin, condition)
        else:
            airframe.freeze_fuel()
            self._start_with_fuel(airframe, condition)

    def _start(
        self, airframe: Airframe, condition: TrimCondition, initial: Mapping[str, float] = {}
    ) -> None:
        with airframe.engines_stopped():
            initialise(airframe, condition, condition.heading, initial)

    def _start_with_fuel(self, airframe: Airframe, condition: TrimCondition) -> None:
        """Initialise, and refuse engines without fuel; in a glide they do not run."""
        self._start(airframe, condition)
        without = fill(airframe)
        if without and condition.mode != "glide":
            raise no_fuel(airframe, condition, without)
        if without:
            airframe.stopped |= {engine.number for engine in without}
            self._start(airframe, condition)

    def _refuse_impossible(self, condition: TrimCondition) -> None:
        """Raise TrimError if no search can succeed."""
        airframe, fdm = self.airframe, self.airframe.fdm
        height = fdm[property_of("h_agl")]
        # a reset file of an aircraft at rest may have its reference point in the ground
        depths = {"ground": math.inf, "none": fdm["metrics/cbarw-ft"]}
        if height < -depths.get(condition.mode, 0.0):
            why = f"it starts {-height:.6g} ft below the terrain, whose elevation is "
            why += f"{fdm['ic/terrain-elevation-ft']:.6g} ft"
            raise failure(airframe, condition, "ground", why)
        if condition.mode == "none":
            return
        kind = fdm["atmosphere/turb-type"]
        strengths = [_GUST, *([_MILSPEC if kind > _CULP else _TURBULENCE] if kind else [])]
        if names := [name for name in strengths if fdm[name]]:
            why = f"{', '.join(names)} would act during the search: put turbulence and gusts into "
            why += "properties, which are written after the trim"
            raise failure(airframe, condition, "turbulence", why)
        mach = fdm[STATE["mach"]]
        if mach >= 1.0 and airframe.of_engines("propeller-rpm"):
            why = f"Mach {mach:.3g}: propellers give thrust below Mach 1 only"
            raise failure(airframe, condition, "mach", why)
        # a search may still make other quantities, such as thrust, finite
        if faults := [name for name in LIMITS if not math.isfinite(fdm[STATE[name]])]:
            why = f"{', '.join(faults)} not finite at this condition"
            raise failure(airframe, condition, "no convergence", why)
        has_power = len(airframe.stopped) < airframe.engines
        if not has_power and condition.mode != "ground" and condition.balance == "throttle":
            raise failure(airframe, condition, "thrust")

    def _by_jsbsim(self, condition: TrimCondition) -> TrimState:
        """Trim by JSBSim's own search or on the ground; in mode "none" the initial state."""
        airframe, unknowns = self.airframe, tuple[str, ...]()
        if condition.mode == "ground" and condition.searched_by == "newton":
            with airframe.engines_stopped():
                unknowns = ground.let_down(airframe, condition)
        elif condition.mode != "none":
            with airframe.engines_stopped():
                unknowns = jsbsim.find(airframe, condition)
        state = read_state(airframe, condition, unknowns)
        if faults := not_finite(state):
            why = f"{', '.join(faults)} not finite after the trim"
            raise failure(airframe, condition, "no convergence", why)
        return state

    def _by_newton(
        self,
        condition: TrimCondition,
        setup: Mapping[str, float] | None,
        seed: Seed | None,
        is_used: bool,
        ways: Sequence[bool],
        fly: float,
    ) -> tuple[TrimState, HandsOff | None]:
        """The first trim from the seed or a guess that holds in a short flight."""
        airframe = self.airframe
        elevator = airframe.fdm[STATE["elevator"]]
        if seed is not None and seed.trimmed:
            with airframe.engines_stopped():
                ending = self._from_seed(condition, seed, fly)
            if ending and ending.holds(airframe):
                return ending.state, ending.flown
        for in_time in ways:
            if is_used and (in_time != ways[0] or self._leaves_traces):
                self._renew()
                self._initialise(condition, setup)
            is_used = True
            with airframe.engines_stopped():
                ending = self._from_guesses(condition, seed, in_time, fly)
                if ending.holds(airframe):
                    return ending.state, ending.flown
                # only steps in time may change what a flight has shown
                if in_time == ways[-1] or not (ending.flown and ending.flown.moves):
                    error = diagnose(airframe, ending)
                    break
        self._used, self._spent = True, self._leaves_traces
        # a search that moves the pitch trim instead would keep it
        airframe.fdm[STATE["elevator"]] = elevator
        raise error

    def _from_seed(self, condition: TrimCondition, seed: Seed, fly: float) -> Ending | None:
        """The end of a search near the last trim; None without full precision."""
        flight = SteadyFlight(self.airframe, condition, self._effort, seed.in_time)
        if not seed.set_up(flight):
            return None
        outcome = descend(flight, seed.x, seed.slopes)
        ending = self._ending(condition, flight, outcome, fly) if outcome.size <= POLISHED else None
        if not (ending and ending.holds(self.airframe)):
            self._effort.steps = 0
        return ending

    def _from_guesses(
        self, condition: TrimCondition, seed: Seed | None, in_time: bool, fly: float
    ) -> Ending:
        flight = SteadyFlight(self.airframe, condition, self._effort, in_time)
        slopes = None
        if seed and not seed.trimmed and seed.in_time == in_time and seed.set_up(flight):
            slopes = seed.slopes
        else:
            flight.try_out()
        self._leaves_traces = flight.leaves_traces
        best: Reached | None = None
        for outcome in self._ends(flight, slopes):
            best = outcome if best is None or outcome.size < best.size else best
            if best.size <= 1.0 or self._effort.over or self.airframe.not_running():
                break
        assert best is not None
        self._keep(flight, best, trimmed=False)
        return self._ending(condition, flight, best, fly)

    def _ends(self, flight: SteadyFlight, slopes: np.ndarray | None) -> Iterator[Reached]:
        """Ends of searches from the first guesses in turn; the first search uses ``slopes``."""
        ends: list[Reached] = []
        for alpha, throttle in _GUESSES:
            outcome = descend(flight, flight.guess(alpha, throttle), slopes, ends=ends)
            yield outcome
            if ends and at_one_limit(flight, ends[-1], outcome):
                # two searches from distant guesses end at the same limit: so would the others
                break
            ends.append(outcome)
            slopes = outcome.slopes
        if (x := _within_thrust(flight, ends[-1])) is not None:
            yield descend(flight, x)
        i = flight.names.index("alpha")
        low, high = flight.low[i], flight.high[i]
        if "speed" in flight.names or all(low < end.x[i] < high for end in ends):
            return
        # if lift is insufficient, a trim at a higher speed is a better start than any guess
        speed = flight.given["speed"]
        flight.given["speed"] = _FASTER * speed
        faster = descend(flight, flight.guess(*_GUESSES[0]), slopes)
        flight.given["speed"] = speed
        if faster.size <= 1.0:
            yield descend(flight, faster.x, faster.slopes, ends=ends)

    def _ending(
        self, condition: TrimCondition, flight: SteadyFlight, reached: Reached, fly: float
    ) -> Ending:
        """The airframe at the end of a search, and what a flight from there shows."""
        airframe, light = self.airframe, None
        # reset, because an exhausted effort would keep the propellers from settling
        self._effort.steps = 0
        if flight.propellers.per_step > 2.0:
            # before the last state is set, because it flies trials
            flight.settled(reached.x)
            light = flight.propellers.too_light()
        # the last state written need not be the best
        r, residuals = flight.arrive(reached.x)
        if reached.size <= 1.0 < size(r):
            # a slow engine (pc7) had not quite settled: search on from the settled state
            reached = descend(flight, reached.x, reached.slopes)
            r, residuals = flight.arrive(reached.x)
        # the flight begins here: settling the propellers has advanced the clock
        airframe.fdm.set_sim_time(0.0)
        state = read_state(airframe, condition, tuple(flight.names))
        state = dataclasses.replace(state, **residuals)  # type: ignore[arg-type]
        touches = airframe.fdm["forces/fbz-gear-lbs"] != 0.0
        ending = Ending(flight, reached.x, r, residuals, state, light, touches)
        # residuals above the tolerance are judged by their effect
        fly = fly if ending.converged else max(fly, check.LONG)
        if ending.worth_flying(airframe) and fly and condition.mode != "pull-up":
            flown, other = self._flown(condition, flight, reached.x, fly)
            ending = ending._replace(flown=flown, other=other)
        if ending.holds(airframe):
            self._keep(flight, reached, trimmed=True)
            self.excess = ending.excess
            self.in_time, self.per_step = flight.in_time, flight.propellers.per_step
            self._leaves_traces, self._spent = flight.leaves_traces, False
        return ending

    def _keep(self, flight: SteadyFlight, outcome: Reached, *, trimmed: bool) -> None:
        """Store the end of a search for the next trim."""
        if outcome.slopes is not None:
            end = outcome.x, outcome.slopes, flight.has_memory, flight.in_time
            self._seed = Seed(flight.names, *end, trimmed)

    def _flown(
        self, condition: TrimCondition, flight: SteadyFlight, x: np.ndarray, fly: float
    ) -> tuple[HandsOff, Airframe]:
        """A flight of a second aircraft from the airframe's trim."""
        trial_airframe = self._stand_in = self._stand_in or self.airframe.twin()
        trial_airframe.resemble(self.airframe)
        with trial_airframe.fuel_frozen(), trial_airframe.engines_stopped():
            initialise(trial_airframe, condition, condition.heading)
            trial_airframe.fdm[STATE["elevator"]] = self.airframe.fdm[STATE["elevator"]]
            trial = SteadyFlight(trial_airframe, condition, Effort(), flight.in_time)
            if "elevator" in flight.names:
                trial.without_pitch_trim()
            trial.has_memory = flight.has_memory
            trial.hold(x)
        flown = check.fly(trial_airframe, condition, fly)
        if flown.moves or flown.leaves or flown.starved or fly > check.SHORT:
            self._stand_in = None
        return flown, trial_airframe


_trimmers: weakref.WeakKeyDictionary[Airframe, Trimmer] = weakref.WeakKeyDictionary()


def _within_thrust(flight: SteadyFlight, outcome: Reached) -> np.ndarray | None:
    """The unknowns with a throttle between too much and too little thrust, if there is one.

    Above a torque limit the throttle has no effect, so a search cannot return from there.
    """
    if "throttle" not in flight.names or flight.effort.over:
        return None
    i, too_much = flight.names.index("throttle"), outcome.residuals[0] > 0.0
    x = with_throttle_at_end(flight, outcome.x, outcome.residuals)
    low_end, end = outcome.x[i], x[i]
    if low_end == end or (flight.settled(x)[0] > 0.0) == too_much:
        return None
    for _ in range(_HALVINGS):
        x[i] = 0.5 * (low_end + end)
        if (flight.settled(x)[0] > 0.0) == too_much:
            low_end = x[i]
        else:
            end = x[i]
    return x
