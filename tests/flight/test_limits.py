"""What a flight may not go beyond: each limit from both sides."""

import pytest
from pathsim import Simulation

from pathsim_jsbsim_blocks import Aircraft, DiscretePID, FlightError, ParameterError

T = 1 / 120


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("weight", "ends"), [(37.6, False), (37.4, True)])
def test_a_load_factor_of_50_ends_the_flight(weight, ends, sign):
    # the lift of 1880 lb on almost no mass: 49.8 g and 50.1 g, a step later, where JSBSim sums up
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0)
    mass = "inertia/pointmass-weight-lbs[0]"
    plane.fdm[mass] = plane.fdm[mass] - plane.fdm["inertia/weight-lbs"] + sign * weight
    sim = Simulation([plane], dt=T, log=False)
    if ends:
        with pytest.raises(FlightError) as error:
            sim.run(2 * T)
        assert error.value.name == "accelerations/Nz"
        assert 50.0 < sign * error.value.value < 50.2
        assert error.value.time == pytest.approx(2 * T)
    else:
        sim.run(2 * T)
        assert 49.7 < sign * plane.outputs["nz"] < 50.0


def test_a_jsbsim_step_is_a_tenth_of_a_second_at_most():
    assert Aircraft("c172p", speed=90.0, T=0.1).samples == 0
    assert Aircraft("c172p", speed=90.0, T=0.4, substeps=4).samples == 0
    for T, substeps in ((0.1005, 1), (0.402, 4)):
        with pytest.raises(ParameterError) as error:
            Aircraft("c172p", speed=90.0, T=T, substeps=substeps)
        assert (error.value.parameter, error.value.value) == ("T / substeps", 0.1005)


def test_a_period_is_a_microsecond_at_least():
    assert DiscretePID(T=1e-6).T == 1e-6
    with pytest.raises(ParameterError) as error:
        DiscretePID(T=0.995e-6)
    assert (error.value.parameter, error.value.value) == ("T", 9.95e-07)
