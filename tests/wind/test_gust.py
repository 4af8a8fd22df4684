"""1-cosine gusts: the regulation's velocities, the shape, edges, bad input."""

import math

import numpy as np
import pytest
from ambiance import Atmosphere
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope
from pathsim.solvers import RKCK54

from pathsim_jsbsim_blocks import OneMinusCosineGust, ParameterError, RampSource
from pathsim_jsbsim_blocks.wind import design_gust_velocity


def record(gust, duration=5.0):
    scope = Scope()
    sim = Simulation([gust, scope], [Connection(gust, scope)], dt=0.01, log=False)
    sim.run(duration)
    time, (y,) = scope.read()
    return time, y


@pytest.mark.parametrize(
    ("altitude", "eas"), [(0.0, 56.0), (15000.0, 44.0), (37500.0, 32.43), (60000.0, 20.86)]
)
def test_the_reference_velocities_are_those_of_the_regulation(altitude, eas):
    # ambiance takes geometric heights in m
    geopotential = altitude * 0.3048
    height = 6356766.0 * geopotential / (6356766.0 - geopotential)
    true = eas * math.sqrt(1.225 / Atmosphere(height).density[0])
    assert design_gust_velocity(350.0, altitude) == pytest.approx(true, rel=1e-6)
    assert design_gust_velocity(350.0, altitude, 0.8) == pytest.approx(0.8 * true, rel=1e-6)


def test_a_gust_has_its_shape():
    time, y = record(
        OneMinusCosineGust(gradient=200.0, airspeed=400.0, amplitude=30.0, start=1.0, polarity=-1)
    )
    s = np.clip(400.0 * (time - 1.0), 0.0, 400.0)
    assert y == pytest.approx(-15.0 * (1 - np.cos(np.pi * s / 200.0)), abs=1e-9)
    assert y[abs(time - 1.5).argmin()] == -30.0
    assert y[abs(time - 1.25).argmin()] == pytest.approx(-15.0)


def test_a_long_step_does_not_jump_over_a_short_gust():
    # it takes 0.1 s
    gust = OneMinusCosineGust(gradient=30.0, airspeed=600.0, amplitude=40.0, start=1.0)
    state, scope = Integrator(0.0), Scope()
    sim = Simulation(
        [gust, state, scope],
        [Connection(gust, state), Connection(state, scope)],
        Solver=RKCK54,
        dt=0.5,
        dt_max=0.5,
        tolerance_lte_abs=1e-6,
        log=False,
    )
    sim.run(3.0)
    time, (area,) = scope.read()
    assert [abs(time - edge).min() for edge in (1.0, 1.1)] == pytest.approx([0.0, 0.0], abs=1e-12)
    # half of amplitude times duration
    assert area[-1] == pytest.approx(2.0, rel=1e-3)


def test_the_airspeed_at_the_start_comes_from_the_port():
    # it changes after the start, and the gust does not
    vt, scope = RampSource(final=900.0, start=0.0, rise_time=2.25), Scope()
    gust = OneMinusCosineGust(gradient=200.0, amplitude=30.0, start=1.0)
    sim = Simulation(
        [vt, gust, scope],
        [Connection(vt, gust["vt"]), Connection(gust, scope)],
        dt=0.01,
        log=False,
    )
    for _ in range(2):
        sim.run(3.0, reset=True)
        time, (y,) = scope.read()
        s = np.clip(400.0 * (time - 1.0), 0.0, 400.0)
        assert y == pytest.approx(15.0 * (1 - np.cos(np.pi * s / 200.0)), abs=1e-6)


@pytest.mark.parametrize("port", ["vt", 0])
def test_without_an_airspeed_a_gust_is_refused(port):
    gust, scope = OneMinusCosineGust(start=1.0), Scope()
    sim = Simulation([gust, scope], [Connection(gust, scope)], log=False)
    with pytest.raises(ParameterError) as refused:
        sim.run(2.0)
    assert refused.value.parameter == "airspeed"
    still = Constant(0.0)
    gust = OneMinusCosineGust(start=1.0)
    sim = Simulation([still, gust], [Connection(still, gust[port])], log=False)
    with pytest.raises(ParameterError) as refused:
        sim.run(2.0)
    assert (refused.value.parameter, sim.time) == ("airspeed", pytest.approx(1.0, abs=0.02))


@pytest.mark.parametrize(("metres", "feet"), [(9.0, 30.0), (50.0, 50.0 / 0.3048), (107.0, 350.0)])
def test_a_length_in_metres(metres, feet):
    gust = OneMinusCosineGust(metres, airspeed=400.0, unit="m", start=0.0)
    # the regulation rounds both units
    assert gust.peak == design_gust_velocity(feet, 0.0)
    time, y = record(gust, 2.0)
    assert time[y > 0.0][-1] == pytest.approx(2 * metres / 0.3048 / 400.0, abs=0.011)


@pytest.mark.parametrize("edited", [{"airspeed": 900.0}, {"gradient": 100.0}, {"start": 5.0}])
def test_a_gust_edited_in_its_middle_does_not_come_again(edited):
    gust, scope = OneMinusCosineGust(300.0, airspeed=300.0, amplitude=10.0, start=0.5), Scope()
    sim = Simulation([gust, scope], [Connection(gust, scope)], dt=0.01, log=False)
    sim.run(1.5)
    gust.set(**edited)
    sim.run(3.0)
    time, (y,) = scope.read()
    # it was at its peak
    assert np.all(np.diff(y[time > 1.5]) <= 0.0)
    assert y[-1] == 0.0


@pytest.mark.parametrize(
    ("keywords", "parameter"),
    [
        ({"gradient": 0.0}, "gradient"),
        ({"gradient": 20.0}, "gradient"),
        ({"gradient": 351.0}, "gradient"),
        ({"altitude": -1.0}, "altitude"),
        ({"altitude": 60001.0}, "altitude"),
        ({"amplitude": math.inf}, "amplitude"),
        ({"polarity": 0}, "polarity"),
        ({"start": -1.0}, "start"),
        ({"unit": "km"}, "unit"),
        ({"unit": "m", "gradient": 108.0}, "gradient"),
    ],
)
def test_bad_parameters_are_refused_by_name(keywords, parameter):
    with pytest.raises(ParameterError) as error:
        OneMinusCosineGust(**keywords)
    assert error.value.parameter == parameter
    # as it was written, in its own unit
    assert error.value.value is keywords[parameter]


@pytest.mark.parametrize("factor", [0.0, 1.01])
def test_a_bad_alleviation_is_refused(factor):
    with pytest.raises(ParameterError) as error:
        design_gust_velocity(100.0, 0.0, factor)
    assert error.value.parameter == "alleviation"


def test_the_amplitude_is_the_design_velocity_or_one_for_any_length():
    gust = OneMinusCosineGust(gradient=100.0, airspeed=100.0, altitude=10000.0)
    assert gust.peak == design_gust_velocity(100.0, 10000.0)
    assert OneMinusCosineGust(5000.0, amplitude=10.0, altitude=80000.0).peak == 10.0
