"""What the commands of an aircraft move: one difference each."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from ..._core.aircraft_ports import throttles
from ...errors import TrimError
from ..airframe import Airframe
from .condition import TrimCondition
from .equations import RESIDUALS, Effort, SteadyFlight
from .failure import failure
from .initial import engines_off, initialise, properties
from .search import Reached
from .state import STATE

# command: the quantity of a search that moves it, and the acceleration it is for
_UNKNOWNS = {"throttle": "throttle", "pitch": "elevator", "roll": "aileron", "yaw": "rudder"}
_ACCELERATIONS = {"throttle": "udot", "pitch": "qdot", "roll": "pdot", "yaw": "rdot"}

# of a command, more than the hysteresis or dead band of a servo
_STEP = 0.5

# tolerances of the search, below which a change of acceleration is none
_NONE = 10.0


class Effect(NamedTuple):
    """The effect of a command.

    Attributes
    ----------
    command : str
        "throttle", "pitch", "roll" or "yaw"
    properties : tuple[str, ...]
        the properties that were moved, one of each engine for the throttle
    acceleration : str
        what it is for: "udot" (ft/s2), "qdot", "pdot" or "rdot" (rad/s2), as in `TrimState`
    size : float
        the change of this acceleration by the command, per 1 of it
    moves : bool
        whether it changes any of the accelerations
    written_by_model : bool
        whether the model writes the command itself, so that nobody else can
    """

    command: str
    properties: tuple[str, ...]
    acceleration: str
    size: float
    moves: bool
    written_by_model: bool


def command_effects(
    airframe: Airframe, condition: TrimCondition, setup: Mapping[str, float] | None = None
) -> list[Effect]:
    """The effects of throttle, pitch, roll and yaw command of an airframe at a condition.

    They are those at an angle of attack of 3 deg and half throttle, not of a trim, which need not
    exist. Without an engine there is no throttle.
    """
    written = properties(airframe, condition, setup)
    airframe.write(written, "setup")
    airframe.stopped = engines_off(airframe, condition, written)
    with airframe.fuel_frozen(), airframe.engines_stopped():
        initialise(airframe, condition, condition.heading)
        in_time = airframe.has_kind("turboprop")
        flight = SteadyFlight(airframe, condition, Effort(), in_time)
        return effects(flight, flight.guess(3.0, 0.5), airframe)


def effects(flight: SteadyFlight, x: np.ndarray, airframe: Airframe) -> list[Effect]:
    """The effects of the commands near a state of a flight."""
    found = []
    before = flight.settled(x)
    for command, name in _UNKNOWNS.items():
        acceleration = _ACCELERATIONS[command]
        names = tuple(throttles(airframe.engines)) if name == "throttle" else (STATE[name],)
        if not names or acceleration not in flight.used:
            continue
        step, after = flight.moved(x, name, _STEP)
        commanded = flight.value(x, name) + step
        change = after - before
        axis = flight.used.index(acceleration)
        found.append(
            Effect(
                command,
                names,
                acceleration,
                float(change[axis]) * RESIDUALS[acceleration] / step,
                # NaN is an effect
                not float(abs(change).max()) <= _NONE,
                any(abs(airframe.fdm[n] - commanded) > 1e-9 for n in names),
            )
        )
    flight.settled(x)
    return found


def model_fault(
    airframe: Airframe,
    condition: TrimCondition,
    flight: SteadyFlight,
    end: Reached,
    bound: str,
    residuals: Mapping[str, float],
) -> TrimError | None:
    """The error of a search that has ended because of what the model is, if it has.

    ``bound`` is the quantity at the end of its range, which is the cause where more is left of its
    acceleration than of that of a command without effect.
    """
    if airframe.has_kind("rotor"):
        why = "it is a rotorcraft (its thruster is a rotor), which this search does not trim"
        return failure(airframe, condition, "rotorcraft", why, residuals)
    found = effects(flight, end.x, airframe)
    if not any(airframe.fdm[f"forces/fb{axis}-aero-lbs"] for axis in "xyz"):
        why = "the model has no aerodynamic force"
        return failure(airframe, condition, "aerodynamics", why, residuals)
    left = dict(zip(flight.used, abs(end.residuals).tolist(), strict=True))
    for effect in found:
        unknown, remains = _UNKNOWNS[effect.command], left[effect.acceleration]
        is_cause = bound in ("", unknown) or remains == max(left.values())
        if effect.moves or unknown not in flight.names or remains <= 1.0 or not is_cause:
            continue
        names = " to ".join(dict.fromkeys((effect.properties[0], effect.properties[-1])))
        why = f"the {effect.command} command, {names}, moves nothing"
        if effect.written_by_model:
            why += ": the model writes it itself"
        return failure(
            airframe,
            condition,
            "no effect",
            why,
            residuals,
            command=effect.command,
            properties={name: airframe.fdm[name] for name in effect.properties},
        )
    return None
