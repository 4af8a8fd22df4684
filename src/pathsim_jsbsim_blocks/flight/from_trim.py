"""Linear model, response and trim of a flight, each made with another aircraft."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

import numpy as np

from .._core.checks import one_of
from .._core.pathsim_internals import values
from ..linear.model import LinearModel, find
from .flightgear import sending_to
from .linearise.algebraic import algebraic_model
from .linearise.flown import flown_model
from .linearise.flyable import Flyable, no_model
from .trimming import TrimState, trim
from .trimming.initial import here

# called with each block that has taken off: when it is built, and again after a reset
at_take_off: list[Callable[[Any], None]] = []


@contextlib.contextmanager
def _unobserved() -> Iterator[None]:
    """Context in which blocks take off without being recorded."""
    observers, at_take_off[:] = at_take_off[:], []
    try:
        yield
    finally:
        at_take_off[:] = observers


def twin(flown: Flyable) -> Any:
    """A sealed block with the same parameters and a fresh aircraft, trimmed as this one was."""
    # the constructor of a user's subclass may have other parameters
    block: Any = next(c for c in type(flown).__mro__ if "__dataclass_fields__" in vars(c))
    parameters = {f.name: getattr(flown, f.name) for f in fields(block)}
    sealed = dict.fromkeys(("allow_network", "allow_files"), False)
    other = block.__new__(block)
    other.__dict__["_before"] = flown._before
    with _unobserved(), sending_to(None):
        other.__init__(**{**parameters, **sealed, "flightgear": None})
    return other


def trim_here(flown: Flyable, changes: Mapping[str, Any]) -> TrimState:
    """Trim the present flight with changes of its condition, as of `FlightBlock.trim_here`."""
    condition = here(flown.airframe, flown.trim.condition, flown.setup, changes)
    return trim(flown.airframe.twin(), condition)


def linear_model(
    flown: Flyable,
    method: str,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Linear model about the trim of a block, as of `FlightBlock.linear_model`."""
    one_of("method", method, ["flown", "algebraic"])
    mode = flown.trim.condition.mode
    if mode in ("none", "ground", "pull-up"):
        raise no_model(flown, "no trim", f"it is not in steady flight (mode={mode!r})")
    make = flown_model if method == "flown" else algebraic_model
    return make(lambda: twin(flown), inputs, outputs, amplitude)


def response(flown: Flyable, input: str, increments: Sequence[float], output: str) -> np.ndarray:
    """An output over increments on an input, as of `FlightBlock.response`."""
    plane = twin(flown)
    ports, channels = plane.channels()
    (i,) = find("input", [c.name for c in ports], [input])
    (o,) = find("output", [c.name for c in channels], [output])
    u = values(plane.inputs)
    trimmed = plane.trimmed_inputs()
    u[: len(trimmed)] = trimmed
    y = [values(plane.outputs)[o]]
    for k, increment in enumerate(np.asarray(increments, dtype=float).tolist(), 1):
        u[i] = trimmed[i] + increment
        y.append(plane.advance(k, u)[o])
    return np.array(y)
