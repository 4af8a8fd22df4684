"""How JSBSim integrates the equations of motion: its methods by name, and two presets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._core.checks import must_be, one_of

# JSBSim's numbers for simulation/integrator/... (FGPropagate::eIntegrateType)
_METHODS = {
    "none": 0,
    "euler": 1,
    "trapezoidal": 2,
    "adams-bashforth 2": 3,
    "adams-bashforth 3": 4,
    "adams-bashforth 4": 5,
    "adams-bashforth 5": 9,
}
# for the quaternion only; for other states JSBSim throws at the first step
_METHODS_OF_ATTITUDE = {"buss 1": 6, "buss 2": 7, "local linearization": 8}

_STATES = {
    "rate_rotational": _METHODS,
    "rate_translational": _METHODS,
    "position_rotational": {**_METHODS, **_METHODS_OF_ATTITUDE},
    "position_translational": _METHODS,
}


def _property(state: str) -> str:
    return f"simulation/integrator/{state.replace('_', '/')}"


# JSBSim's property for each state, with its numbers by name
INTEGRATORS: Mapping[str, Mapping[str, int]] = {
    _property(state): methods for state, methods in _STATES.items()
}

# third order at most: higher orders bring no gain in NASA's check cases or a doublet, and a c172p
# diverges with them at 30 Hz
PRESETS: Mapping[str, Mapping[str, str]] = {
    "default": {},
    "precise": {
        "rate_rotational": "adams-bashforth 3",
        "rate_translational": "adams-bashforth 3",
        "position_rotational": "buss 2",
        "position_translational": "adams-bashforth 3",
    },
}


def integrator_properties(integrators: Any) -> dict[str, int]:
    """JSBSim's properties for a preset or methods by state, with their values."""
    if isinstance(integrators, str):
        integrators = PRESETS[one_of("integrators", integrators, PRESETS)]
    elif not isinstance(integrators, Mapping):
        presets = ", ".join(map(repr, PRESETS))
        must_be("integrators", integrators, f"one of {presets} or a dict of states and methods")
    properties = {}
    for state, method in integrators.items():
        methods = _STATES[one_of("integrators key", state, _STATES)]
        properties[_property(state)] = methods[one_of(f"integrators[{state!r}]", method, methods)]
    return properties
