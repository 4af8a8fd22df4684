"""Which properties of JSBSim may be written, also as inputs, and with which values.

JSBSim reacts to some properties when they are written. An exception or a null pointer in that code
ends the process.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping, Sequence

from .._core.checks import number, refuse
from ..errors import PropertyError
from .integrators import INTEGRATORS
from .model_xml import Engine
from .planet import GRAVITY

# refuses a value; called with its name for the message, and the value
Check = Callable[[str, float], object]

# property -> what writing it would do, and what to use instead
_NEVER = {
    "simulation/pause": "it would stop the aircraft's clock",
    "simulation/reset": "it would set the aircraft's clock back; reset the simulation instead",
    "simulation/do_linearization": "it would leave the aircraft's clock stopped; use linear_model "
    "of an aircraft block",
    "simulation/jsbsim-debug": "it would print; listen to the logger instead",
    "simulation/do_simple_trim": "it trims the aircraft again, and a search that fails ends the "
    "process; use mode of the trim condition, or trim_here in flight",
}

_INJECTION = re.compile(r"(propulsion/engine(?:\[\d+\])?)/injection_cmd")

# JSBSim integrates these: a write moves the aircraft
_STATES = re.compile(r"position/(h-(sl|agl)-(ft|meters|km)|(lat|long)-gc-(deg|rad))")

_RUN_ENGINES = "propulsion/set-running"
ENGINE_RUNS = re.compile(r"propulsion/engine(?:\[(\d+)\])?/set-running")

_RANGES = {  # property: minimum and maximum value
    r"inertia/pointmass-weight-lbs(\[\d+\])?": (0.0, math.inf),
    r"propulsion/tank(\[\d+\])?/contents-lbs": (0.0, math.inf),
    # JSBSim maps all other values to the same seed
    r"(simulation|atmosphere)/randomseed": (-(2.0**31), 2.0**31 - 1.0),
    # JSBSim creates all cells immediately, until the memory is full
    r"atmosphere/updownburst/number-of-cells": (0.0, 1000.0),
}

# property -> its values by their names
_NUMBERED = {
    "simulation/gravity-model": GRAVITY,
    # with any other number the air is calm
    "atmosphere/turb-type": {"none": 0, "standard": 1, "culp": 2, "milspec": 3, "tustin": 4},
    **INTEGRATORS,
}


def why_not(name: str, has: Callable[[str], bool]) -> str:
    """Why a property, as JSBSim's catalogue spells it, is never written; empty for others."""
    engine = _INJECTION.fullmatch(name)
    if engine and not has(f"{engine[1]}/Injection"):
        return "this engine has no table of the thrust with injection, which JSBSim would read"
    return _NEVER.get(name, "")


def why_no_input(name: str) -> str:
    """Why a property that can be written is not an input; empty for others."""
    if name == _RUN_ENGINES:
        return "writing it starts engines again at every sample"
    if _STATES.fullmatch(name):
        return (
            "JSBSim integrates it, and writing it moves the aircraft at every sample; altitude, "
            "latitude and longitude of the start belong to the trim condition"
        )
    if name.startswith("ic/"):
        return (
            "JSBSim reads it only at the start of a flight; write it with the trim condition "
            f"or setup={{{name!r}: value}}"
        )
    return ""


def value_check(
    name: str, aircraft: str, engine_list: Callable[[], Sequence[Engine]]
) -> Check | None:
    """A check for values of a property; None if JSBSim accepts any."""
    for pattern, (low, high) in _RANGES.items():
        if re.fullmatch(pattern, name):
            return lambda label, value: number(label, value, low=low, high=high)
    if name in _NUMBERED:
        return lambda label, value: _check_numbered(label, value, _NUMBERED[name])
    if name == _RUN_ENGINES:
        return _started(name, aircraft, len(engine_list()))
    if running := ENGINE_RUNS.fullmatch(name):
        for engine in engine_list():
            if engine.number == int(running[1] or 0) and engine.follows_throttle:
                return _not_stopped(name, aircraft, engine)
    return None


def _started(name: str, aircraft: str, engines: int) -> Check:
    def check(label: str, value: float) -> None:
        if value not in range(-1, engines):
            valid = f"the engines 0 to {engines - 1}, and -1 starts them all" if engines else "none"
            why = f"{label} cannot be {value:g}: aircraft {aircraft!r} has {valid}; engines_off of "
            raise PropertyError(
                f"{why}the trim condition stops engines", aircraft=aircraft, name=name
            )

    return check


def _not_stopped(name: str, aircraft: str, engine: Engine) -> Check:
    def check(label: str, value: float) -> None:
        if not value:
            why = f"{label} of aircraft {aircraft!r} cannot be 0: {cannot_stop(engine)}"
            refuse(name, value, why)

    return check


def cannot_stop(engine: Engine) -> str:
    """Why an engine that follows its throttle cannot be stopped."""
    return (
        f"engine {engine.number} is {engine.type}, which only its throttle stops, "
        f"fcs/throttle-cmd-norm[{engine.number}]"
    )


def _check_numbered(label: str, value: float, numbers: Mapping[str, int]) -> None:
    if value not in numbers.values():
        choices = ", ".join(f"{number} ({name})" for name, number in numbers.items())
        refuse(label, value, f"{label} must be one of {choices}, not {value:g}")
