"""Gains of the autopilot loops: numbers for each loop, and schedules over altitude and airspeed."""

from __future__ import annotations

import bisect
import dataclasses
import functools
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal, NamedTuple, get_type_hints

from .._core.checks import integer, known_keywords, number, positive, refuse


@dataclass(frozen=True)
class _Gains:
    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = number(field.name, getattr(self, field.name), **_BOUNDS.get(field.name, {}))
            # a plain float: a numpy.float32 would fly in single precision, and JSON lacks it
            object.__setattr__(self, field.name, value)


_POSITIVE = "ramp band hdot_max tau vc_min descent_max vmo mmo lift_max"
# bounds as `number` has them
_BOUNDS: dict[str, Any] = {name: {"above": 0.0} for name in _POSITIVE.split()}
_BOUNDS |= {name: {"low": 0.0} for name in ("b", "Tf", "climb_max")}
_BOUNDS |= {name: {"low": -90.0, "high": 90.0} for name in ("theta_max", "bank", "alpha_zero")}
_BOUNDS["alpha_max"] = {"above": 0.0, "high": 90.0}


@known_keywords
@dataclass(frozen=True)
class AttitudeGains(_Gains):
    """Gains from pitch or roll angle (deg) to the elevator or aileron command (full travel 1).

    Parameters
    ----------
    Kp : float
        1/deg
    Ki : float
        1/(deg s)
    Kr : float
        gain on the body rate q or p, s/deg
    b : float
        weight of the reference in the proportional part
    ramp : float
        maximum rate of the reference, deg/s
    """

    Kp: float
    Ki: float
    Kr: float = 0.0
    b: float = 1.0
    ramp: float = 3.0


@known_keywords
@dataclass(frozen=True)
class HeadingGains(_Gains):
    """Gains from heading error (deg) to the bank reference (deg).

    Parameters
    ----------
    Kp : float
        deg/deg
    Ki : float
        1/s
    bank : float
        bank of straight flight in deg; not 0 with a propeller
    """

    Kp: float
    Ki: float = 0.0
    bank: float = 0.0


@known_keywords
@dataclass(frozen=True)
class AltitudeGains(_Gains):
    """Gains from altitude error (ft) via rate of climb (ft/s) to the pitch reference (deg).

    Parameters
    ----------
    Kh : float
        commanded rate of climb per altitude error, 1/s
    Kp : float
        pitch reference per error of the rate of climb, deg/(ft/s)
    Ki : float
        deg/ft
    hdot_max : float
        maximum commanded rate of climb and descent, ft/s
    theta_max : float
        maximum pitch reference, deg
    """

    Kh: float
    Kp: float
    Ki: float
    hdot_max: float = 10.0
    theta_max: float = 15.0


@known_keywords
@dataclass(frozen=True)
class SpeedGains(_Gains):
    """Gains from airspeed error (kt) to the throttle command (full range 1).

    Parameters
    ----------
    Kp : float
        1/kt
    Ki : float
        1/(kt s)
    Kd : float
        gain on the acceleration, s/kt; with Kd = -Kp Tf the proportional part sees the airspeed
        low-passed with Tf
    Tf : float
        time constant of the acceleration's filter in s
    b : float
        weight of the reference in the proportional part
    ramp : float
        maximum rate of the reference, kt/s
    Kc : float
        throttle fed forward per rate of climb, s/ft
    band : float
        error in kt beyond which each further knot counts as 0.2 kt; the default has no effect
    """

    Kp: float
    Ki: float
    Kd: float = 0.0
    Tf: float = 0.5
    b: float = 1.0
    ramp: float = 1.0
    Kc: float = 0.0
    band: float = 1000.0


@known_keywords
@dataclass(frozen=True)
class YawGains(_Gains):
    """Gains from yaw rate (deg/s), sideslip and roll to the rudder command (full travel 1).

    If positive rudder yaws the nose left, K, Kp and Ki are positive, and Kbank is usually negative.

    Parameters
    ----------
    K : float
        s/deg, on the washed-out yaw rate; 0 if the model has its own damper
    tau : float
        time constant of the wash-out in s
    Kp : float
        turn coordination: rudder per angle of sideslip, 1/deg
    Ki : float
        turn coordination: rudder per integral of the sideslip, 1/(deg s)
    Kroll : float
        turn coordination: rudder per roll rate, s/deg, against the yaw of ailerons and roll rate
    Kbank : float
        turn coordination: rudder per 57.3 times the sine of the bank, 1/deg, for the yaw rate of
        the turn
    """

    K: float
    tau: float = 2.0
    Kp: float = 0.0
    Ki: float = 0.0
    Kroll: float = 0.0
    Kbank: float = 0.0


@known_keywords
@dataclass(frozen=True)
class EnvelopeLimits(_Gains):
    """Limits of the aircraft at one altitude and airspeed, measured in flight.

    Parameters
    ----------
    alpha_max : float
        maximum angle of attack that the holds may command, deg, below the stall
    vc_min : float
        minimum airspeed of level flight at the altitude of the measurement, KCAS; in flight the
        protection estimates it from the angle of attack
    climb_max : float
        rate of climb at full throttle and this airspeed, ft/s
    descent_max : float
        rate of descent at idle and this airspeed, ft/s, positive
    vmo : float
        maximum airspeed that the holds may command, KCAS; the default is no limit
    mmo : float
        likewise, as a Mach number
    alpha_zero : float
        angle of attack at zero lift, deg
    lift_max : float
        maximum lift of level flight as a fraction of that at ``alpha_max``, reached at ``vc_min``.
        With the default the airspeed stays 10 % above that at ``alpha_max``
    """

    alpha_max: float
    vc_min: float
    climb_max: float
    descent_max: float
    vmo: float = 1000.0
    mmo: float = 10.0
    alpha_zero: float = 0.0
    lift_max: float = 0.8264

    def __post_init__(self) -> None:
        super().__post_init__()
        for low, high in (("vc_min", "vmo"), ("alpha_zero", "alpha_max")):
            least, most = getattr(self, low), getattr(self, high)
            if least >= most:
                refuse(low, least, f"{low}, {least:g}, must be below {high}, {most:g}")


@known_keywords
@dataclass(frozen=True)
class AircraftGains:
    """The gains of all loops of one aircraft at one altitude and airspeed.

    Parameters
    ----------
    pitch, roll : AttitudeGains
    heading : HeadingGains
    altitude : AltitudeGains or None
    speed : SpeedGains or None
        None for an aircraft without an engine
    yaw : YawGains
    envelope : EnvelopeLimits, optional
        limits of the protection; None for no protection
    """

    pitch: AttitudeGains
    roll: AttitudeGains
    heading: HeadingGains
    altitude: AltitudeGains | None
    speed: SpeedGains | None
    yaw: YawGains
    envelope: EnvelopeLimits | None = None


# loops that may have no gains, and the kind of each
OPTIONAL = {"altitude": AltitudeGains, "speed": SpeedGains, "envelope": EnvelopeLimits}
LOOPS = {**get_type_hints(AircraftGains), **OPTIONAL}


@known_keywords
@dataclass(frozen=True)
class DesignPoint:
    """Gains, and the altitude and airspeed for which they were designed.

    Parameters
    ----------
    altitude : float
        ft
    speed : float
        KCAS
    gains : AircraftGains
    """

    altitude: float
    speed: float
    gains: AircraftGains

    def __post_init__(self) -> None:
        object.__setattr__(self, "altitude", number("altitude", self.altitude))
        object.__setattr__(self, "speed", positive("speed", self.speed))
        if not isinstance(self.gains, AircraftGains):
            refuse(
                "gains",
                self.gains,
                f"the gains of a design point must be AircraftGains, not {self.gains!r}",
            )


@known_keywords
@dataclass(frozen=True)
class GainSchedule:
    """Gains of one aircraft over altitude and airspeed.

    Between the points every number is interpolated: linearly in airspeed at the altitudes below and
    above, then linearly in altitude. Beyond the outermost points it is constant.

    Parameters
    ----------
    aircraft : str
        model for which the gains were designed
    points : tuple of DesignPoint
        sorted by altitude, and by airspeed within each altitude; all of them have envelope limits,
        or none
    nominal : int
        index of the point whose gains a hold uses if the airspeed is not connected
    landing : str
        landings flown with these gains; "" for none
    no_landing : str
        why `FlareHold` lands in some flares only; "" if it does not warn

    Raises
    ------
    ParameterError
        if there are no points, or they are not sorted
    """

    aircraft: str
    points: tuple[DesignPoint, ...]
    nominal: int = 0
    landing: str = ""
    no_landing: str = ""

    def __post_init__(self) -> None:
        points = self.points
        if not isinstance(points, (list, tuple)) or not all(
            isinstance(point, DesignPoint) for point in points
        ):
            refuse(
                "points",
                points,
                f"the points of a gain schedule must be a list of DesignPoint, not {points!r}",
            )
        places = [(point.altitude, point.speed) for point in points]
        if not places or any(a >= b for a, b in pairwise(places)):
            refuse(
                "points",
                places,
                "a gain schedule needs design points, sorted by altitude and then by airspeed, "
                f"not {places}",
            )
        object.__setattr__(self, "nominal", integer("nominal", self.nominal, low=0))
        if not self.nominal < len(places):
            refuse(
                "nominal",
                self.nominal,
                f"nominal must be the index of one of {len(places)} points, not {self.nominal}",
            )
        for loop in OPTIONAL:
            if len({getattr(point.gains, loop) is None for point in points}) > 1:
                why = f"either all points of a gain schedule must have {loop} gains, or none"
                refuse("points", places, why)
        object.__setattr__(self, "points", tuple(points))

    def at(self, h: float, vc: float) -> AircraftGains:
        """The gains at an altitude (ft) and airspeed (KCAS)."""
        h, vc = number("h", h), number("vc", vc)
        for point in self.points:
            if (point.altitude, point.speed) == (h, vc):
                return point.gains
        place = self.place(vc, h)
        gains = {loop: self.gains_at(loop, place) for loop in self._numbers}
        return AircraftGains(**{**dict.fromkeys(OPTIONAL), **gains})

    def place(self, vc: float, h: float | None = None) -> Place:
        """Position of an airspeed and altitude among the points, for `gains_at`.

        Without an altitude the nominal point's is used; for an airspeed of 0 the nominal point.
        """
        if vc == 0.0:
            nominal = Between(self.nominal, self.nominal, 0.0)
            return Place(nominal, nominal, 0.0)
        altitudes, levels = self._levels
        lower, upper, up = _between(altitudes, self._nominal_altitude if h is None else h)
        return Place(_on(levels[lower], vc), _on(levels[upper], vc), up)

    def gains_at(self, loop: str, place: Place) -> Any:
        """The gains of a loop at a place; not checked, because they lie between checked numbers."""
        rows, (lower, upper, up) = self._numbers[loop], place
        points = lower.first, lower.second, upper.first, upper.second
        corners = zip(*(rows[point] for point in points), strict=True)
        gains = object.__new__(LOOPS[loop])
        gains.__dict__.update(
            (name, (low := a + lower.part * (b - a)) + up * (c + upper.part * (d - c) - low))
            for name, (a, b, c, d) in zip(LOOPS[loop].__dataclass_fields__, corners, strict=True)
        )
        return gains

    @functools.cached_property
    def _nominal_altitude(self) -> float:
        return self.points[self.nominal].altitude

    @functools.cached_property
    def _levels(self) -> tuple[list[float], list[tuple[int, list[float]]]]:
        """The altitudes, and for each the index of its first point and the airspeeds."""
        altitudes = sorted({point.altitude for point in self.points})
        levels = []
        for altitude in altitudes:
            indices = [i for i, point in enumerate(self.points) if point.altitude == altitude]
            levels.append((indices[0], [self.points[i].speed for i in indices]))
        return altitudes, levels

    @functools.cached_property
    def _numbers(self) -> dict[str, list[tuple[float, ...]]]:
        """The numbers of each loop at all points."""
        return {
            loop: [tuple(vars(getattr(point.gains, loop)).values()) for point in self.points]
            for loop in LOOPS
            if getattr(self.points[0].gains, loop) is not None
        }


# names of the tables, which editors complete
# fmt: off
TableName = Literal[
    "737", "737-designed", "737-landing", "787-8", "A320", "A4", "B747", "Boeing314",
    "Concorde", "F4N", "F80C", "J3Cub", "L17", "MD11", "OV10", "Short_S23", "T37", "T38",
    "c172p", "c172p-designed", "c172r", "c182", "c310", "dr1", "f104", "f15", "f16",
    "fokker100", "global5000", "global5000-designed", "pa28", "t6texan2",
]
# fmt: on
# name of a table or of a file, gains, or numbers by name
Gains = TableName | str | Mapping[str, Any] | _Gains | AircraftGains | GainSchedule


class Between(NamedTuple):
    """Indices of two neighbours, and the fraction of the way from the first to the second."""

    first: int
    second: int
    part: float


class Place(NamedTuple):
    """The points around an airspeed at the altitudes below and above, and the fraction between."""

    lower: Between
    upper: Between
    up: float


def _between(places: list[float], x: float) -> Between:
    """The neighbours of x among sorted places; constant beyond the ends."""
    i = bisect.bisect_left(places, x)
    if i == 0:
        return Between(0, 0, 0.0)
    if i == len(places):
        return Between(i - 1, i - 1, 0.0)
    return Between(i - 1, i, (x - places[i - 1]) / (places[i] - places[i - 1]))


def _on(level: tuple[int, list[float]], vc: float) -> Between:
    start, speeds = level
    first, second, part = _between(speeds, vc)
    return Between(start + first, start + second, part)
