"""Linear model and response of an aircraft block about its trim, flown by another aircraft."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from .._core.checks import one_of
from .._core.pathsim_internals import values
from ..flight.flyable import Flyable
from ..flight.from_trim import twin
from .algebraic import algebraic_model
from .flown import flown_model
from .linearised import no_model
from .model import LinearModel, find


def model_about_trim(
    flown: Flyable,
    method: str,
    inputs: Sequence[str] | None,
    outputs: Sequence[str] | None,
    amplitude: Mapping[str, float] | None,
) -> LinearModel:
    """Linear model about the trim of a block; see `FlightBlock.linear_model`."""
    one_of("method", method, ["flown", "algebraic"])
    mode = flown.trim.condition.mode
    if mode in ("none", "ground", "pull-up"):
        raise no_model(flown, "no trim", f"it is not in steady flight (mode={mode!r})")
    make = flown_model if method == "flown" else algebraic_model
    return make(lambda: twin(flown), inputs, outputs, amplitude)


def response(flown: Flyable, input: str, increments: Sequence[float], output: str) -> np.ndarray:
    """Response of an output to increments on an input; see `FlightBlock.response`."""
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
