"""An aircraft at rest on the ground: let down with brakes on, as it stands after a landing.

A root of the accelerations need not be an equilibrium: an aircraft may balance on two wheels.
"""

from __future__ import annotations

import math

import numpy as np

from ..airframe import Airframe
from ..settling import Settling
from .condition import TrimCondition
from .failure import failure
from .initial import initialise
from .search import solution
from .state import STATE

# the unknowns, as JSBSim's own search has them
UNKNOWNS = ("altitude", "theta", "phi")

_PLACE = ("position/h-agl-ft", "attitude/theta-rad", "attitude/phi-rad")
_INITIAL = ("ic/h-agl-ft", "ic/theta-rad", "ic/phi-rad")
_VELOCITIES = (*(f"ic/{axis}-fps" for axis in "uvw"), *(f"ic/{axis}-rad_sec" for axis in "pqr"))

# height of the lowest part above the ground at the start, ft
_CLEARANCE = 0.0

# maximum step, s: stiff gear does not rest at 30 Hz, nor with integrators of higher order
_STEP = 1.0 / 120.0

# maximum time until it rests, s; interval of the check, s, and changes in it below which it rests,
# in ft and rad
_LONGEST = 60.0
_INTERVAL = 0.5
_RESTS = np.array([1e-3, 1e-4, 1e-4])

# accelerations that are balanced, with tolerances in ft/s2 and rad/s2
_BALANCED = ("wdot", "qdot", "pdot")
_TOLERANCES = np.array([1e-4, 1e-5, 1e-5])

# ft and rad: steps of difference quotients, and maximum distance of the balance from the place of
# rest, to which idle power adds a little
_STEPS = np.array([1e-5, 1e-6, 1e-6])
_NEAR = np.array([0.25, 0.1, 0.1])
_ITERATIONS = 20


def let_down(airframe: Airframe, condition: TrimCondition) -> tuple[str, ...]:
    """Set an initialised airframe to its place of rest at idle power; returns the unknowns.

    Another airframe is let down without power. From its place of rest Newton's method balances the
    accelerations with engines at idle and brakes as they are.
    """
    stand = _place_of_rest(airframe, condition)
    if stand is None:
        why = f"let down with brakes on, it does not come to rest within {_LONGEST:g} s"
        raise failure(airframe, condition, "no equilibrium", why)
    _set(airframe, condition, stand)
    engines = Settling(airframe)
    if engines.required:
        engines.start()
        engines.settle()
    place = _balanced(airframe, condition, stand)
    r = _set(airframe, condition, place)
    airframe.fdm.set_sim_time(0.0)
    if not (abs(place - stand) <= _NEAR).all() or not abs(r).max() <= 1.0:
        residuals = dict(zip(_BALANCED, (r * _TOLERANCES).tolist(), strict=True))
        why = "it came to rest, but near this place the search did not converge"
        raise failure(airframe, condition, "no convergence", why, residuals)
    return UNKNOWNS


def _place_of_rest(airframe: Airframe, condition: TrimCondition) -> np.ndarray | None:
    """Height in ft, pitch and bank in rad at which it comes to rest; None if it does not."""
    twin = airframe.twin(_STEP)
    twin.resemble(airframe)
    twin.stopped = frozenset(range(twin.engines))
    fdm, place = twin.fdm, twin.reader_of(_PLACE)
    with twin.fuel_frozen(), twin.engines_stopped():
        initialise(twin, condition, condition.heading)
        _set(twin, condition, np.array([_lowest(twin) + _CLEARANCE, 0.0, 0.0]))
        for side in ("left", "center", "right"):
            fdm[f"fcs/{side}-brake-cmd-norm"] = 1.0
        start = np.array(place())
        for _ in range(round(_LONGEST / _INTERVAL)):
            for _ in range(round(_INTERVAL / twin.dt)):
                fdm.run()
            end = np.array(place())
            if (abs(end - start) <= _RESTS).all():
                return end
            start = end
    return None


def _lowest(airframe: Airframe) -> float:
    """Height of the centre of gravity with the lowest part on the ground, level, ft."""
    fdm, units = airframe.fdm, range(int(airframe.fdm["gear/num-units"]))
    names = [f"{kind}/unit[{i}]/z-position" for i in units for kind in ("gear", "contact")]
    depths = [fdm["inertia/cg-z-in"] - fdm[name] for name in names if airframe.has(name)]
    return max(depths, default=0.0) / 12.0


def _set(airframe: Airframe, condition: TrimCondition, place: np.ndarray) -> np.ndarray:
    """Set an airframe at rest at a place; returns the accelerations, in tolerances."""
    fdm = airframe.fdm
    fdm["ic/psi-true-rad"] = math.radians(condition.heading)
    for name, value in zip(_INITIAL, place.tolist(), strict=True):
        fdm[name] = value
    for name in _VELOCITIES:
        fdm[name] = 0.0
    # in trim status propellers keep their speeds
    fdm.set_trim_status(True)
    try:
        airframe.run_ic()
    finally:
        fdm.set_trim_status(False)
    return np.array([fdm[STATE[name]] for name in _BALANCED]) / _TOLERANCES


def _balanced(airframe: Airframe, condition: TrimCondition, place: np.ndarray) -> np.ndarray:
    """The root of the accelerations near a place; the place itself if there is none."""
    best, minimum = place, math.inf
    for _ in range(_ITERATIONS):
        r = _set(airframe, condition, place)
        size = float(abs(r).max())
        if not size < minimum or not (abs(place - best) <= _NEAR).all():
            break
        best, minimum = place, size
        columns = [_set(airframe, condition, place + step) - r for step in np.diag(_STEPS)]
        place = place + solution(np.array(columns).T / _STEPS, -r)
    return best
