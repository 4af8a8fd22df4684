"""`LinearModelBlock`: a linear model as a PathSim block."""

from __future__ import annotations

from typing import Any

from pathsim.blocks import StateSpace
from pathsim.optim.operator import DynamicOperator

from .._core.checks import must_be
from .._core.pathsim_internals import NamedRegister
from .._core.ports import NamedPorts
from .model import LinearModel


class LinearModelBlock(NamedPorts, StateSpace):
    """Linear model of an aircraft, with the ports of the aircraft block that it stands in for.

    .. math::
        \\dot{x} = A x + B \\, (u - u_0), \\qquad y = y_0 + C x + D \\, (u - u_0)

    It flies continuously, with the diagram's solver. The model's latency is a first-order lag on
    each input; the hold of the aircraft that it stands in for is not in it.

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

    input_port_labels: Any = None
    output_port_labels: Any = None

    def __init__(self, model: LinearModel) -> None:
        if not isinstance(model, LinearModel):
            must_be("model", model, "a LinearModel")
        super().__init__(*model.with_lags(model.latency * model.dt))
        self.model = model
        self.inputs = NamedRegister.of(model.inputs)
        self.outputs = NamedRegister.of(model.outputs)
        self.op_dyn = DynamicOperator(
            func=lambda x, u, t: self.A @ x + self.B @ (u - model.u0),
            jac_x=lambda x, u, t: self.A,
            jac_u=lambda x, u, t: self.B,
        )
        self.op_alg = DynamicOperator(
            func=lambda x, u, t: model.y0 + self.C @ x + self.D @ (u - model.u0),
            jac_x=lambda x, u, t: self.C,
            jac_u=lambda x, u, t: self.D,
        )
        self.outputs.update_from_array(model.y0)
