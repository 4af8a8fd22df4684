"""Trim an aircraft: `TrimCondition` in, `TrimState` out. The only place that trims."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from ..._core.callers import warn_user
from ..._core.checks import flag, must_be, number
from ...errors import TrimError
from ..airframe import Airframe
from ..model_files import has_retractable_gear
from . import check
from .condition import TrimCondition, check_condition
from .initial import read_back
from .nearest import with_nearest
from .state import UNITS, Drift, TrimState
from .trimmer import Trimmer

__all__ = ["Drift", "TrimCondition", "TrimState", "trim"]

# KCAS, above which hardly any landing gear may be extended
_FAST_FOR_GEAR = 200.0


def trim(
    airframe: Airframe,
    condition: TrimCondition,
    setup: Mapping[str, float] | None = None,
    *,
    hint: bool = True,
    fly: float = 0.0,
    warm: bool = False,
) -> TrimState:
    """Initialise an airframe at a condition and trim it.

    The Newton search moves all controls together within their limits until udot, vdot, wdot are
    below 1e-4 ft/s2 and pdot, qdot, rdot below 1e-5 rad/s2 (usually 1e-9), with propellers and
    flight control system settled and fuel frozen. A second aircraft then flies from the trim (not
    in a pull-up): for 0.25 s vdot must stay below 0.1 ft/s2 and pdot, qdot, rdot below 0.02 rad/s2,
    and engines must have fuel for 1 s. A search that ends with up to ten times its tolerances is
    accepted with a warning if this flight stays within 0.5 kt, 5 ft and 0.1 deg for 5 s, as below.
    In a turn the sideslip is zero and the turn rate follows from the side force; ``ny`` of the
    state is the side load.
    On the ground another aircraft is let down with brakes on and engines stopped until it rests;
    from there height, pitch and bank balance wdot, qdot and pdot with engines settled at idle.
    JSBSim's own search (``solver="jsbsim"``) moves one control after the other, to residuals of up
    to 0.01 ft/s2 and 0.001 rad/s2.

    Parameters
    ----------
    airframe : Airframe
        loaded with the condition's ``empty_cg_x``; it can be trimmed repeatedly
    condition : TrimCondition
        what to trim for
    setup : dict, optional
        further properties, written before the model is initialised and after the condition's
    hint : bool
        search for the nearest airspeed that trims if this one does not (Newton search); warn about
        a trim that does not hold for 5 s with controls fixed within 0.5 kt of true airspeed, 5 ft
        of its path and 0.1 deg of pitch, bank and heading (in a turn, relative to its rate), and
        about a retractable landing gear that is down above 200 KCAS unless the condition sets it
    fly : float
        fly another aircraft of the same kind from its trim for this time in s (up to 3600),
        controls fixed (10 shows most departures, some need 30): the state's ``drift`` and
        ``steady`` describe the end of this flight. Modes "pull-up" and "none", which are not steady
        flight, have no drift
    warm : bool
        start the Newton search at the last trim of this airframe, without reloading the model. The
        result is the same, but faster: if the search does not converge to full precision, it
        restarts cold

    Returns
    -------
    TrimState
        the trimmed state; the airframe is left in it

    Raises
    ------
    TrimError
        if no trim is found. The airframe stays usable: unless it is warm, each trim after the first
        starts with a freshly loaded model (`Airframe.renew`), without fuel burnt in between and
        without direct writes to ``airframe.fdm``
    AircraftError
        if the model cannot be initialised
    PropertyError
        for unknown properties in ``setup`` or the condition, or missing tanks or point masses
    ParameterError
        for properties in ``setup`` that have another value after the trim, naming what to set
        instead, for an aircraft's name in place of an `Airframe`, and for a condition's
        ``empty_cg_x`` with which the airframe was not loaded
    """
    if not isinstance(airframe, Airframe):
        must_be("airframe", airframe, "an Airframe, as in trim(Airframe('c172p'), ...)")
    check_condition(condition)
    if condition.empty_cg_x not in (None, airframe.empty_cg_x):
        must_be(
            "condition.empty_cg_x",
            condition.empty_cg_x,
            f"that of the airframe ({airframe.empty_cg_x}), as the model is loaded with it: "
            f"Airframe({airframe.aircraft!r}, empty_cg_x={condition.empty_cg_x:g})",
        )
    flag("hint", hint)
    flag("warm", warm)
    duration = number("fly", fly, low=0.0, high=3600.0)
    least = check.LONG if hint and condition.searched_by == "newton" else check.SHORT
    try:
        trimmer = Trimmer.of(airframe)
        state, flown = trimmer.trim(condition, setup, warm=warm, fly=max(duration, least))
    except TrimError as error:
        if not hint:
            raise
        raise with_nearest(airframe, setup, error) from None
    read_back(airframe, condition, setup, state.free)
    if trimmer.excess:
        excess = ", ".join(f"{name}={x:.2g} {UNITS[name]}" for name, x in trimmer.excess.items())
        warn_user(
            f"the trim of {airframe.aircraft} at {condition} has residuals above the search's "
            f"tolerances, {excess}, with which it stays for {check.LONG:g} s, controls fixed"
        )
    if hint:
        _warn_of_gear(airframe, state)
        if 1.0 < trimmer.per_step <= 2.0:
            warn_user(
                f"the propeller of {airframe.aircraft} is light for steps of "
                f"1/{1 / airframe.dt:.6g} s: its speed alternates from step to step, which changes "
                f"the damping of the flight; use substeps={2 * airframe.substeps}",
                once=True,
            )
        if flown and flown.leaves:
            warn_user(
                f"the trim of {airframe.aircraft} at {condition} does not hold: {flown.leaves}"
            )
    return dataclasses.replace(state, drift=flown.drift) if flown and duration else state


def _warn_of_gear(airframe: Airframe, state: TrimState) -> None:
    """Warn about a retractable gear that is down in fast flight unless the condition sets it."""
    condition = state.condition
    fast = state.gear > 0.0 and state.speed > _FAST_FOR_GEAR and condition.mode != "ground"
    if condition.gear is None and fast and has_retractable_gear(airframe.aircraft, airframe.root):
        warn_user(
            f"{airframe.aircraft} at {state.speed:.0f} KCAS: the landing gear is down, the model's "
            "default; gear=0 retracts it, gear=1 confirms it",
            once=True,
        )
