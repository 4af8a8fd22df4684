"""`Track`: one aircraft's flight as columns over time."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import finite, flag, mapping
from ..errors import ParameterError
from .table import frame

if TYPE_CHECKING:
    import pandas

# what a track needs at least: field and the column's label
POSITION = {
    "lat": "latitude [deg]",
    "lon": "longitude [deg]",
    "h": "altitude [ft]",
    "theta": "pitch angle [deg]",
    "phi": "roll angle [deg]",
    "psi": "heading [deg]",
}

FOOT = 0.3048  # m


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
        further columns by their label, such as ``"calibrated airspeed [kt]"``, each of shape (n,)
    about : dict, optional
        text for the head of a report: what was flown, from where
    every_step : bool
        whether the samples are all steps of a simulation, not those of a sampling period: a
        ``.kml`` file then has 5 points per second

    Raises
    ------
    ParameterError
        for columns of different lengths, no samples, values that are not finite, latitudes beyond
        the poles, and times that do not increase
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
        signals = mapping("signals", self.signals)
        flag("every_step", self.every_step)
        given: dict[str, Any] = {name: getattr(self, name) for name in ("time", *POSITION)}
        columns = finite(**given)
        for name, column in zip(given, columns, strict=True):
            object.__setattr__(self, name, np.atleast_1d(column))
        # a signal may be undefined at times, such as the angle of attack at rest
        rest = {label: np.asarray(column, dtype=float) for label, column in signals.items()}
        object.__setattr__(self, "signals", rest)
        for name, column in {**{n: getattr(self, n) for n in given}, **rest}.items():
            if column.shape != self.time.shape or column.ndim != 1 or not column.size:
                raise ParameterError(
                    f"{name} has the shape {column.shape}, time has {self.time.shape}; all columns "
                    "must have the same number of samples, at least 1",
                    parameter=name,
                    value=column.shape,
                )
        if np.any(np.diff(self.time) <= 0):
            raise ParameterError("time must increase", parameter="time", value=self.time)
        if np.max(np.abs(self.lat)) > 90:
            worst = self.lat[np.argmax(np.abs(self.lat))]
            raise ParameterError(
                f"lat must lie in [-90, 90] deg, not {worst:g}", parameter="lat", value=worst
            )

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

    def thinned(self, most: int) -> Track:
        """The track with every n-th sample and the last, ``most`` or fewer before that."""
        step = math.ceil(len(self.time) / most)
        return self if step == 1 else self._with(np.arange(0, len(self.time), step))

    def at_most(self, rate: float) -> Track:
        """The track with the first sample of each period of a rate in 1/s, and the last sample."""
        # a sample that rounding, which adds up over hours, puts just before a period belongs to it
        periods = np.floor((self.time - self.time[0]) * rate + 1e-3)
        return self._with(np.unique(periods, return_index=True)[1])

    def _with(self, samples: np.ndarray) -> Track:
        """These samples and the last."""
        kept = np.unique(np.append(samples, len(self.time) - 1))
        return dataclasses.replace(
            self,
            **{name: getattr(self, name)[kept] for name in ("time", *POSITION)},
            signals={label: column[kept] for label, column in self.signals.items()},
        )
