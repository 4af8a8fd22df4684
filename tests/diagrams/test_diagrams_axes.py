"""The diagram wind_to_body against JSBSim's own forces."""

import numpy as np
import pytest

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.catalogue import load_diagram

BODY = [f"forces/fb{i}-aero-lbs" for i in "xyz"]
WIND = [f"forces/fw{i}-aero-lbs" for i in "xyz"]

ROUNDING = 1e-11  # lbf; neighbouring doubles are 4.5e-13 apart at the 3000 lbf of lift


@pytest.fixture(scope="module")
def flown():
    diagram = load_diagram("wind_to_body")
    assert diagram.sim.time == 0.0
    live = []
    for _ in range(30):
        fly(diagram.sim, diagram.DURATION / 30)
        live.append(
            [diagram.fdm.fdm[name] for name in [*BODY, *WIND]]
            + [*diagram.to_body.outputs.to_array(), *diagram.to_wind.outputs.to_array()]
        )
    return diagram, np.transpose(live)


def test_forces_are_those_of_the_live_aircraft_there_and_back(flown):
    diagram, live = flown
    assert np.max(np.abs(live[:6] - live[6:])) < ROUNDING
    time, errors = diagram.errors.read()
    assert len(time) == 1801  # 15 s at 120 Hz, and the start
    assert errors.shape[0] == 6
    assert np.max(np.abs(errors)) < ROUNDING


def test_the_flight_is_the_one_described(flown):
    diagram, _ = flown
    _, (alpha, beta) = diagram.angles.read()
    _, (_, side, lift) = diagram.wind.read()
    _, (_, y, z) = diagram.body.read()
    assert (alpha.min(), alpha.max()) == pytest.approx((-2.0, 4.4), abs=0.1)
    assert (beta.min(), beta.max()) == pytest.approx((-9.0, 5.5), abs=0.1)
    assert (lift.min(), lift.max()) == pytest.approx((540.0, 3230.0), abs=5.0)
    assert np.all(z < 0.0)  # lift pulls up, the z axis points down
    assert np.ptp(y - side) > 5.0  # lbf: what a sideslip left out would cost
