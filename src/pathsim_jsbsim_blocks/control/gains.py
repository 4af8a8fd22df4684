"""Gains of the autopilot loops: tables for three aircraft, and numbers from the user."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from .._core.checks import did_you_mean, nearest, number, one_of, positive
from ..errors import ParameterError

# name of a table, or numbers by name
Gains = str | Mapping[str, Any]


@dataclass(frozen=True)
class _Gains:
    def __post_init__(self) -> None:
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name in ("ramp", "hdot_max", "tau"):
                positive(field.name, value)
            else:
                number(field.name, value, low=0.0 if field.name in ("b", "Tf") else -math.inf)


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
        largest rate at which the reference moves, deg/s
    """

    Kp: float
    Ki: float
    Kr: float = 0.0
    b: float = 1.0
    ramp: float = 3.0


@dataclass(frozen=True)
class HeadingGains(_Gains):
    """Gains from heading error (deg) to the bank reference (deg).

    Parameters
    ----------
    Kp : float
        deg/deg
    Ki : float
        1/s
    """

    Kp: float
    Ki: float = 0.0


@dataclass(frozen=True)
class AltitudeGains(_Gains):
    """Gains from altitude error (ft) via rate of climb (ft/s) to the pitch reference (deg).

    Parameters
    ----------
    Kh : float
        rate of climb demanded per altitude error, 1/s
    Kp : float
        pitch reference per error of the rate of climb, deg/(ft/s)
    Ki : float
        deg/ft
    hdot_max : float
        largest rate of climb and descent demanded, ft/s
    """

    Kh: float
    Kp: float
    Ki: float
    hdot_max: float = 10.0


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
        largest rate at which the reference moves, kt/s
    Kc : float
        throttle fed forward per rate of climb, s/ft
    """

    Kp: float
    Ki: float
    Kd: float = 0.0
    Tf: float = 0.5
    b: float = 1.0
    ramp: float = 1.0
    Kc: float = 0.0


@dataclass(frozen=True)
class YawGains(_Gains):
    """Gain from yaw rate (deg/s) to the rudder command (full travel 1).

    Parameters
    ----------
    K : float
        s/deg; positive where positive rudder yaws the nose left; 0 where the model has its own
        damper
    tau : float
        time constant of the wash-out in s
    """

    K: float
    tau: float = 2.0


@dataclass(frozen=True)
class AircraftGains:
    """The gains of all loops of one aircraft.

    Parameters
    ----------
    pitch, roll : AttitudeGains
    heading : HeadingGains
    altitude : AltitudeGains
    speed : SpeedGains
    yaw : YawGains
    """

    pitch: AttitudeGains
    roll: AttitudeGains
    heading: HeadingGains
    altitude: AltitudeGains
    speed: SpeedGains
    yaw: YawGains


_LOOPS = get_type_hints(AircraftGains)

# tuned on each nonlinear aircraft model in still air, at the condition given
GAINS = {
    "c172p": AircraftGains(  # 5000 ft, 90 KCAS
        pitch=AttitudeGains(Kp=0.10, Ki=0.12, Kr=0.004, b=0.45, ramp=4.0),
        roll=AttitudeGains(Kp=0.060, Ki=0.021, Kr=0.004, b=0.85, ramp=10.0),
        heading=HeadingGains(Kp=1.5, Ki=0.001),
        altitude=AltitudeGains(Kh=0.25, Kp=0.083, Ki=0.20, hdot_max=10.0),
        speed=SpeedGains(Kp=0.0235, Ki=0.00026, Kd=-0.0047, Tf=0.2, b=1.097, ramp=2.7, Kc=0.0035),
        yaw=YawGains(K=0.020),
    ),
    "737": AircraftGains(  # 10,000 ft, 280 KCAS, gear up; the model has its own yaw damper
        pitch=AttitudeGains(Kp=0.24, Ki=0.20, Kr=0.060, b=0.50, ramp=4.0),
        roll=AttitudeGains(Kp=0.065, Ki=0.010, Kr=0.0175, b=0.92, ramp=7.0),
        heading=HeadingGains(Kp=3.0, Ki=0.001),
        altitude=AltitudeGains(Kh=0.14, Kp=0.027, Ki=0.049, hdot_max=25.0),
        speed=SpeedGains(Kp=0.050, Ki=0.00062, Kd=-0.050, Tf=1.0, b=0.97, ramp=1.5, Kc=0.007),
        yaw=YawGains(K=0.0),
    ),
    "global5000": AircraftGains(  # 15,000 ft, 250 KCAS, gear up; the model has its own yaw damper
        pitch=AttitudeGains(Kp=0.12, Ki=0.09, Kr=0.027, b=0.60, ramp=4.0),
        roll=AttitudeGains(Kp=0.054, Ki=0.011, Kr=0.005, b=0.94, ramp=7.0),
        heading=HeadingGains(Kp=3.0, Ki=0.001),
        altitude=AltitudeGains(Kh=0.15, Kp=0.027, Ki=0.049, hdot_max=25.0),
        speed=SpeedGains(Kp=0.050, Ki=0.00062, Kd=-0.050, Tf=1.0, b=1.0, ramp=1.5, Kc=0.007),
        yaw=YawGains(K=0.0),
    ),
}


def loop_gains(gains: Any, *loops: str) -> tuple[Any, ...]:
    """The gains of some loops, from the name of a table or from numbers.

    Parameters
    ----------
    gains : str, AircraftGains, dict, or the gains of the loop
        a key of ``GAINS``; or, for one loop, its gains or a dict of their values; or, for several,
        a dict from the loop's name to any of these
    *loops : str
        "pitch", "roll", "heading", "altitude", "speed", "yaw"

    Raises
    ------
    ParameterError
        for an unknown table, loop or gain, naming the nearest, and for a missing one
    """
    if isinstance(gains, str):
        gains = GAINS[one_of("gains", gains, GAINS)]
    if isinstance(gains, AircraftGains):
        return tuple(getattr(gains, loop) for loop in loops)
    if len(loops) == 1:
        return (_one_loop(gains, loops[0]),)
    if not isinstance(gains, Mapping):
        raise ParameterError(
            f"gains must be the name of a table or a dict of the gains of {', '.join(loops)}, "
            f"not {gains!r}",
            parameter="gains",
            value=gains,
        )
    _check_keys(gains, loops, loops, "loop")
    return tuple(loop_gains(gains[loop], loop)[0] for loop in loops)


def _one_loop(gains: Any, loop: str) -> Any:
    kind = _LOOPS[loop]
    if isinstance(gains, kind):
        return gains
    if not isinstance(gains, Mapping):
        raise ParameterError(
            f"{loop} gains must be the name of a table, {kind.__name__} or a dict, not {gains!r}",
            parameter="gains",
            value=gains,
        )
    fields = dataclasses.fields(kind)
    needed = [f.name for f in fields if f.default is dataclasses.MISSING]
    _check_keys(gains, [f.name for f in fields], needed, f"{loop} gain")
    return kind(**gains)


def _check_keys(gains: Mapping, names: Any, needed: Any, what: str) -> None:
    for name in gains:
        if name not in names:
            raise ParameterError(
                f"{name!r} is no {what}; there are {', '.join(names)}"
                + did_you_mean(nearest(str(name), names, 1)),
                parameter="gains",
                value=gains,
            )
    missing = [name for name in needed if name not in gains]
    if missing:
        raise ParameterError(
            f"{what} missing: {', '.join(missing)}", parameter="gains", value=gains
        )
