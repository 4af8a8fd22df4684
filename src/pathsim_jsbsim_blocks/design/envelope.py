"""Limits of an aircraft at one altitude and airspeed: stall, climb and descent."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..control.gains import EnvelopeLimits
from ..errors import AircraftError, TrimError
from ..flight import Airframe, TrimCondition, TrimState, trim
from .requirements import ABOVE_STALL, ALPHA, LIFT

# minimum lift-curve slope over weight, 1/deg: flatter curves have no zero-lift angle
_FLATTEST = 0.02

# airspeeds tried for the slowest trim, as fractions of the way up to the trim's airspeed
_SLOWEST = (0.0, 0.1, 0.2, 0.35, 0.5, 0.7)

# throttles to try for the climb, as fractions of the remaining travel: full throttle may not trim
_CLIMBS = (1.0, 0.7, 0.4)


def envelope(
    fresh: Callable[[], Airframe], condition: TrimCondition, trimmed: TrimState, speed: float
) -> EnvelopeLimits:
    """Measure the limits on separate airframes, which ``fresh`` creates.

    JSBSim computes the lift over the angle of attack with the controls of the trim; climb and
    descent are trims at full throttle and at idle.

    ``trimmed`` is the trim at the ``condition`` of level flight, with ``speed`` in KCAS.
    """
    airframe = fresh()
    state = trim(airframe, condition, hint=False)
    alpha, lift = _lift(airframe, math.floor(state.alpha))
    peak = int(np.argmax(np.append(np.diff(lift) <= 0.0, True)))
    limit = float(np.interp(LIFT * lift[peak], lift[: peak + 1], alpha[: peak + 1]))
    limit = max(min(limit, ALPHA), state.alpha + 1.0)
    at_limit = float(np.interp(limit, alpha, lift))
    at_trim = float(np.interp(state.alpha, alpha, lift))
    slope = max((at_limit - at_trim) / (limit - state.alpha), _FLATTEST)
    slowest = min(ABOVE_STALL * speed / math.sqrt(max(at_limit, 1.0)), speed)
    throttle = trimmed.throttle[0]
    climb = 0.0
    for fraction in _CLIMBS:
        rate = _rate(fresh, condition, throttle + fraction * (1.0 - throttle))
        if rate is not None:
            climb = rate / fraction
            break
    descent = _rate(fresh, condition, 0.0)
    slowest = _slowest(fresh, condition, slowest, speed)
    return EnvelopeLimits(
        alpha_max=limit,
        vc_min=slowest,
        climb_max=max(climb, 0.0),
        descent_max=max(-descent if descent is not None else climb, 1.0),
        alpha_zero=state.alpha - at_trim / slope,
        lift_max=min(at_trim / max(at_limit, 1.0) * (speed / slowest) ** 2, 1.0),
    )


def _lift(airframe: Airframe, start: float) -> tuple[np.ndarray, np.ndarray]:
    """Lift over weight at angles of attack from ``start`` deg up, at the speed of the trim."""
    fdm = airframe.fdm
    weight = fdm["inertia/weight-lbs"]
    alpha = np.arange(start, 41.0)
    lift = np.empty(len(alpha))
    fdm.set_trim_status(True)
    try:
        for i, a in enumerate(alpha):
            fdm["ic/alpha-deg"] = float(a)
            airframe.run_ic()
            lift[i] = fdm["forces/fwz-aero-lbs"] / weight
    finally:
        fdm.set_trim_status(False)
    return alpha, lift


def _trimmed(fresh: Callable[[], Airframe], condition: TrimCondition) -> Airframe | None:
    """An airframe trimmed at the condition, or None."""
    try:
        airframe = fresh()
        trim(airframe, condition, hint=False)
    except (TrimError, AircraftError):
        return None
    return airframe


def _slowest(
    fresh: Callable[[], Airframe], condition: TrimCondition, low: float, high: float
) -> float:
    """The minimum airspeed in KCAS at which elevator and thrust trim level flight."""
    for fraction in _SLOWEST:
        speed = low + fraction * (high - low)
        if _trimmed(fresh, replace(condition, speed=speed, mach=None)) is not None:
            return speed
    return high


def _rate(fresh: Callable[[], Airframe], condition: TrimCondition, throttle: float) -> float | None:
    """Rate of climb in ft/s at a throttle and the same airspeed, or None without a trim."""
    airframe = _trimmed(fresh, replace(condition, throttle=throttle))
    # not from the path angle, which is relative to the ground and depends on the wind
    return None if airframe is None else airframe.fdm["velocities/h-dot-fps"]
