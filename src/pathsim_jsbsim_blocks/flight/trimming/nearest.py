"""The nearest airspeed that trims instead of one that does not."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping

from ..._core.units import KNOT, RHO0
from ...errors import AircraftError, TrimError
from ..airframe import Airframe
from .condition import TrimCondition
from .initial import initialise
from .state import STATE
from .trimmer import Trimmer

# lift coefficient of a speed at which most aircraft fly, and factors of this speed
_USUAL_LIFT = 0.4
_USUAL_SPEEDS = (1.0, 1.3, 0.8, 1.7)

# KCAS, limits for models whose reference area is unrelated to lift (rockets, helicopters)
_LEVEL_SPEEDS = (20.0, 350.0)

# failures that another speed may remove
_CURABLE = ("thrust", "alpha limit", "elevator", "no convergence")


def speed_of_lift(weight: float, area: float, lift_coefficient: float) -> float:
    """The speed in KCAS at which lift equals weight (lb) for a wing area (ft2) and CL."""
    return math.sqrt(2.0 * weight / (RHO0 * area * lift_coefficient)) / KNOT


def level_speed(airframe: Airframe, lift_coefficient: float) -> float:
    """The speed in KCAS at which an initialised airframe's lift equals its weight."""
    low, high = _LEVEL_SPEEDS
    weight, area = (airframe.fdm[name] for name in ("inertia/weight-lbs", "metrics/Sw-sqft"))
    if area <= 0.0:
        return low
    return float(round(min(max(speed_of_lift(weight, area, lift_coefficient), low), high)))


def with_nearest(
    airframe: Airframe, setup: Mapping[str, float] | None, error: TrimError
) -> TrimError:
    """The error of a failed trim, with the nearest airspeed that trims."""
    condition = error.condition
    has_power = len(airframe.stopped) < airframe.engines or condition.balance != "throttle"
    wants = (
        condition.searched_by == "newton"
        and condition.mode != "ground"
        and condition.balance != "speed"
        and has_power
    )
    if not wants or error.reason not in _CURABLE:
        return error
    nearest = _nearest_speed(airframe.twin(), condition, setup)
    if nearest is None:
        return error
    how = f"at {nearest.speed:.0f} KCAS there"
    return error.reworded(f"{error}. It trims {how}", nearest=nearest)


def _nearest_speed(
    airframe: Airframe, condition: TrimCondition, setup: Mapping[str, float] | None
) -> TrimCondition | None:
    """The condition at the nearest speed in whole KCAS that trims; None if none is found.

    The search bisects between the condition's speed and a typical speed that trims, so it ends at
    the maximum or minimum speed of the range that trims.
    """
    trimmer = Trimmer(airframe)

    def trims(knots: float, warm: bool = True) -> TrimCondition | None:
        trial = dataclasses.replace(condition, speed=knots, mach=None)
        try:
            trimmer.trim(trial, setup, warm=warm)
        except (TrimError, AircraftError):  # at another speed a model may not even initialise
            return None
        return trial

    try:
        initialise(airframe, condition, condition.heading)
    except AircraftError:
        return None
    usual, bad = level_speed(airframe, _USUAL_LIFT), airframe.fdm[STATE["speed"]]
    if not math.isfinite(bad):
        return None
    tries = (float(round(usual * factor)) for factor in _USUAL_SPEEDS)
    good = next(filter(trims, tries), None)
    if good is None:
        return None
    while abs(good - bad) > 1.0:
        middle = float(round(0.5 * (bad + good)))
        if middle in (bad, good):
            break
        if trims(middle):
            good = middle
        else:
            bad = middle
    # confirm with a freshly loaded model, as a user will trim it
    return trims(good, warm=False)
