"""How every aircraft model of jsbsim does in level flight or a glide, as rows of a table."""

import contextlib
import math
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace

from pathsim_jsbsim_blocks.errors import BlocksError, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, LevelFlight, aircraft_names, trim
from pathsim_jsbsim_blocks.flight.fleet import GLIDES, TRIES, first_trim, prepared

# s of flight that every aircraft should have fuel for
_FUEL_FOR = 60.0


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
    # whether JSBSim's own search trims it there too
    by_jsbsim: bool = False

    @property
    def drift(self):
        """Distance in ft above the trimmed path after a flight with controls fixed, or NaN."""
        drift = self.flight.trim.drift if self.flight else None
        return drift.height if drift else math.nan

    @property
    def verdict(self):
        if self.engines is None:
            return "does not load"
        if isinstance(self.error, TrimError):
            return f"no trim: {self.error.reason}"
        if self.error is not None:
            return f"no flight: {type(self.error).__name__}"
        created, found = ", ".join(f"`{n}`" for n in self.flight.create), self.flight.trim
        glides = self.flight.condition.mode == "glide"
        said = f"glides at {found.gamma:.1f} deg" if glides else "trims"
        if not found.steady:
            said += ", not steady"
        if self.starved:
            said += f", engines out of fuel within {_FUEL_FOR:.0f} s"
        return said + (f" with {created} created" if created else "")


def fleet_table(names=None, duration=30.0):
    """Trim every aircraft and fly it with controls fixed for a time in s; one row at a time.

    Level flight, or else a glide with closed throttle.
    ``names`` are by default those shipped with jsbsim.
    """
    for name in aircraft_names() if names is None else names:
        engines = flight = None
        try:
            engines = prepared(name, None)[0].engines
            flight = level_or_glide(name, duration)
            yield FleetRow(name, engines, flight, None, _starved(flight), _by_jsbsim(flight))
        except BlocksError as error:
            yield FleetRow(name, engines, flight, error)


def level_or_glide(aircraft, fly=0.0):
    """Level flight, or else a glide; flown for a time in s."""
    airframe, clean = prepared(aircraft, None)
    try:
        return first_trim(airframe, clean, TRIES, fly, mode="full")
    except TrimError as error:
        with contextlib.suppress(TrimError):
            return first_trim(airframe, clean, GLIDES, fly, mode="glide")
        raise error


def _starved(flight):
    """Engines that stop for want of fuel in a flight from the trim, controls fixed."""
    airframe = Airframe(flight.aircraft, create=flight.create)
    trim(airframe, flight.condition, hint=False)
    fdm = airframe.fdm
    if airframe.engines:
        fdm["propulsion/fuel_freeze"] = 0.0
    while airframe.engines and fdm.get_sim_time() < _FUEL_FOR and fdm["position/h-agl-ft"] > 0.0:
        fdm.run()
    return tuple(airframe.starved())


def _by_jsbsim(flight):
    """Whether JSBSim's own search finds the trim; in a process of its own, which it may abort."""
    with ProcessPoolExecutor(1) as pool:
        try:
            return pool.submit(_searched, flight).result()
        except BrokenProcessPool:
            return False


def _searched(flight):
    try:
        condition = replace(flight.condition, solver="jsbsim")
        trim(Airframe(flight.aircraft, create=flight.create), condition, hint=False)
    except BlocksError:
        return False
    return True


def table_row(row):
    """The row of the table of the fleet, as texts."""
    cells = {"aircraft": row.aircraft, "engines": "" if row.engines is None else f"{row.engines}"}
    search = ""
    if row.flight is not None:
        condition, found = row.flight.condition, row.flight.trim
        cells |= {
            "altitude ft": f"{condition.altitude:.0f}",
            "KCAS": f"{condition.speed:.0f}",
            "gear": "up" if condition.gear == 0.0 else "as is",
            "alpha deg": f"{found.alpha:.2f}",
            "throttle": f"{found.throttle[0]:.3f}" if found.throttle else "",
            "drift ft": f"{row.drift:+.1f}",
        }
        search = "trims" if row.by_jsbsim else "fails"
    return cells | {"verdict": row.verdict, "by JSBSim": search}
