"""Receivers of an instrument landing system: deviations from its two beams."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from .._core.checks import heading, integer, number, positive
from .._core.noise import WhiteNoise
from .._core.parameters import parameter
from .._core.sampling import SampledLaw
from ..axes.navigation import distance, latitude_longitude, line_to, place

RADIUS = 20.9e6  # Earth radius, ft: the surface curves away below a straight glide path
_CORRELATION = 0.5  # correlation time of the noise, s


class _Receiver(SampledLaw):
    """Base of the receivers: limits of the beam, and noise."""

    noise: float
    seed: int
    width: float

    def build(self) -> None:
        self._noise = WhiteNoise(self._checked.seed, 1)
        self._decay = math.exp(-self.clock.period / _CORRELATION)

    def initial_state(self) -> tuple[Any, ...]:
        return 0, 0.0

    def received(self, degrees: float, feet: float, slant: float, state: Any) -> tuple[list, tuple]:
        """Deviation in deg and ft, and the next state; ``slant`` is the distance, ft."""
        k, last = state
        width = self._checked.width
        indication = min(max(degrees, -width), width)
        if self._checked.noise:
            fresh = self._noise.row(k)[0]
            if k:
                # first-order coloured noise whose standard deviation does not depend on T
                fresh = self._decay * last + math.sqrt(1.0 - self._decay**2) * fresh
            last = fresh
        error = indication - degrees + self._checked.noise * last
        # add the error alone: without width and noise the deviation in ft stays exact
        feet += slant * (math.tan(math.radians(degrees + error)) - math.tan(math.radians(degrees)))
        return [degrees + error, feet], (k + 1, last)


@dataclass(eq=False, repr=False)
class Localizer(_Receiver):
    """Receiver of a localizer: lateral deviation from the course to a runway.

    The beam leads along a great circle to the station.

    Parameters
    ----------
    station : (float, float)
        geodetic latitude and longitude of the antenna, deg; usually beyond the runway's far end
    course : float
        true course of the approach, deg
    width : float
        deviation at the edge of the beam, deg, to which ``deg`` and ``ft`` are limited; ``inf`` for
        no limit
    noise : float
        standard deviation of the noise, deg, with a correlation time of 0.5 s
    seed : int
        seed of the random numbers, 0 or more
    T : float
        sample period in s; a new one acts at the next reset

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude, deg

    Outputs
    -------
    deg
        angle between the course and the aircraft seen from the station, positive to the right of
        the course flown, deg
    ft
        distance from the course line, positive to the right, ft
    dist
        distance along the course to the station, ft; negative beyond it

    Raises
    ------
    ParameterError
        for values that are not finite or out of range
    """

    station: tuple[float, float] = parameter((0.0, 0.0), latitude_longitude)
    course: float = parameter(0.0, heading)
    width: float = parameter(math.inf, number, above=0.0, infinite=True)
    noise: float = parameter(0.0, number, low=0.0)
    seed: int = parameter(0, integer, low=0)
    T: float = parameter(1 / 120, positive)

    measured = ("lat", "lon")
    input_port_labels = {"lat": 0, "lon": 1}
    output_port_labels = {"deg": 0, "ft": 1, "dist": 2}

    def build(self) -> None:
        super().build()
        self._line = line_to(place(*self._checked.station), self._checked.course)

    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        offset, to_go, _ = self._line.track_at(place(*u))
        degrees = math.degrees(math.atan2(offset, abs(to_go)))
        deviation, state = self.received(degrees, offset, abs(to_go), state)
        return [*deviation, to_go], state


@dataclass(eq=False, repr=False)
class Glideslope(_Receiver):
    """Receiver of a glideslope: vertical deviation from the glide path to a runway.

    The glide path is a straight line that meets the ground at the station; the Earth's surface
    curves away below it.

    Parameters
    ----------
    station : (float, float)
        geodetic latitude and longitude of the point where the path meets the ground, deg: the
        aiming point of the landing
    elevation : float
        elevation of that point above sea level, ft
    angle : float
        glide path angle in [0.1, 20], deg
    width : float
        deviation at the edge of the beam, deg, to which ``deg`` and ``ft`` are limited; ``inf`` for
        no limit
    noise : float
        standard deviation of the noise, deg, with a correlation time of 0.5 s
    seed : int
        seed of the random numbers, 0 or more
    T : float
        sample period in s; a new one acts at the next reset

    Inputs
    ------
    lat, lon
        geodetic latitude and longitude, deg
    h
        altitude above mean sea level, ft

    Outputs
    -------
    deg
        angle above the path seen from the station, deg
    ft
        height above the path, ft
    dist
        distance to the station over the ground, ft

    Raises
    ------
    ParameterError
        for values that are not finite or out of range
    """

    station: tuple[float, float] = parameter((0.0, 0.0), latitude_longitude)
    elevation: float = parameter(0.0, number)
    angle: float = parameter(3.0, number, low=0.1, high=20.0)
    width: float = parameter(math.inf, number, above=0.0, infinite=True)
    noise: float = parameter(0.0, number, low=0.0)
    seed: int = parameter(0, integer, low=0)
    T: float = parameter(1 / 120, positive)

    measured = ("lat", "lon", "h")
    input_port_labels = {"lat": 0, "lon": 1, "h": 2}
    output_port_labels = {"deg": 0, "ft": 1, "dist": 2}

    def law(self, u: list[float], state: tuple[Any, ...]) -> tuple[list[float], tuple[Any, ...]]:
        c = self._checked
        ground_distance = distance(place(*u[:2]), place(*c.station))
        degrees, feet = above_path(u[2] - c.elevation, ground_distance, c.angle)
        deviation, state = self.received(degrees, feet, ground_distance, state)
        return [*deviation, ground_distance], state


def above_path(height: float, ground_distance: float, angle: float) -> tuple[float, float]:
    """Angle (deg) and height (ft) above a glide path that meets the ground at a distance.

    ``height`` is the altitude less the foot's elevation; the Earth's curvature reduces it.
    """
    height -= ground_distance * ground_distance / (2.0 * RADIUS)
    return (
        math.degrees(math.atan2(height, ground_distance)) - angle,
        height - ground_distance * math.tan(math.radians(angle)),
    )
