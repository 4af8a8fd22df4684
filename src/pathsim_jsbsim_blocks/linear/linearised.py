"""An aircraft block at its trim, with the inputs and outputs of its linear model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .._core.pathsim_internals import values
from ..errors import LinearisationError
from ..flight.channels import Channel
from ..flight.flyable import Flyable
from .model import LinearModel, find


def no_model(
    plane: Flyable, reason: str, why: str, name: str = "", servos: Mapping[str, float] | None = None
) -> LinearisationError:
    """Error of an aircraft without a linear model."""
    aircraft = plane.airframe.aircraft
    why = f"no linear model of {aircraft!r}: {why}"
    return LinearisationError(why, aircraft=aircraft, reason=reason, name=name, servos=servos)


class Linearised:
    """An aircraft block at its trim, with the inputs to move and the outputs to record."""

    def __init__(self, plane: Flyable, inputs: Sequence[str] | None, outputs: Sequence[str] | None):
        ports, channels = plane.channels()
        indices = find("inputs", [c.name for c in ports], inputs)
        for port in (ports[i] for i in indices if inputs is not None):
            if not port.properties:  # the throttle of a glider
                raise no_model(plane, "no response", f"it has no {port.name}", port.name)
        self.plane = plane
        # indices of the inputs with an effect
        self.moved = [i for i in indices if ports[i].properties]
        self.inputs = [ports[i] for i in self.moved]
        positions = find("outputs", [c.name for c in channels], outputs)
        self.outputs = [channels[i] for i in positions]
        self._u0 = np.array(plane.trimmed_inputs())[self.moved]
        self._y0 = np.array(values(plane.outputs))[positions]

    def model(self, method: str, states: Sequence[Channel], **arrays: Any) -> LinearModel:
        """The linear model with these states: matrices, x0, latency, kinks and fit."""
        plane = self.plane
        return LinearModel(
            aircraft=plane.airframe.aircraft,
            condition=str(plane.trim.condition),
            method=method,
            states=tuple(c.name for c in states),
            inputs=tuple(c.name for c in self.inputs),
            outputs=tuple(c.name for c in self.outputs),
            units={c.name: c.unit for c in (*states, *self.inputs, *self.outputs)},
            u0=self._u0,
            y0=self._y0,
            dt=plane.T,
            **arrays,
        )
