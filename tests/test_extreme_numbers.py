"""The smallest and the largest floats as parameters: refused, or the numbers stay finite."""

import inspect
import warnings

import numpy as np
import pytest
from pathsim import Simulation
from public_blocks import BLOCKS

from pathsim_jsbsim_blocks import BlocksError, ParameterError
from pathsim_jsbsim_blocks.air.airspeed import crossover_altitude

EXTREMES = [5e-324, 1e-300, 1e-160, 1e160, 1e300, 1.7e308]

# trimmed or identified for each value: their conditions are refused in tests of their own
SLOW = ("Aircraft", "JSBSimFDM", "LinearAircraft")


def numeric_parameters(block):
    for parameter in inspect.signature(block).parameters.values():
        default = parameter.default
        if default is None or (isinstance(default, (int, float)) and default is not True):
            yield parameter.name, lambda x: x
        elif isinstance(default, tuple) and all(isinstance(x, float) for x in default):
            yield parameter.name, lambda x, rest=default[1:]: (x, *rest)


@pytest.mark.parametrize("kind", [name for name in BLOCKS if name not in SLOW])
def test_extreme_parameters_are_refused_or_the_outputs_are_finite(kind):
    block = BLOCKS[kind]
    for name, shaped in numeric_parameters(block):
        for x in EXTREMES:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                try:
                    made = block(**{name: shaped(x)})
                except BlocksError:
                    continue
                sim = Simulation([made], dt=0.01, log=False)
                for i in range(len(made.inputs)):
                    made.inputs[i] = 10.0
                for _ in range(3):
                    sim.timestep(adaptive=False)
            assert np.all(np.isfinite(made.outputs.to_array())), f"{name}={x}"


def test_a_crossover_altitude_that_there_is_not():
    for cas, mach in ((100.0, 5e-324), (1e300, 1e-300), (1e-300, 0.5), (100.0, 1e300)):
        for form in (float, lambda x: np.array([x])):
            with pytest.raises(ParameterError) as error:
                crossover_altitude(form(cas), form(mach))
            assert error.value.parameter == "mach"
