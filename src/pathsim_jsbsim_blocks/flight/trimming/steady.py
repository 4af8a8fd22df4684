"""Whether an aircraft stays at its trim: flights with controls fixed."""

from __future__ import annotations

import math

import numpy as np

from ..airframe import Airframe
from .condition import TrimCondition
from .state import STATE, UNITS, Drift

# what a short flight may show of an equilibrium: s; ft/s2 and rad/s2
_SHORT_FLIGHT = 0.25
_MAX_ACCELERATION = {"vdot": 0.1, "pdot": 0.02, "qdot": 0.02, "rdot": 0.02}

# of a surface's travel or of the weight in thrust: what is named as the cause moves by more
_SMALL_MOTION = 0.01


def fly(airframe: Airframe, duration: float) -> Drift:
    """Fly an airframe from its trim, controls fixed."""
    fdm = airframe.fdm
    names = [STATE[name] for name in ("altitude", "speed", "phi")]
    start, climb = [fdm[name] for name in names], fdm["velocities/h-dot-fps"]
    for _ in range(round(duration / airframe.dt)):
        fdm.run()
    height, speed, bank = (fdm[name] - before for name, before in zip(names, start, strict=True))
    bank = math.remainder(bank, 360.0) if math.isfinite(bank) else math.nan
    return Drift(duration, height - climb * duration, speed, bank)


def what_moves(airframe: Airframe, condition: TrimCondition) -> str:
    """What moves in a short flight from a trim, controls fixed; empty if nothing does."""
    parts = [f"fcs/{name}-pos-norm" for name in ("elevator", "left-aileron", "right-aileron")]
    parts += ["fcs/rudder-pos-norm", *airframe.of_engines("thrust-lbs")]
    watched = [airframe.reader(name) for name in parts]
    before = [read() for read in watched]
    largest = _largest_accelerations(airframe)
    axes = ["qdot"] if condition.mode == "longitudinal" else [*_MAX_ACCELERATION]
    if all(largest[name] < _MAX_ACCELERATION[name] for name in axes):
        return ""
    worst = max(axes, key=lambda name: largest[name] / _MAX_ACCELERATION[name])
    why = f"it does not stay: within {_SHORT_FLIGHT} s of flight {worst} reaches "
    why += f"{largest[worst]:.3g} {UNITS[worst]}"
    weight = airframe.fdm[STATE["weight"]]
    sizes = [weight if name.endswith("-lbs") else 1.0 for name in parts]
    after = [read() for read in watched]
    moved = [abs(b - a) / size for a, b, size in zip(before, after, sizes, strict=True)]
    i = int(np.argmax(moved))
    if moved[i] > _SMALL_MOTION:
        why += f" ({parts[i]} goes from {before[i]:.3g} to {after[i]:.3g})"
    return why


def _largest_accelerations(airframe: Airframe) -> dict[str, float]:
    # relative to the air: in a turn with wind the ground velocity turns in body axes
    names = "velocities/v-aero-fps", *(STATE[name] for name in ("pdot", "qdot", "rdot"))
    readers = [airframe.reader(name) for name in names]
    rows = [[read() for read in readers]]
    for _ in range(max(round(_SHORT_FLIGHT / airframe.dt), 1)):
        airframe.fdm.run()
        rows.append([read() for read in readers])
    flight = np.array(rows)
    flight[1:, 0] = np.diff(flight[:, 0]) / airframe.dt
    return dict(zip(_MAX_ACCELERATION, abs(flight[1:]).max(axis=0).tolist(), strict=True))
