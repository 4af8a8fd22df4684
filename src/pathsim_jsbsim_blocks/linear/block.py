"""`LinearModelBlock`: a linear model as a PathSim block."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from pathsim.optim.operator import DynamicOperator

from .._core.checks import must_be, refuse
from .._core.parameters import Parametric
from .._core.pathsim_internals import NamedRegister
from .._core.pathsim_types import StateSpace
from .model import LinearModel


@dataclass(eq=False, repr=False)
class LinearModelBlock(Parametric, StateSpace):
    """Linear model of an aircraft, with the ports of the aircraft block that it replaces.

    .. math::
        \\dot{x} = A x + B \\, (u - u_0), \\qquad y = y_0 + C x + D \\, (u - u_0)

    The diagram's solver integrates it. The model's latency is a first-order lag on each input;
    the sample hold of the aircraft is not modelled.

    Parameters
    ----------
    model : LinearModel
        the model to fly

    Inputs
    ------
    as ``model.inputs``
        full values: for a model of `Aircraft` increments on the trimmed commands, 0 at the trim

    Outputs
    -------
    as ``model.outputs``
        full values, the trim plus the model's increments

    Raises
    ------
    ParameterError
        if ``model`` is not a LinearModel
    """

    model: LinearModel

    def _begin(self) -> None:
        model = self.model
        if not isinstance(model, LinearModel):
            must_be("model", model, "a LinearModel")
        StateSpace.__init__(self, *model.with_lags(model.latency * model.dt))
        self.inputs = NamedRegister.of(model.inputs)
        self.outputs = NamedRegister.of(model.outputs)
        self.op_dyn = DynamicOperator(self._slope, self._a, self._b)
        self.op_alg = DynamicOperator(self._output, self._c, self._d)
        self.outputs.update_from_array(model.y0)

    def _change(self, values: dict[str, Any]) -> None:
        for name, value in values.items():
            if np.any(value != getattr(self, name)):
                why = f"{name} cannot change after the block is built: build another"
                refuse(name, value, why)

    @property
    def model_name(self) -> str:
        return self.model.aircraft

    # methods, because local functions cannot be pickled or copied with the block
    def _slope(self, x: Any, u: Any, t: float) -> Any:
        return self.A @ x + self.B @ (u - self.model.u0)

    def _output(self, x: Any, u: Any, t: float) -> Any:
        return self.model.y0 + self.C @ x + self.D @ (u - self.model.u0)

    def _a(self, x: Any, u: Any, t: float) -> Any:
        return self.A

    def _b(self, x: Any, u: Any, t: float) -> Any:
        return self.B

    def _c(self, x: Any, u: Any, t: float) -> Any:
        return self.C

    def _d(self, x: Any, u: Any, t: float) -> Any:
        return self.D
