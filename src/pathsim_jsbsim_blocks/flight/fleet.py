"""Steady flight for any aircraft model: find a condition, trim, fly and report the result."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from .._core.aircraft_ports import property_of
from .._core.checks import whole
from ..errors import AircraftError, BlocksError, TrimError
from .airframe import Airframe
from .model_files import aircraft_names, has_retractable_gear
from .trimming import TrimState, trim
from .trimming.condition import TrimCondition
from .trimming.nearest import level_speed

# (altitude in ft, lift coefficient): the first suits most aircraft, the second engines that are
# too weak at 5000 ft (pa28), the third aircraft for which 0.4 is too fast
TRIES = ((5000.0, 0.4), (2000.0, 0.4), (5000.0, 0.6))

# the same for a glide: the last for bodies with little lift (Shuttle, x24b)
GLIDES = ((5000.0, 0.4), (5000.0, 0.6), (5000.0, 0.2), (2000.0, 0.3), (2000.0, 0.1))

# s of flight that every aircraft should have fuel for
_FUEL_FOR = 60.0


@dataclass(frozen=True)
class LevelFlight:
    """A condition at which an aircraft flies level, and the trim found there.

    Attributes
    ----------
    aircraft : str
        the model's name
    condition : TrimCondition
        where it trims: retractable gear up, fuel frozen
    create : dict
        properties that the model expects from its environment, set to 0
    trim : TrimState
        the trim found
    """

    aircraft: str
    condition: TrimCondition
    create: Mapping[str, float]
    trim: TrimState


def level_flight(
    aircraft: str, root: str | None = None, tries: int = len(TRIES), solver: str | None = None
) -> LevelFlight:
    """Find a sensible condition of straight and level flight for an aircraft.

    The speed follows from the weight and the wing area. Properties that the model expects from its
    environment are created.

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

    Raises
    ------
    AircraftError
        if the model is unknown, cannot be loaded, or cannot be initialised
    TrimError
        if it trims at none of these; the residuals are those of the first
    """
    tries = whole("tries", tries, low=1)
    return _first(aircraft, root, TRIES[:tries], mode="full", solver=solver)


def _first(
    aircraft: str,
    root: str | None,
    tries: Sequence[tuple[float, float]],
    fly: float = 0.0,
    **fields: Any,
) -> LevelFlight:
    """The first of the tries that trims, with further fields of the condition."""
    airframe, create, clean = prepared(aircraft, root)
    first: TrimError | None = None
    for altitude, lift_coefficient in tries:
        speed = level_speed(airframe, lift_coefficient)
        condition = replace(clean, altitude=altitude, speed=speed, **fields)
        try:
            # a failed search affects the next one, so each has its own airframe
            fresh = Airframe(aircraft, root=root, create=create)
            found = trim(fresh, condition, hint=False, fly=fly)
            return LevelFlight(aircraft, condition, create, found)
        except TrimError as error:
            first = first or error
    assert first is not None
    others = len(tries) - 1
    elsewhere = f" and at {others} other conditions" if others else ""
    sought = "glide" if fields["mode"] == "glide" else "level flight"
    raise first.reworded(f"no {sought}: {first} (tried there{elsewhere})")


def prepared(
    aircraft: str, root: str | None = None
) -> tuple[Airframe, dict[str, float], TrimCondition]:
    """An initialised airframe, properties created for it, and a condition: gear up, fuel frozen."""
    create: dict[str, float] = {}
    while True:
        airframe = Airframe(aircraft, root=root, create=create)
        try:
            airframe.run_ic()
            break
        except AircraftError as error:
            if not error.missing or error.missing in create:
                raise
            create[error.missing] = 0.0
    gear = 0.0 if has_retractable_gear(aircraft, root) else None
    frozen = {"propulsion/fuel_freeze": 1.0} if airframe.has("propulsion/fuel_freeze") else {}
    return airframe, create, TrimCondition(gear=gear, setup=frozen)


@dataclass(frozen=True)
class FleetRow:
    """Result of trimming and flying one aircraft model."""

    aircraft: str
    # None if the model does not load
    engines: int | None
    # None if it does not trim
    flight: LevelFlight | None
    # why it does not load, trim or fly
    error: BlocksError | None
    # engines that stop for want of fuel within 60 s of flight, fuel not frozen
    starved: tuple[int, ...] = ()

    @property
    def drift(self) -> float:
        """Distance in ft above the trimmed path after a flight with controls fixed, or NaN."""
        drift = self.flight.trim.drift if self.flight else None
        return drift.height if drift else math.nan

    @property
    def verdict(self) -> str:
        if self.engines is None:
            return "does not load"
        if isinstance(self.error, TrimError):
            return f"no trim: {self.error.reason}"
        if self.error is not None:
            return f"no flight: {type(self.error).__name__}"
        assert self.flight is not None
        created, found = ", ".join(f"`{n}`" for n in self.flight.create), self.flight.trim
        glides = self.flight.condition.mode == "glide"
        said = f"glides at {found.gamma:.1f} deg" if glides else "trims"
        if not found.steady:
            said += ", not steady"
        if self.starved:
            said += f", engines out of fuel within {_FUEL_FOR:.0f} s"
        return said + (f" with {created} created" if created else "")


def fleet_table(
    names: Iterable[str] | None = None, duration: float = 30.0, tries: int = len(TRIES)
) -> Iterator[FleetRow]:
    """Trim every aircraft and fly it with controls fixed for a time in s; one row at a time.

    Level flight, or else a glide with closed throttle.
    ``names`` are by default those shipped with jsbsim; ``tries`` is as for `level_flight`.
    """
    for name in aircraft_names() if names is None else names:
        engines: int | None = None
        flight: LevelFlight | None = None
        try:
            engines = Airframe(name).engines
            flight = _level_or_glide(name, tries, duration)
            yield FleetRow(name, engines, flight, None, _starved(flight))
        except BlocksError as error:
            yield FleetRow(name, engines, flight, error)


def _level_or_glide(aircraft: str, tries: int, fly: float = 0.0) -> LevelFlight:
    """Level flight, or else a glide; flown for a time in s."""
    try:
        return _first(aircraft, None, TRIES[:tries], fly, mode="full")
    except TrimError as error:
        with contextlib.suppress(TrimError):
            return _first(aircraft, None, GLIDES, fly, mode="glide")
        raise error


def _starved(flight: LevelFlight) -> tuple[int, ...]:
    """Engines that stop for want of fuel in a flight from the trim, controls fixed."""
    airframe = Airframe(flight.aircraft, create=flight.create)
    trim(airframe, flight.condition, hint=False)
    fdm = airframe.fdm
    if airframe.engines:
        fdm["propulsion/fuel_freeze"] = 0.0
    while airframe.engines and fdm.get_sim_time() < _FUEL_FOR and fdm[property_of("h_agl")] > 0.0:
        fdm.run()
    return tuple(airframe.starved())


HEADER = """\
| aircraft | engines | altitude ft | KCAS | gear | alpha deg | throttle | drift ft | verdict |
|---|--:|--:|--:|---|--:|--:|--:|---|
"""


def format_row(row: FleetRow) -> str:
    """One line of the Markdown table under `HEADER`."""
    numbers = [""] * 6
    if row.flight is not None:
        condition, found = row.flight.condition, row.flight.trim
        gear = "up" if condition.gear == 0.0 else "as is"
        throttle = f"{found.throttle[0]:.3f}" if found.throttle else ""
        numbers = [f"{condition.altitude:.0f}", f"{condition.speed:.0f}", gear]
        numbers += [f"{found.alpha:.2f}", throttle, f"{row.drift:+.1f}"]
    engines = "" if row.engines is None else str(row.engines)
    return f"| {' | '.join([row.aircraft, engines, *numbers, row.verdict])} |"
