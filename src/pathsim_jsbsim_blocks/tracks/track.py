"""`Track`: one aircraft's flight as columns over time."""

from __future__ import annotations

import dataclasses
import datetime
import html
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import finite, flag, mapping, must_be, refuse
from .._core.extras import required
from .._core.scopes import recording, signal_label

if TYPE_CHECKING:
    import pandas
    from pathsim.blocks import Scope

# required fields of a track, with the labels of their columns
POSITION = {
    "lat": "latitude [deg]",
    "lon": "longitude [deg]",
    "h": "altitude [ft]",
    "theta": "pitch angle [deg]",
    "phi": "roll angle [deg]",
    "psi": "heading [deg]",
}


# control characters, lone surrogates and noncharacters, most of which XML cannot represent
_UNWRITABLE = re.compile("[^\t\n -~\u00a0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def instant(start: datetime.datetime, seconds: float) -> str:
    """ISO 8601 of a time after ``start`` (UTC). `strftime` would not pad years before 1000."""
    when = start.replace(tzinfo=None) + datetime.timedelta(seconds=seconds)
    return when.isoformat(timespec="microseconds") + "Z"


def writable_text(parameter: str, text: Any) -> str:
    """``text`` if every format of a track can hold it."""
    if not isinstance(text, str):
        must_be(parameter, text, "text")
    if match := _UNWRITABLE.search(text):
        why = f"the character {match[0]!r}, which files of tracks cannot store, in {text!r}"
        refuse(parameter, text, f"{parameter} has {why}")
    return text


@dataclass(frozen=True, eq=False)
class Track:
    """One aircraft's flight: position, attitude and further signals over time.

    Parameters
    ----------
    name : str
        name of the aircraft in the file
    aircraft : str
        its type, such as the name of the JSBSim model
    time : array, shape (n,)
        s, increasing
    lat, lon : arrays, shape (n,)
        geodetic latitude and longitude, deg
    h : array, shape (n,)
        altitude above mean sea level, ft
    theta, phi, psi : arrays, shape (n,)
        pitch, roll and heading angle, deg
    signals : dict, optional
        further columns by their label, such as ``"calibrated airspeed [kt]"``, each of shape (n,);
        NaN if a signal is undefined
    about : dict, optional
        text for the head of a report, such as the trimmed condition
    every_step : bool
        whether there is a sample for every simulation step, not for every sampling period: a
        ``.kml`` file then has 5 points per second, or fewer if it gets large

    Raises
    ------
    ParameterError
        for columns of different lengths, no samples, positions and angles that are not finite,
        latitudes beyond 90 deg, times that do not increase, text with control characters, and
        a signal with the label of a column of the track
    """

    name: str
    aircraft: str
    time: np.ndarray
    lat: np.ndarray
    lon: np.ndarray
    h: np.ndarray
    theta: np.ndarray
    phi: np.ndarray
    psi: np.ndarray
    signals: Mapping[str, np.ndarray] = field(default_factory=dict)
    about: Mapping[str, str] = field(default_factory=dict)
    every_step: bool = False

    def __post_init__(self) -> None:
        flag("every_step", self.every_step)
        writable_text("name", self.name)
        writable_text("aircraft", self.aircraft)
        about = {str(key): str(text) for key, text in mapping("about", self.about).items()}
        writable_text("about", "\n".join([*about, *about.values()]))
        object.__setattr__(self, "about", about)
        fields: dict[str, Any] = {name: getattr(self, name) for name in ("time", *POSITION)}
        columns = finite(**fields)
        for name, column in zip(fields, columns, strict=True):
            object.__setattr__(self, name, np.atleast_1d(column))
        signals = mapping("signals", self.signals)
        series = {label: _signal(label, column) for label, column in signals.items()}
        object.__setattr__(self, "signals", series)
        for name, column in {**{n: getattr(self, n) for n in fields}, **series}.items():
            if column.shape != self.time.shape or column.ndim != 1 or not column.size:
                why = f"{name} has the shape {column.shape}, time has {self.time.shape}"
                rule = "all columns must have the same number of samples, at least 1"
                refuse(name, column.shape, f"{why}; {rule}")
        if np.any(np.diff(self.time) <= 0):
            refuse("time", self.time, "time must increase")
        if np.max(np.abs(self.lat)) > 90:
            worst = self.lat[np.argmax(np.abs(self.lat))]
            refuse("lat", worst, f"lat must lie in [-90, 90] deg, not {worst:g}")

    @property
    def columns(self) -> dict[str, np.ndarray]:
        """All columns but the time, by their labels."""
        return {**{text: getattr(self, name) for name, text in POSITION.items()}, **self.signals}

    def to_frame(self) -> pandas.DataFrame:
        """The columns as a pandas table; the index is the time in s.

        Raises
        ------
        MissingExtraError
            without pandas
        """
        return frame(self.time, self.columns)

    def at_most(self, most: float) -> Track:
        """The track thinned out to evenly spaced samples, at most ``most``, and the last one."""
        n = len(self.time)
        if n <= most:
            return self
        span = self.time[-1] - self.time[0]
        # tolerance: rounding may put a sample just before the start of its period
        periods = np.floor((self.time - self.time[0]) / span * most + 1e-3)
        indices = np.union1d(np.unique(periods, return_index=True)[1], [n - 1])
        return dataclasses.replace(
            self,
            **{name: getattr(self, name)[indices] for name in ("time", *POSITION)},
            signals={label: column[indices] for label, column in self.signals.items()},
        )

    @property
    def description(self) -> str:
        """Type and ``about`` as HTML, for viewers that display it."""
        lines = [self.aircraft, *(f"{key}: {text}" for key, text in self.about.items())]
        return "<br>".join(map(html.escape, lines))


def frame(time: np.ndarray, columns: Mapping[str, np.ndarray]) -> pandas.DataFrame:
    """A pandas table of columns over time."""
    pandas = required("pandas", "tracks")
    return pandas.DataFrame(dict(columns), index=pandas.Index(time, name="time [s]"))


def to_frame(scope: Scope) -> pandas.DataFrame:
    """The recording of a scope as a pandas table; its labels are the columns' names.

    Parameters
    ----------
    scope : pathsim.blocks.Scope
        with recorded data

    Returns
    -------
    pandas.DataFrame
        one column for each signal; the index is the time in s

    Raises
    ------
    ParameterError
        if nothing was recorded
    MissingExtraError
        without pandas
    """
    time, data = recording(scope)
    return frame(time, {signal_label(scope, i): values for i, values in enumerate(data)})


def _signal(label: Any, values: Any) -> np.ndarray:
    """A further column; NaN is allowed: some signals are undefined at times, e.g. alpha at rest."""
    writable_text("signals", label)
    if label in ("time [s]", *POSITION.values()):
        refuse("signals", label, f"signals has {label!r}, a column of every track")
    try:
        return np.asarray(values).astype(float, casting="same_kind")
    except (TypeError, ValueError):
        must_be(label, values, "an array of real numbers")
