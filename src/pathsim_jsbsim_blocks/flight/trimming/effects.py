"""Effects of an aircraft's commands, from one finite difference each."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from ..._core.aircraft_ports import throttles
from ..airframe import Airframe
from .condition import TrimCondition
from .equations import RESIDUALS, Effort, SteadyFlight, size
from .initial import engines_off, initialise, properties
from .state import STATE

# command -> the unknowns of a search that represent it, and its primary acceleration
COMMANDS = {
    "throttle": (("throttle",), "udot"),
    "pitch": (("pitch_trim", "elevator"), "qdot"),
    "roll": (("aileron",), "pdot"),
    "yaw": (("rudder",), "rdot"),
}

# change of a command, beyond the hysteresis or dead band of a servo
_STEP = 0.5

# change of an acceleration, in tolerances of the search, below which a command has no effect
NONE = 10.0

# maximum repetitions of a state with memory
_REPEATS = 20


class Effect(NamedTuple):
    """The effect of a command: "throttle", "pitch", "roll" or "yaw"."""

    command: str
    # the properties moved; one per engine for the throttle
    properties: tuple[str, ...]
    # primary response: "udot" (ft/s2), "qdot", "pdot" or "rdot" (rad/s2)
    acceleration: str
    # change of this acceleration per 1 of the command
    size: float
    # whether that is more than the search's tolerance
    moves: bool
    # whether the model writes the command itself, which overwrites other values
    written_by_model: bool


def responses(
    airframe: Airframe, condition: TrimCondition
) -> tuple[dict[str, float], list[Effect]]:
    """Accelerations of an airframe at a condition, and the effects of its commands on them.

    They are those at an angle of attack of 3 deg and half throttle, not of a trim, which need not
    exist. The commands are throttle, pitch, roll and yaw; without an engine there is no throttle.
    """
    settings = properties(airframe, condition, None)
    airframe.write(settings, "setup")
    airframe.stopped = engines_off(airframe, condition, settings)
    with airframe.fuel_frozen(), airframe.engines_stopped():
        initialise(airframe, condition, condition.heading)
        in_time = airframe.has_kind("turboprop")
        flight = SteadyFlight(airframe, condition, Effort(), in_time)
        flight.try_out()
        x = flight.guess(3.0, 0.5)
        at_rest = zip(flight.used, _at_rest(flight, x).tolist(), strict=True)
        accelerations = {name: r * RESIDUALS[name] for name, r in at_rest if name in RESIDUALS}
        return accelerations, list(effects(flight, x, airframe))


def effects(
    flight: SteadyFlight, x: np.ndarray, airframe: Airframe, commands: Iterable[str] = COMMANDS
) -> Iterator[Effect]:
    """The effects, near a state, of commands among the search's unknowns."""
    base = _at_rest(flight, x)
    for command in commands:
        unknowns, acceleration = COMMANDS[command]
        name = next((name for name in unknowns if name in flight.names), "")
        names = throttles(airframe.engines) if name == "throttle" else [STATE[name]] if name else []
        if not names:
            continue
        i, row = flight.names.index(name), flight.used.index(acceleration)
        low, high = float(flight.low[i]), float(flight.high[i])
        flight.effort.steps = 0  # an exhausted effort would keep propellers from settling
        small = _STEP if x[i] + _STEP <= high else -_STEP
        # the model may limit the command to a part of its range: to its ends then
        for step in filter(None, (small, high - float(x[i]), low - float(x[i]))):
            y = x.copy()
            y[i] += step
            motion = flight.settled(y)
            rewrites = any(abs(airframe.fdm[n] - y[i]) > 1e-9 for n in names)
            again = flight.settled(x)
            size = float(motion[row] - base[row]) * RESIDUALS[acceleration] / step
            # without the command, what systems with memory (airships) change meanwhile; NaN is an
            # effect
            moves = not abs(motion[row] - 0.5 * (base[row] + again[row])) <= NONE
            base = again
            if moves:
                break
        yield Effect(command, tuple(names), acceleration, size, moves, rewrites)


def _at_rest(flight: SteadyFlight, x: np.ndarray) -> np.ndarray:
    """Residuals at a state once they repeat, if they do (airships drift)."""
    r = flight.settled(x)
    for _ in range(_REPEATS):
        last, r = r, flight.settled(x)
        if size(r - last) <= 1.0:
            break
    return r
