"""Trim an aircraft: `TrimCondition` in, `TrimState` out. The only place that trims."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from ..._core.checks import flag, must_be, number
from ...errors import TrimError
from ..airframe import Airframe
from .condition import TrimCondition, check_condition
from .hints import explained, warn_of_gear
from .state import Drift, TrimState
from .steady import fly as fly_from_trim
from .trimmer import Trimmer

__all__ = ["Drift", "TrimCondition", "TrimState", "trim"]


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

    JSBSim's own search takes one control after the other, to residuals of up to 0.01 ft/s2 and
    0.001 rad/s2. The Newton search (``solver="newton"``) moves all together within their limits
    until udot, vdot, wdot are below 1e-4 ft/s2 and pdot, qdot, rdot below 1e-5 rad/s2 (usually
    1e-9), with propellers and flight control system settled: in a flight of 0.25 s, which a twin
    makes, vdot stays below 0.1 ft/s2 and pdot, qdot, rdot below 0.02 rad/s2 (pull-ups are not
    flown). It also trims glides, steady sideslips and flights at a given throttle or thrust; its
    turns are steady in wind, its pull-ups in all accelerations.

    Parameters
    ----------
    airframe : Airframe
        loaded with the condition's ``empty_cg_x``; it can be trimmed repeatedly
    condition : TrimCondition
        what to trim for
    setup : dict, optional
        further properties, written before the model is initialised and after the condition's
    hint : bool
        after a failure ask the Newton search which limit is reached, and look for the nearest
        speed that trims: the error names both. Warn of a landing gear that is down above 200 KCAS
        where it retracts and the condition does not say so
    fly : float
        fly another aircraft of the same kind from its trim for this time in s (up to 3600),
        controls fixed (10 shows most departures, some take 30): the state's ``drift`` and
        ``steady`` say how it ends. Modes "pull-up" and "none", which are not steady flight, have
        none
    warm : bool
        let the Newton search start where the last one on this airframe found its trim. The result
        is the same, sooner: if it does not get there to full precision, it starts again cold. An
        airframe that can be put back to the precision of the search makes the flight itself

    Returns
    -------
    TrimState
        the state found; the airframe is left in it

    Raises
    ------
    TrimError
        if no trim is found, or with JSBSim's search and constant-speed propellers not within
        10 s of computing (no limit on Windows). The airframe stays usable: after a failure
        that has changed engines, systems or accelerations, the next trim starts
        from a fresh executive (`Airframe.renew`), as does a trim on the ground after any other.
        This discards fuel burnt in between and direct writes to ``airframe.fdm``
    AircraftError
        if the model cannot be initialised
    PropertyError
        for unknown properties in ``setup`` or the condition, or missing tanks or point masses
    ParameterError
        for initial conditions in ``setup`` that the trim would overwrite, and for an aircraft's
        name in place of an `Airframe`
    """
    if not isinstance(airframe, Airframe):
        must_be("airframe", airframe, "an Airframe, as in trim(Airframe('c172p'), ...)")
    check_condition(condition)
    flag("hint", hint)
    flag("warm", warm)
    duration = number("fly", fly, low=0.0, high=3600.0)
    trimmer = Trimmer.of(airframe)
    try:
        found = trimmer.trim(condition, setup, warm)
        if hint:
            warn_of_gear(airframe, found)
        if duration and condition.mode not in ("pull-up", "none"):
            other = airframe.twin()
            Trimmer(other).trim(condition, setup)
            found = dataclasses.replace(found, drift=fly_from_trim(other, duration))
        return found
    except TrimError as error:
        if not hint:
            raise
        raise explained(trimmer, condition, setup, error) from None
