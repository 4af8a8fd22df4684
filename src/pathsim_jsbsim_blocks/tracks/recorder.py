"""`FlightRecorder`: a scope for the track and the time history of one aircraft."""

from __future__ import annotations

import datetime
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from pathsim.blocks import Scope

from .._core.checks import must_be, name_list, number, optional, refuse
from .._core.parameters import Parametric, parameter
from .._core.pathsim_internals import NamedRegister
from .._core.scopes import name_and_unit, recording
from .files import save_tracks
from .track import POSITION, Track, writable_text

if TYPE_CHECKING:
    import pandas


def _labels(parameter: str, signals: Any) -> list[str]:
    """Labels of signals, checked to give unique port names."""
    signals = name_list(parameter, signals, "a list of labels")
    if not all(isinstance(s, str) for s in signals):
        must_be(parameter, signals, "a list of labels")
    ports = [*POSITION, *(name_and_unit(writable_text(parameter, x))[0] for x in signals)]
    twice = [port for i, port in enumerate(ports) if port in ports[:i]]
    if twice:
        why = f"{parameter} has {twice[0]!r} twice, or it is a port of every recorder: "
        refuse(parameter, signals, why + ", ".join(POSITION))
    return signals


@dataclass(eq=False, repr=False)
class FlightRecorder(Parametric, Scope):
    """Records an aircraft's track and time history, and writes them for other programs.

    It is a scope, so functions that plot and save scopes accept it. `to_frame` gives its recording
    as a pandas table, `to_track` as columns, and `save` writes a table, a file for Tacview or
    Google Earth, or a report to open in a browser.

    Parameters
    ----------
    aircraft : str
        type of the aircraft, such as the name of its JSBSim model
    name : str
        name of the aircraft in the file; default is its type
    signals : list of str
        labels with units of further signals, such as ``"calibrated airspeed [kt]"``; their ports
        follow ``psi``, and the label without its unit is the port's name
    sampling_period : float, optional
        s; default is every step of the diagram, of which a ``.kml`` file gets 5 per second or
        fewer
    t_wait : float
        time at which the recording starts, s

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude, deg
    h
        altitude above mean sea level, ft
    theta, phi, psi
        pitch, roll and heading angle, deg

    Raises
    ------
    ParameterError
        for labels that are not text, are repeated, or are those of the ports above

    Examples
    --------
    >>> recorder = FlightRecorder("c172p", signals=["calibrated airspeed [kt]"])
    >>> recorder.labels[-1], recorder.inputs._map("calibrated airspeed")
    ('calibrated airspeed [kt]', 6)
    """

    # PathView plots blocks of this type; without this attribute it would use the class name
    type_name = "Scope"

    input_port_labels = {name: i for i, name in enumerate(POSITION)}
    output_port_labels = {}
    # inputs that must be connected
    _places = tuple(POSITION)

    aircraft: str = parameter("aircraft", writable_text)
    name: str = parameter("", writable_text)
    signals: Sequence[str] = parameter((), _labels)
    sampling_period: float | None = parameter(None, optional, above=0.0)
    t_wait: float = parameter(0.0, number, low=0.0)

    def _begin(self) -> None:
        period = optional("sampling_period", self.sampling_period, above=0.0)
        Scope.__init__(self, period, number("t_wait", self.t_wait, low=0.0))

    def build(self) -> None:
        signals = self._checked.signals
        if not self._built:
            self._recorded = signals
            self.labels = [*POSITION.values(), *signals]
            ports = [*POSITION, *(name_and_unit(x)[0] for x in signals)]
            self.inputs = NamedRegister(len(ports), {port: i for i, port in enumerate(ports)})
        elif signals != self._recorded:
            why = "signals cannot change because they are the block's ports: build another block"
            refuse("signals", signals, why)

    def to_track(self) -> Track:
        """The recording as a `Track`.

        Raises
        ------
        ParameterError
            if nothing was recorded
        """
        time, data = recording(self)
        return Track(
            self.name or self.aircraft,
            self.aircraft,
            time,
            **dict(zip(POSITION, data, strict=False)),
            signals=dict(zip(self.signals, data[len(POSITION) :], strict=False)),
            every_step=self.sampling_period is None,
        )

    def to_frame(self) -> pandas.DataFrame:
        """The recording as a pandas table: labels as columns, the time in s as the index.

        Raises
        ------
        ParameterError
            if nothing was recorded
        MissingExtraError
            without pandas
        """
        return self.to_track().to_frame()

    def save(
        self, path: str | os.PathLike[str] = "flight.csv", start: datetime.datetime | None = None
    ) -> None:
        """Write the recording to a file; parameters and errors are those of `save_tracks`.

        Parameters
        ----------
        path : str or Path
            ``.csv``, ``.parquet``, ``.acmi``, ``.kml`` or ``.html``
        start : datetime, optional
            date and time of t = 0; default is 2024-03-20 12:00 UTC
        """
        save_tracks(path, [self.to_track()], start)
