"""Steady flight for any aircraft model: find a condition and trim there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from .._core.checks import integer, mapping
from ..errors import AircraftError, TrimError
from .airframe import Airframe
from .model_files import has_retractable_gear
from .trimming import TrimState, trim
from .trimming.condition import Solver, TrimCondition
from .trimming.nearest import level_speed

# (altitude in ft, lift coefficient): the first suits most aircraft, the second those with too
# little power at 5000 ft (pa28), the third those for which a lift coefficient of 0.4 is too fast
TRIES = ((5000.0, 0.4), (2000.0, 0.4), (5000.0, 0.6))

# the same for a glide; bodies with little lift (Shuttle, x24b) need the low coefficients
GLIDES = ((5000.0, 0.4), (5000.0, 0.6), (5000.0, 0.2), (2000.0, 0.3), (2000.0, 0.1))


@dataclass(frozen=True)
class LevelFlight:
    """A condition at which an aircraft flies level, or a glider glides, and the trim.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        the condition: retractable gear up, fuel frozen
    create : dict
        properties that the model expects from its environment, with their values
    trim : TrimState
        the trim
    """

    aircraft: str
    condition: TrimCondition
    create: Mapping[str, float]
    trim: TrimState


def level_flight(
    aircraft: str,
    root: str | None = None,
    tries: int = len(TRIES),
    solver: Solver | None = None,
    create: Mapping[str, float] | str | None = None,
    substeps: int = 1,
) -> LevelFlight:
    """Find a sensible condition of straight and level flight, or of the glide of a glider.

    The speed follows from the weight and the wing area. Properties that the model expects from its
    environment are created as 0 unless ``create`` has them. A model without an engine
    glides (mode "glide").

    .. math::
        V = \\sqrt{\\frac{2 W}{\\rho_0 S C_L}}

    Parameters
    ----------
    aircraft : str
        name of the model
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    tries : int
        maximum number of conditions to try; a failed trim can take seconds
    solver : str, optional
        as in `TrimCondition`
    create : dict or "missing", optional
        as for `Airframe`
    substeps : int
        JSBSim steps per 1/120 s

    Raises
    ------
    AircraftError
        if the model is unknown, cannot be loaded, or cannot be initialised
    TrimError
        if it trims at none of the conditions; the residuals are those of the first
    """
    tries = integer("tries", tries, low=1)
    airframe, clean = prepared(aircraft, root, create, substeps)
    mode, conditions = ("full", TRIES) if airframe.engines else ("glide", GLIDES)
    return first_trim(airframe, clean, conditions[:tries], mode=mode, solver=solver)


def first_trim(
    airframe: Airframe,
    clean: TrimCondition,
    tries: Sequence[tuple[float, float]],
    fly: float = 0.0,
    **fields: Any,
) -> LevelFlight:
    """The first of the tries at which a prepared aircraft trims, with more of the condition."""
    first: TrimError | None = None
    for altitude, lift_coefficient in tries:
        speed = level_speed(airframe, lift_coefficient)
        condition = replace(clean, altitude=altitude, speed=speed, **fields)
        try:
            # a failed search affects the next one, so each has its own airframe
            state = trim(airframe.twin(), condition, hint=False, fly=fly)
            return LevelFlight(airframe.aircraft, condition, airframe.created, state)
        except TrimError as error:
            first = first or error
    assert first is not None
    attempts = len(tries) - 1
    addition = f" (nor at {attempts} other conditions)" if attempts else ""
    flight = "glide" if fields["mode"] == "glide" else "level flight"
    raise first.reworded(f"no {flight}: {first}{addition}")


def prepared(
    aircraft: str,
    root: str | None,
    create: Mapping[str, float] | str | None = None,
    substeps: int = 1,
) -> tuple[Airframe, TrimCondition]:
    """An initialised airframe, and a condition: gear up, fuel frozen.

    Properties that the model lacks are created as 0 unless ``create`` has them.
    """
    lacking = dict[str, float]()
    while True:
        try:
            airframe = Airframe(aircraft, root=root, create=create, substeps=substeps)
            airframe.run_ic()
            break
        except AircraftError as error:
            # JSBSim names some only when it initialises
            if isinstance(create, str) or not {*error.missing} - {*lacking}:
                raise
            lacking |= dict.fromkeys(error.missing, 0.0)
            create = {**mapping("create", create), **lacking}
    gear = 0.0 if has_retractable_gear(aircraft, root) else None
    frozen = {"propulsion/fuel_freeze": 1.0} if airframe.has("propulsion/fuel_freeze") else {}
    return airframe, TrimCondition(gear=gear, setup=frozen)
