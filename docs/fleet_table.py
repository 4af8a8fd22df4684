"""The table of the fleet: every aircraft trimmed in level flight and flown, and how it went."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from pathsim import Simulation

from pathsim_jsbsim_blocks import BlocksError, JSBSimFDM, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, LevelFlight, aircraft_names, level_flight
from pathsim_jsbsim_blocks.flight.fleet import TRIES

# ft; what drifts further is unstable, or its thrust was not settled when it was trimmed
_STEADY = 20.0


@dataclass(frozen=True)
class FleetRow:
    """How one aircraft model does.

    Attributes
    ----------
    aircraft : str
        the model's name
    engines : int or None
        number of engines; None if the model does not load
    flight : LevelFlight or None
        where it trims; None if it does not
    drift : float
        change of altitude in ft with the trimmed controls held; NaN if it does not fly
    error : BlocksError or None
        why it does not load, trim or fly
    """

    aircraft: str
    engines: int | None
    flight: LevelFlight | None
    drift: float
    error: BlocksError | None

    @property
    def verdict(self) -> str:
        """In a few words how it went."""
        if self.engines is None:
            return "does not load"
        if isinstance(self.error, TrimError):
            return f"no trim: {self.error.reason}"
        if self.error is not None:
            return f"no flight: {type(self.error).__name__}"
        created = ", ".join(f"`{name}`" for name in self.flight.create) if self.flight else ""
        steady = "trims" if abs(self.drift) < _STEADY else "trims, then departs"
        return steady + (f" with {created} created" if created else "")


def fleet_table(names: Iterable[str] | None = None, duration: float = 30.0,
                tries: int = len(TRIES)) -> Iterator[FleetRow]:
    """Trim every aircraft in level flight and fly it, controls held; one row after the other.

    Parameters
    ----------
    names : iterable of str, optional
        aircraft models; default is all that jsbsim brings
    duration : float
        time to fly in s
    tries : int
        as for `level_flight`
    """
    for name in aircraft_names() if names is None else names:
        yield _row(name, duration, tries)


def _row(name: str, duration: float, tries: int) -> FleetRow:
    engines: int | None = None
    flight: LevelFlight | None = None
    try:
        engines = Airframe(name).engines
        flight = level_flight(name, tries=tries)
        return FleetRow(name, engines, flight, _drift(flight, duration), None)
    except BlocksError as error:
        return FleetRow(name, engines, flight, math.nan, error)


def _drift(flight: LevelFlight, duration: float) -> float:
    fdm = JSBSimFDM(aircraft_model=flight.aircraft, condition=flight.condition,
                    create=flight.create, output_properties=["position/h-sl-ft"])
    start = float(fdm.outputs[0])
    Simulation([fdm], dt=fdm.T, log=False).run(duration)
    return float(fdm.outputs[0]) - start


HEADER = """\
| aircraft | engines | altitude ft | KCAS | gear | alpha deg | throttle | drift ft | verdict |
|---|--:|--:|--:|---|--:|--:|--:|---|
"""


def format_row(row: FleetRow) -> str:
    """One line of a Markdown table, to stand below `HEADER`."""
    if row.flight is None:
        numbers = [""] * 6
    else:
        condition, found = row.flight.condition, row.flight.trim
        numbers = [f"{condition.altitude:.0f}", f"{condition.speed:.0f}",
                   "up" if condition.gear == 0.0 else "as is", f"{found.alpha:.2f}",
                   f"{found.throttle[0]:.3f}", f"{row.drift:+.1f}"]
    engines = "" if row.engines is None else str(row.engines)
    return f"| {' | '.join([row.aircraft, engines, *numbers, row.verdict])} |"
