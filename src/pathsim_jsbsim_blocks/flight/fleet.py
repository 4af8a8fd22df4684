"""Level flight for any aircraft model: find a condition, and trim there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from .._core.checks import whole
from ..errors import AircraftError, TrimError
from ._trim import TrimState, trim
from .airframe import Airframe, has_retractable_gear
from .condition import TrimCondition

# (altitude in ft, lift coefficient): the first is where most aircraft cruise, the others are for
# engines that are weak at that height (pa28) and for speeds that are too high (c310)
TRIES = ((5000.0, 0.4), (2000.0, 0.4), (5000.0, 0.6))

# KCAS; for models whose reference area tells nothing of their lift (rockets, helicopters)
_SPEEDS = (20.0, 350.0)

_RHO0 = 0.0023769  # slug/ft3, standard air at sea level (US Standard Atmosphere, 1976)
_KNOT = 1.6878099  # ft/s


@dataclass(frozen=True)
class LevelFlight:
    """A condition at which an aircraft flies level, and the trim found there.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        where it trims: gear up where it retracts, fuel frozen
    create : dict
        properties that the model expects from its surroundings, at 0
    trim : TrimState
        the trim found
    """

    aircraft: str
    condition: TrimCondition
    create: Mapping[str, float]
    trim: TrimState


def level_flight(aircraft: str, root: str | None = None,
                 tries: int = len(TRIES)) -> LevelFlight:
    """Find a sensible condition of straight and level flight for an aircraft.

    The speed follows from the weight and the wing area; what the model misses from its surroundings
    is created.

    .. math::
        V = \\sqrt{\\frac{2 W}{\\rho_0 S C_L}}

    Parameters
    ----------
    aircraft : str
        name of the model
    root : str, optional
        JSBSim root directory; default is the one that the jsbsim package brings
    tries : int
        number of conditions to try at most: a failed trim takes up to seconds

    Raises
    ------
    AircraftError
        if the model is unknown, cannot be loaded, or cannot be initialised
    TrimError
        if it trims at none of these; the residuals are those of the first
    """
    airframe, create = _initialised(aircraft, root)
    gear = 0.0 if has_retractable_gear(aircraft, root) else None
    frozen = {name: 1.0 for name in ("propulsion/fuel_freeze",) if airframe.has(name)}
    weight, area = airframe.fdm["inertia/weight-lbs"], airframe.fdm["metrics/Sw-sqft"]
    first: TrimError | None = None
    for altitude, lift_coefficient in TRIES[:whole("tries", tries, low=1)]:
        condition = TrimCondition(
            altitude=altitude, speed=_speed(weight, area, lift_coefficient), gear=gear,
            setup=frozen)
        try:
            # a failed search leaves its traces in the next, so each has an airframe of its own
            found = trim(Airframe(aircraft, root=root, create=create), condition)
        except TrimError as error:
            first = first or error
        else:
            return LevelFlight(aircraft, condition, create, found)
    assert first is not None
    others = min(len(TRIES), int(tries)) - 1
    elsewhere = f" and at {others} other conditions" if others else ""
    raise TrimError(f"no level flight: {first} (tried there{elsewhere})", aircraft=aircraft,
                    condition=first.condition, reason=first.reason, residuals=first.residuals)


def _initialised(aircraft: str, root: str | None) -> tuple[Airframe, dict[str, float]]:
    """An initialised airframe, and the properties that had to be created for it."""
    create: dict[str, float] = {}
    while True:
        airframe = Airframe(aircraft, root=root, create=create)
        try:
            airframe.run_ic()
        except AircraftError as error:
            if not error.missing or error.missing in create:
                raise
            create[error.missing] = 0.0
        else:
            return airframe, create


def _speed(weight: float, area: float, lift_coefficient: float) -> float:
    low, high = _SPEEDS
    if area <= 0.0:
        return low
    speed = math.sqrt(2.0 * weight / (_RHO0 * area * lift_coefficient)) / _KNOT
    return float(round(min(max(speed, low), high)))
