"""PathSim's `to_statespace` on every public block, against differences of the block's outputs."""

import numpy as np
import pytest
from public_blocks import BLOCKS

from pathsim_jsbsim_blocks import (
    BodyToNED,
    BodyToWind,
    GeodeticToNED,
    Microburst,
    NEDToBody,
    TrimCondition,
    UnitConversion,
    WindShear,
    WindToBody,
)

OPTIONS = {
    # without these it has none
    "JSBSimFDM": {
        "input_properties": ["fcs/elevator-cmd-norm"],
        "output_properties": ["attitude/theta-deg"],
        "condition": TrimCondition(altitude=5000, speed=260, gear=0),
    },
    "LinearAircraft": {"method": "algebraic"},
}


@pytest.mark.filterwarnings("ignore:FlareHold is at a limit")  # on the ground
@pytest.mark.filterwarnings("ignore:c172p. the response of vt to elevator is not linear")
@pytest.mark.parametrize("name", BLOCKS)
def test_it_has_a_linear_model(name):
    block = BLOCKS[name](**OPTIONS.get(name, {}))
    A, B, C, D = block.to_statespace(0.0)
    (p, m), n = D.shape, len(A)
    assert (m, p) == (len(block.inputs), len(block.outputs))
    assert (A.shape, B.shape, C.shape) == ((n, n), (n, m), (p, n))
    for matrix in (A, B, C, D):
        assert np.all(np.isfinite(matrix))


@pytest.mark.parametrize(
    ("block", "u"),
    [
        (BodyToNED(), [250.0, 3.0, 12.0, 4.0, 3.0, 70.0]),
        (NEDToBody(), [250.0, 3.0, 12.0, 4.0, 3.0, 70.0]),
        (BodyToWind(), [-300.0, 20.0, -2400.0, 4.0, 2.0]),
        (WindToBody(), [300.0, 20.0, 2400.0, 4.0, 2.0]),
        (GeodeticToNED(lat0=47.0, lon0=8.0), [47.01, 8.02, 1500.0]),
        (WindShear(direction=30.0), [200.0]),
        (Microburst(lat0=47.0, lon0=8.0), [47.01, 8.01, 500.0]),
        (UnitConversion("degF", "K"), [60.0]),
    ],
    ids=lambda x: type(x).__name__,
)
def test_without_a_state_it_is_the_slope_of_the_outputs(block, u):
    def outputs(values):
        block.inputs.update_from_array(values)
        block.update(0.0)
        return block.outputs.to_array().copy()

    u = np.array(u)
    outputs(u)
    _, _, _, D = block.to_statespace(0.0)
    for j in range(len(u)):
        step = np.zeros(len(u))
        step[j] = 4e-6 * max(1.0, abs(u[j]))
        slope = (outputs(u + step) - outputs(u - step)) / (2 * step[j])
        np.testing.assert_allclose(D[:, j], slope, rtol=2e-3, atol=1e-3 * np.abs(slope).max())
