"""Hints: the limit that a failed trim has reached, what would trim instead, a gear left down."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Mapping

from ..._core.callers import warn_user
from ..._core.units import KNOT, RHO0
from ...errors import AircraftError, TrimError
from ..airframe import Airframe
from ..model_files import has_retractable_gear
from .condition import TrimCondition
from .failure import alpha_range, failure
from .initial import initialise, properties
from .state import STATE, TrimState
from .trimmer import Trimmer

# KCAS, above which hardly any landing gear may be down
_FAST_FOR_GEAR = 200.0

# lift coefficient of a speed at which most aircraft fly, and factors of this speed
_USUAL_LIFT = 0.4
_USUAL_SPEEDS = (1.0, 1.3, 0.8, 1.7)

# KCAS, limits for models whose reference area is unrelated to lift (rockets, helicopters)
_LEVEL_SPEEDS = (20.0, 350.0)


def speed_of_lift(weight: float, area: float, lift_coefficient: float) -> float:
    """The speed in KCAS at which a wing (ft2) with a lift coefficient carries a weight (lb)."""
    return math.sqrt(2.0 * weight / (RHO0 * area * lift_coefficient)) / KNOT


def level_speed(airframe: Airframe, lift_coefficient: float) -> float:
    """The speed in KCAS at which an initialised airframe's wing lifts its weight."""
    low, high = _LEVEL_SPEEDS
    weight, area = (airframe.fdm[name] for name in ("inertia/weight-lbs", "metrics/Sw-sqft"))
    if area <= 0.0:
        return low
    return float(round(min(max(speed_of_lift(weight, area, lift_coefficient), low), high)))


def explained(
    trimmer: Trimmer,
    condition: TrimCondition,
    setup: Mapping[str, float] | None,
    error: TrimError,
) -> TrimError:
    """The error of a failed trim with the limit that is reached and the nearest that trims."""
    airframe = trimmer.airframe
    powered = len(airframe.stopped) < airframe.engines or condition.balance != "throttle"
    if condition.mode in ("ground", "none") or not powered or error.reason in ("mach", "ground"):
        return error
    trimmer.renew()
    nearest, how = None, "with solver='newton'"
    try:
        airframe.write(properties(airframe, condition, setup), "setup")
        # at another speed a model may be impossible to initialise
        with airframe.engines_stopped(), contextlib.suppress(AircraftError):
            initialise(airframe, condition, condition.heading)
            speed = airframe.fdm[STATE["speed"]]
            if condition.searched_by == "jsbsim":
                try:
                    trimmer.by_newton(condition)
                    nearest = dataclasses.replace(condition, solver="newton")
                except TrimError as ours:
                    error = _with_limit(airframe, error, ours)
            helps = error.reason in ("thrust", "alpha limit", "elevator", "no convergence")
            if nearest is None and helps and condition.balance != "speed" and math.isfinite(speed):
                nearest = _nearest_speed(trimmer, condition, speed)
                how = f"at {nearest.speed:.0f} KCAS there" if nearest else ""
    finally:
        trimmer.spent = True  # whatever the searches left, the next trim starts afresh
    if nearest is None:
        return error
    return error.reworded(f"{error}. It trims {how}", nearest=nearest)


def _with_limit(airframe: Airframe, error: TrimError, newton: TrimError) -> TrimError:
    """The error of JSBSim's search with the limit and residuals of the Newton search."""
    reason, limit, residuals = error.reason, newton.limit, newton.residuals
    if reason == "no convergence":
        reason = newton.reason
    elif reason != newton.reason:
        low, high = alpha_range(airframe)
        limit = {
            "thrust": 1.0 if residuals["udot"] < 0.0 else 0.0,
            "alpha limit": high if residuals["wdot"] > 0.0 else low,
        }.get(reason)
    if limit is None:
        return error
    return failure(airframe, error.condition, reason, residuals=residuals, limit=limit)


def _nearest_speed(
    trimmer: Trimmer, condition: TrimCondition, speed: float
) -> TrimCondition | None:
    """The condition at the speed nearest to ``speed`` in KCAS that trims; None without one.

    It lies between ``speed`` and a usual one that trims: too fast, it is the fastest that trims,
    too slow, the slowest.
    """
    airframe = trimmer.airframe
    seed = None

    def trims(knots: float) -> TrimCondition | None:
        nonlocal seed
        other = dataclasses.replace(condition, speed=knots, mach=None, solver=None)
        initialise(airframe, other, other.heading)
        if not math.isfinite(airframe.fdm[STATE["tas"]]):
            return None
        try:
            _, seed = trimmer.search(other, seed, warm=True)
        except TrimError:
            return None
        return other

    usual, bad = level_speed(airframe, _USUAL_LIFT), speed
    for factor in _USUAL_SPEEDS:
        if trimmer.effort.over:
            return None
        good = float(round(usual * factor))
        if nearest := trims(good):
            break
    else:
        return None
    while abs(good - bad) > 1.0 and not trimmer.effort.over:
        middle = float(round(0.5 * (bad + good)))
        if middle in (bad, good):
            break
        if closer := trims(middle):
            nearest, good = closer, middle
        else:
            bad = middle
    return dataclasses.replace(nearest, solver=condition.solver)


def warn_of_gear(airframe: Airframe, found: TrimState) -> None:
    """Warn of a gear that retracts and is down in fast flight because no one has said."""
    condition = found.condition
    fast = found.gear > 0.0 and found.speed > _FAST_FOR_GEAR and condition.mode != "ground"
    if condition.gear is None and fast and has_retractable_gear(airframe.aircraft, airframe.root):
        warn_user(
            f"{airframe.aircraft} at {found.speed:.0f} KCAS: the landing gear is down, as the "
            "model has it; gear=0 retracts it, gear=1 confirms it",
            once=True,
        )
