"""`DaveML`: a model in DAVE-ML as a block."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .._core.checks import number, refuse
from .._core.pathsim_internals import NamedRegister, WiredRegister, port_names, show, values
from .._core.sampling import SampledLaw
from ..errors import DaveMLError, FlightError
from .model import DaveModel, Variable


@dataclass(eq=False, repr=False)
class DaveML(SampledLaw):
    """Model in DAVE-ML (ANSI/AIAA S-119), with its inputs and outputs as ports.

    Its variables are limited to the ``minValue`` and ``maxValue`` of the file. An unconnected input
    has its initial value from the file; if it has none, it reads 0, with a warning.

    Parameters
    ----------
    file : str
        path of the file; the name is enough for a model that comes with the package:
        "f16_control.dml", "f16_circle.dml", "f16_aero.dml", "f16_propulsion.dml",
        "f16_inertia.dml"
    T : float
        sample period in s; 0 for outputs that follow the inputs at all times

    Inputs
    ------
    as the file
        names and units are those of its inputs; ``pathsim-jsbsim daveml FILE`` lists them

    Outputs
    -------
    as the file
        names and units are those of its outputs

    Raises
    ------
    FileError, DaveMLError
        if the file cannot be read or is malformed, with line and variable
    ParameterError
        for a negative T
    FlightError
        in a run, if an input is not finite or a variable has no value
    """

    file: str = "f16_control.dml"
    T: float = 0.0

    def _begin(self) -> None:
        # without T there are no sample events, but the clock needs a positive period
        T = self.T
        self.T = number("T", T, low=0.0) or 1.0
        super()._begin()
        self.T = T
        if not T:
            self.events = []
        self.model, self._file = DaveModel(self.file), self.file
        self.inputs = WiredRegister.of(_ports(self.model.inputs))
        self.outputs = NamedRegister.of(_ports(self.model.outputs))

    def build(self) -> None:
        if (number("T", self.T, low=0.0) > 0) != bool(self.events):
            refuse("T", self.T, "T cannot change between 0 and positive: build another block")
        model = self.model if self.file == self._file else DaveModel(self.file)
        sides = (model.inputs, self.inputs), (model.outputs, self.outputs)
        if any(_ports(side) != [*port_names(register)] for side, register in sides):
            reason = f"the inputs or outputs of {model.path} differ from the block's ports"
            refuse("file", self.file, reason)
        self.model, self._file = model, self.file
        # PathView shows eight characters: varIDs are shorter than names
        self.drawn_ports = {
            side: [v.id for v in variables]
            for side, variables in (("input", model.inputs), ("output", model.outputs))
        }
        initial = [v.initial for v in model.inputs]
        names = [*port_names(self.inputs)]
        self._initial = [(i, names[i], x) for i, x in enumerate(initial) if x is not None]
        missing = (name for name, x in zip(names, initial, strict=True) if x is None)
        self.measured = tuple(missing)  # type: ignore[misc]

    def sample(self, t: float, dt: float) -> None:
        super().sample(t, dt)
        # without T there are no events, which otherwise detect the start of a run
        self._run_begins()

    def update(self, t: float) -> None:
        self._time = t
        if self.events:
            super().update(t)
        else:
            show(self.outputs, self._evaluated(values(self.inputs)))

    def initial_state(self) -> tuple[()]:
        return ()

    def law(self, u: list[float], state: tuple[()]) -> tuple[list[float], tuple[()]]:
        return self._evaluated(u), state

    def _evaluated(self, u: list[float]) -> list[float]:
        for i, name, initial in self._initial:
            if name not in self.inputs.wired:
                u[i] = initial
        name, value, reason = "", math.nan, ""
        if math.isfinite(sum(u)):
            try:
                return self.model(u)
            except DaveMLError as error:
                name, reason = error.variable, str(error)
        else:
            i = next(i for i, x in enumerate(u) if not math.isfinite(x))
            name, value = [*port_names(self.inputs)][i], u[i]
            reason = f"input {name!r} is {value}"
        raise FlightError(
            f"DaveML at t = {self._time:.9g} s: {reason}",
            aircraft="",
            time=self._time,
            name=name,
            value=value,
        )


def _ports(variables: list[Variable]) -> list[str]:
    """Names of the ports: those of the variables, or their varIDs if names repeat."""
    names = [v.name for v in variables]
    return names if len({*names}) == len(names) else [v.id for v in variables]
