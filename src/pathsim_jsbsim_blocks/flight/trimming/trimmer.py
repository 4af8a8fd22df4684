"""`Trimmer`: trims one airframe again and again, by JSBSim's search or the Newton search."""

from __future__ import annotations

import dataclasses
import math
import weakref
from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import TrimError
from ..airframe import Airframe
from .condition import TrimCondition
from .failure import failure
from .initial import engines_off, initialise, is_initial, properties
from .jsbsim import MOVED, find, refuse_hopeless
from .newton import Effort, Found, Search, Seed
from .state import STATE, TrimState, not_finite, read_state
from .steady import what_moves

# what the Newton search moves -> the limit that it reaches
_REASONS = {
    "throttle": "thrust",
    "alpha": "alpha limit",
    "pitch_trim": "elevator",
    "elevator": "elevator",
    "phi": "bank",
    "beta": "sideslip",
    "gamma": "path angle",
}
_ANGLES = ("alpha", "phi", "beta", "gamma")

# largest relative difference between two initialisations of the same state
_ROUNDING = 1e-12


class Trimmer:
    """Trims an airframe, and keeps what its next trim depends on."""

    def __init__(self, airframe: Airframe):
        # the table of trimmers must keep no airframe alive
        self.airframe: Airframe = weakref.proxy(airframe)
        # of the last trim's Newton searches
        self.effort = Effort()
        self.forget()

    @classmethod
    def of(cls, airframe: Airframe) -> Trimmer:
        """The trimmer of an airframe, the same one each time."""
        if airframe not in _trimmers:
            _trimmers[airframe] = cls(airframe)
        return _trimmers[airframe]

    def forget(self) -> None:
        """The executive is as after loading."""
        # whether a search has run on the executive, and has left it unusable as a start
        self._used = self.spent = False
        # where the last Newton search found its trim
        self._seed: Seed | None = None

    def renew(self) -> None:
        self.airframe.renew()
        self.forget()

    def trim(
        self, condition: TrimCondition, setup: Mapping[str, float] | None, warm: bool = False
    ) -> TrimState:
        self.effort = Effort()
        return self._trim(condition, setup, warm)

    def _trim(
        self, condition: TrimCondition, setup: Mapping[str, float] | None, warm: bool
    ) -> TrimState:
        airframe = self.airframe
        if self.spent or (self._used and condition.mode == "ground"):
            self.renew()
        used = self._used
        seed, self._seed = self._seed if warm else None, None
        airframe.lower_ground()
        written = properties(airframe, condition, setup)
        # without a search nothing needs the condition's own speed and attitude
        initial = {}
        if condition.mode == "none":
            initial = {n: v for n, v in written.items() if is_initial(airframe.canonical(n))}
        airframe.write({n: v for n, v in written.items() if n not in initial}, "setup")
        airframe.stopped = engines_off(airframe, condition, written)
        # spent is cleared on success: a search that ends early leaves the executive unusable
        self._used = self.spent = True
        with airframe.engines_stopped():
            initialise(airframe, condition, condition.heading, initial)
            if not (used and not_finite(read_state(airframe, condition))):
                try:
                    return self._search(condition, seed, warm)
                except TrimError as error:
                    by_newton = condition.searched_by == "newton"
                    again = error.reason in ("no convergence", "no equilibrium")
                    if not (again and used and by_newton):
                        raise
        # the previous flight left NaN or inf in the executive, or engines from which a search with
        # constant-speed propellers does not converge or stay: this call renews it
        self.spent = True
        return self._trim(condition, setup, warm=False)

    def _search(self, condition: TrimCondition, seed: Seed | None, warm: bool) -> TrimState:
        airframe = self.airframe
        if condition.mode != "none":
            refuse_hopeless(airframe, condition)
        engine_out = airframe.stopped and condition.solver is None
        flies = condition.mode not in ("ground", "none")
        if condition.searched_by == "newton" or (engine_out and flies):
            return self.by_newton(condition, seed, warm)
        if condition.mode in ("full", "longitudinal"):
            before = airframe.internal()
            try:
                find(airframe, condition)
            except TrimError:
                # most failed searches with jet engines leave nothing behind to renew for
                initialise(airframe, condition, condition.heading)
                self.spent = not _same(before, airframe.internal())
                raise
        elif condition.mode != "none":
            find(airframe, condition)
        if condition.mode == "turn":
            # JSBSim keeps the track and turns the nose, so start with the opposite offset
            beyond = math.remainder(airframe.fdm[STATE["psi"]] - condition.heading, 360.0)
            initialise(airframe, condition, condition.heading - beyond)
            find(airframe, condition)
        found = read_state(airframe, condition, MOVED.get(condition.mode, ()))
        if broken := not_finite(found):
            why = f"{', '.join(broken)} not finite after the trim"
            raise failure(airframe, condition, "no convergence", why)
        self.spent = False
        return found

    def by_newton(
        self, condition: TrimCondition, seed: Seed | None = None, warm: bool = False
    ) -> TrimState:
        """Trim the initialised airframe with the Newton search.

        A failure leaves the commands alone.
        """
        airframe = self.airframe
        if len(airframe.stopped) == airframe.engines and condition.balance == "throttle":
            self.spent = False
            raise failure(airframe, condition, "thrust")
        commands = [f"fcs/{n}-cmd-norm" for n in ("pitch-trim", "elevator", "aileron", "rudder")]
        commands += [f"fcs/throttle-cmd-norm[{i}]" for i in range(airframe.engines)]
        before = {name: airframe.fdm[name] for name in commands}
        try:
            reached, self._seed = self.search(condition, seed, warm)
        except TrimError:
            for name, value in before.items():
                airframe.fdm[name] = value
            raise
        self.spent = False
        return reached

    def search(
        self, condition: TrimCondition, seed: Seed | None, warm: bool, in_time: bool = False
    ) -> tuple[TrimState, Seed | None]:
        """The trim that the Newton search finds, and the seed of the next one."""
        turboprops = bool(self.airframe.of_engines("itt-c"))
        in_time = in_time or turboprops or (seed is not None and seed.in_time)
        search = Search(self.airframe, condition, self.effort, in_time)
        found = search.find(seed)
        self.spent = search.leaves_traces
        try:
            return self._reached(condition, search, found, warm), found.seed
        except TrimError as error:
            if in_time or error.reason != "no equilibrium":
                raise
        return self.search(condition, seed, warm, in_time=True)

    def _reached(
        self, condition: TrimCondition, search: Search, found: Found, warm: bool
    ) -> TrimState:
        """The state in which a Newton search has left the airframe, if it is a trim."""
        airframe = self.airframe
        touches = airframe.fdm["forces/fbz-gear-lbs"] != 0.0
        if found.converged and not touches:
            residuals: dict[str, Any] = {**found.residuals}
            state = read_state(airframe, condition, tuple(found.free))
            state = dataclasses.replace(state, **residuals)
            if not not_finite(state):
                if why := self._what_moves(condition, search, found, warm):
                    raise failure(airframe, condition, "no equilibrium", why, found.residuals)
                return state
        if touches:
            why = "a wheel or another contact point touches the ground"
            raise failure(airframe, condition, "ground", why)
        reason = _REASONS.get(found.binding, found.binding) or "no convergence"
        limit = found.free.get(found.binding)
        if limit is not None and found.binding in _ANGLES:
            limit = math.degrees(limit)
        raise failure(airframe, condition, reason, residuals=found.residuals, limit=limit)

    def _what_moves(
        self, condition: TrimCondition, search: Search, found: Found, warm: bool
    ) -> str:
        """What moves in a short flight from a trim; empty if nothing does."""
        airframe = self.airframe
        if condition.mode == "pull-up":
            return ""
        if not warm or search.leaves_traces:
            # the airframe could be put back to the precision of the search only
            other = airframe.stand_in()
            with other.engines_stopped():
                initialise(other, condition, condition.heading)
                other.fdm[STATE["elevator"]] = airframe.fdm[STATE["elevator"]]
                Search(other, condition, Effort(), search.in_time).hold(found)
            return what_moves(other, condition)
        fuel = [airframe.fdm[tank] for tank in airframe.tanks]
        time = airframe.fdm.get_sim_time()
        why = what_moves(airframe, condition)
        for tank, contents in zip(airframe.tanks, fuel, strict=True):
            airframe.writer(tank)(contents)
        search.hold(found)
        airframe.fdm.set_sim_time(time)
        return why


_trimmers: weakref.WeakKeyDictionary[Airframe, Trimmer] = weakref.WeakKeyDictionary()


def _same(before: list[float], now: list[float]) -> bool:
    """Whether two internal states are the same up to rounding; false where one is not finite."""
    a, b = np.array(before), np.array(now)
    with np.errstate(invalid="ignore"):
        return bool((abs(a - b) <= _ROUNDING * np.maximum(abs(a), 1.0)).all())
