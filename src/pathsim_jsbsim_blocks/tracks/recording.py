"""Record all flights of a script, with or without recorders in its diagrams."""

from __future__ import annotations

import contextlib
from array import array
from collections.abc import Callable, Iterator

import numpy as np

from .._core.aircraft_ports import ALMOST_NORTH, OUTPUTS, property_of, throttles
from ..flight import from_trim
from ..flight.block import FlightBlock
from .track import POSITION, Track

# port or property, and factor, by label; those that a model lacks are omitted
_SIGNALS = {
    label: (property_of(name), OUTPUTS[name].factor if name in OUTPUTS else 1.0)
    for label, name in {
        **{label: port for port, label in POSITION.items()},
        "height above ground [ft]": "h_agl",
        "rate of climb [ft/s]": "hdot",
        "calibrated airspeed [kt]": "vc",
        "true airspeed [kt]": "velocities/vtrue-kts",
        "Mach number": "mach",
        "angle of attack [deg]": "alpha",
        "sideslip angle [deg]": "beta",
        "flight path angle [deg]": "gamma",
        "roll rate [deg/s]": "p",
        "pitch rate [deg/s]": "q",
        "yaw rate [deg/s]": "r",
        "longitudinal load factor [g]": "nx",
        "vertical load factor [g]": "nz",
        "elevator": "fcs/elevator-pos-norm",
        "left aileron": "fcs/left-aileron-pos-norm",
        "right aileron": "fcs/right-aileron-pos-norm",
        "rudder": "fcs/rudder-pos-norm",
        "flaps": "flaps",
        "speed brake": "speedbrake",
        "gear": "gear",
        "throttle": throttles(1)[0],
        "thrust of engine 1 [lbf]": "propulsion/engine/thrust-lbs",
        "fuel [lb]": "propulsion/total-fuel-lbs",
        "weight [lb]": "inertia/weight-lbs",
    }.items()
}


class Recording:
    """The flight of one block, one row for each sample instant."""

    def __init__(self, flown: FlightBlock):
        self.block = flown
        self._rows = array("d")
        self._readers: list[Callable[[], float]] = []
        self._labels: list[str] = []
        fly, take_off = flown.advance, flown.take_off

        def take_off_and_begin(y: list[float]) -> None:
            take_off(y)
            self._begin()

        def advance(index: int, u: list[float]) -> list[float]:
            y = fly(index, u)
            self._keep(index)
            return y

        flown.advance = advance  # type: ignore[method-assign]
        flown.take_off = take_off_and_begin  # type: ignore[method-assign]
        self._begin()

    def _begin(self) -> None:
        airframe = self.block.airframe
        self._labels = [label for label, (name, _) in _SIGNALS.items() if airframe.has(name)]
        self._readers = [airframe.reader(_SIGNALS[label][0]) for label in self._labels]
        self._keep(0)

    def _keep(self, index: int) -> None:
        clock = self.block.clock
        row = [clock.start + index * clock.period, *(read() for read in self._readers)]
        # after an interrupt the last instant is repeated, so overwrite from its row on
        self._rows[index * len(row) :] = array("d", row)

    @property
    def flown(self) -> bool:
        """Whether the aircraft has flown beyond its initial instant."""
        return self.block.samples > 0

    def track(self, name: str) -> Track:
        """The flight up to the current instant of the diagram."""
        width = 1 + len(self._labels)
        rows = np.array(self._rows).reshape(-1, width)[: self.block.samples + 1]
        columns = {
            label: column * _SIGNALS[label][1]
            for label, column in zip(self._labels, rows.T[1:], strict=True)
        }
        # as at the port
        heading = columns[POSITION["psi"]]
        heading[heading > ALMOST_NORTH] = 0.0
        return Track(
            name,
            self.block.airframe.aircraft,
            rows[:, 0],
            **{field: columns.pop(label) for field, label in POSITION.items()},
            signals=columns,
            every_step=True,
            about={
                "trimmed at": str(self.block.trim.condition),
                "JSBSim steps per s": f"{self.block.substeps / self.block.clock.period:.6g}",
            },
        )


@contextlib.contextmanager
def recorded_flights() -> Iterator[list[Recording]]:
    """Context in which all aircraft blocks record their flights, in the order of their building."""
    recordings: list[Recording] = []

    def record(flown: FlightBlock) -> None:
        if all(r.block is not flown for r in recordings):
            recordings.append(Recording(flown))

    from_trim.at_take_off.append(record)
    try:
        yield recordings
    finally:
        from_trim.at_take_off.remove(record)


def tracks(recordings: list[Recording]) -> list[Track]:
    """Tracks of all aircraft that have flown; several of one model are numbered."""
    flown = [r for r in recordings if r.flown]
    models = [r.block.airframe.aircraft for r in flown]
    labels = [f"{model} {models[: i + 1].count(model)}" for i, model in enumerate(models)]
    names = [n if models.count(m) > 1 else m for m, n in zip(models, labels, strict=True)]
    return [recording.track(name) for recording, name in zip(flown, names, strict=True)]
