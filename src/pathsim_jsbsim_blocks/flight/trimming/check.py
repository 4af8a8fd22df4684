"""Whether an aircraft stays at its trim: flights with controls fixed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..._core.aircraft_ports import property_of
from ..airframe import Airframe
from .condition import TrimCondition
from .state import STATE, UNITS, Drift

# s, duration of a short flight, and limits of accelerations in it for an equilibrium, ft/s2, rad/s2
SHORT = 0.25
_MAX_ACCELERATION = {"vdot": 0.1, "pdot": 0.02, "qdot": 0.02, "rdot": 0.02}

# minimum motion of a cause, relative to a surface's travel or, for thrust, to the weight
_SMALL_MOTION = 0.01

# s, time for which engines must have fuel
FED = 1.0

# s, time for which a trim must hold, and the bounds
LONG = 5.0
_BOUNDS = {
    "height": (5.0, "ft"),
    "airspeed": (0.5, "kt"),
    "pitch": (0.1, "deg"),
    "bank": (0.1, "deg"),
    "heading": (0.1, "deg"),
}

# relative to the air: in a turn with wind the ground velocity turns in body axes
_ACCELERATIONS = "velocities/v-aero-fps", *(STATE[name] for name in ("pdot", "qdot", "rdot"))
_PATH = {
    "height": STATE["altitude"],
    "airspeed": "velocities/vtrue-kts",
    "pitch": STATE["theta"],
    "bank": STATE["phi"],
    "heading": STATE["psi"],
}


class HandsOff(NamedTuple):
    """Result of a flight from a trim with controls fixed."""

    # why it is not an equilibrium; empty if it is one
    moves: str
    # how it leaves its path within 5 s; empty if it does not
    leaves: str
    drift: Drift
    # engines that have run out of fuel within 1 s
    starved: list[int]


def fly(airframe: Airframe, condition: TrimCondition, duration: float) -> HandsOff:
    """Fly an airframe from its trim for a time in s, controls fixed."""
    parts = [f"fcs/{name}-pos-norm" for name in ("elevator", "left-aileron", "right-aileron")]
    parts += ["fcs/rudder-pos-norm", *airframe.of_engines("thrust-lbs")]
    read_parts = airframe.reader_of(parts)
    first, fdm = read_parts(), airframe.fdm
    # of height in ft/s and of the heading in deg/s along the path
    rates = fdm[property_of("hdot")], math.degrees(fdm["velocities/psidot-rad_sec"])
    names = [*_ACCELERATIONS, *_PATH.values(), STATE["speed"]]
    read, run, dt = airframe.reader_of(names), fdm.run, airframe.dt
    rows, last_parts, without_fuel = [read()], first, list[int]()
    fuel = airframe.fuel()
    step, few, last = 0, max(round(SHORT / dt), 1) + 1, max(round(duration / dt), 1)
    while step < last:
        step += 1
        run()
        rows.append(read())
        if step == few - 1:
            last_parts = read_parts()
            last = max(last, round(FED / dt) if _drains(fuel, airframe.fuel()) else 0)
        if step == round(FED / dt):
            without_fuel = airframe.starved()
    flight = np.array(rows).T
    moves = _what_moves(condition, flight[:4, :few], dt)
    if moves:
        moves += _culprit(parts, first, last_parts, fdm[STATE["weight"]])
    off = _off_the_path(flight[4:-1], rates, dt)
    long = round(LONG / dt) + 1
    height, _, _, bank, _ = (float(x) for x in off[:, -1])
    drift = Drift(duration, height, float(flight[-1, -1] - flight[-1, 0]), bank)
    return HandsOff(moves, _what_leaves(off[:, :long]), drift, without_fuel)


def _drains(start: Sequence[float], end: Sequence[float]) -> bool:
    """Whether an engine runs out of fuel within `FED` at its consumption during `SHORT`."""
    times = FED / SHORT - 1.0
    return any(b < times * (a - b) or b <= 0.0 for a, b in zip(start, end, strict=True))


def _what_moves(condition: TrimCondition, flight: np.ndarray, dt: float) -> str:
    accelerations = flight[:, 1:].copy()
    accelerations[0] = np.diff(flight[0]) / dt
    peaks = abs(accelerations).max(axis=1).tolist()
    largest = dict(zip(_MAX_ACCELERATION, peaks, strict=True))
    axes = ["qdot"] if condition.mode == "longitudinal" else [*_MAX_ACCELERATION]
    if all(largest[name] < _MAX_ACCELERATION[name] for name in axes):
        return ""
    worst = max(axes, key=lambda name: largest[name] / _MAX_ACCELERATION[name])
    return (
        f"it does not stay: within {SHORT} s of flight {worst} reaches "
        f"{largest[worst]:.3g} {UNITS[worst]}"
    )


def _culprit(parts: list[str], start: list[float], end: list[float], weight: float) -> str:
    """Text with the surface or engine that has moved most; empty if none has."""
    sizes = [weight if name.endswith("-lbs") else 1.0 for name in parts]
    motions = [abs(b - a) / size for a, b, size in zip(start, end, sizes, strict=True)]
    i = int(np.argmax(motions))
    if not motions[i] > _SMALL_MOTION:
        return ""
    return f" ({parts[i]} goes from {start[i]:.3g} to {end[i]:.3g})"


def _off_the_path(flight: np.ndarray, rates: tuple[float, float], dt: float) -> np.ndarray:
    """Distances from the steady path over time, in the units of `_BOUNDS`."""
    off = flight - flight[:, :1]
    time = dt * np.arange(off.shape[1])
    climb, turning = rates
    off[0] -= climb * time
    off[4] -= turning * time
    for angle in (3, 4):
        off[angle] = (off[angle] + 180.0) % 360.0 - 180.0
    return off


def _what_leaves(off: np.ndarray) -> str:
    worst = abs(off).max(axis=1)
    bounds = np.array([most for most, _ in _BOUNDS.values()])
    if (worst <= bounds).all():
        return ""
    # NaN is the worst
    i = int(np.argmax(np.nan_to_num(worst / bounds, nan=np.inf)))
    name, (_, unit) = [*_BOUNDS.items()][i]
    return f"{name} moves by {worst[i]:.2g} {unit} in {LONG:g} s with controls fixed"
