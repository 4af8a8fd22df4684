"""The block `DaveML`: its ports, its time, its open inputs, and PathView."""

import math

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope, Source
from pathsim.solvers import RKCK54
from test_daveml import WING, written

from pathsim_jsbsim_blocks import BlocksError, DaveML, FlightError, ParameterError


def lift(alpha, elevator=0.0):
    """The wing's lift, written again."""
    return min(
        float(np.interp(alpha, [-10, 0, 10, 15], [-0.7, 0.3, 1.3, 1.0])) + 0.01 * elevator, 1.4
    )


def flown(wing, angle, duration=2.0, dt=0.05, **options):
    source, scope = Source(angle), Scope()
    wires = [
        Connection(source, wing["angleOfAttack"]),
        Connection(wing["lift"], scope[0]),
        Connection(source, scope[1]),
    ]
    sim = Simulation([wing, source, scope], wires, dt=dt, log=False, **options)
    sim.run(duration)
    return sim, scope.read()


def test_the_ports_are_the_models_and_open_inputs_have_its_initial_values(tmp_path):
    text = WING.replace('initialValue="0" minValue', 'initialValue="10" minValue')
    wing = DaveML(str(written(tmp_path, text)))
    _, (time, (y, alpha)) = flown(wing, lambda t: 12 * math.sin(3 * t))
    assert len(time) > 40
    assert y == pytest.approx([lift(a, 10.0) for a in alpha], abs=1e-15)
    with pytest.raises(ParameterError) as error:
        wing["angle"]
    assert (error.value.parameter, error.value.value) == ("port", "angle")
    assert "'angleOfAttack'" in str(error.value)


def test_with_a_period_the_outputs_are_held_between_the_samples(tmp_path):
    wing = DaveML(str(written(tmp_path, WING)), T=0.2)
    sim, (time, (y, _)) = flown(wing, lambda t: 12 * math.sin(3 * t), dt=0.05)
    held = [lift(12 * math.sin(3 * 0.2 * math.floor(t / 0.2 + 1e-6))) for t in time]
    assert y == pytest.approx(held, abs=1e-12)
    sim.run(2.0, reset=True)
    again = next(x for x in sim.blocks if isinstance(x, Scope)).read()[1][0]
    assert np.array_equal(again, y)


def test_without_a_period_it_follows_within_the_steps_of_a_solver(tmp_path):
    wing, integral, scope = DaveML(str(written(tmp_path, WING))), Integrator(0.0), Scope()
    source = Source(lambda t: 4 * t)
    sim = Simulation(
        [wing, integral, scope, source],
        [
            Connection(source, wing["angleOfAttack"]),
            Connection(wing["lift"], integral),
            Connection(integral, scope),
        ],
        Solver=RKCK54,
        log=False,
    )
    sim.run(2.0)
    # the integral of 0.3 + 0.4 t, which a lift held over steps would miss
    assert scope.read()[1][0][-1] == pytest.approx(0.6 + 0.8, abs=1e-9)
    # no slope by the elevator, which has no wire
    assert wing.to_statespace(2.0)[3][0] == pytest.approx([0.1, 0.0])


def test_what_has_no_value_ends_the_flight(tmp_path):
    file = written(tmp_path, WING.replace("<times/>", "<divide/>"))
    with pytest.raises(FlightError) as error:
        flown(DaveML(str(file)), lambda t: 1.0)
    assert error.value.name == "CL"
    for T in (0.0, 0.05):
        wing = DaveML(str(written(tmp_path, WING)), T=T)
        with pytest.raises(FlightError) as error:
            flown(wing, lambda t: math.nan if t > 0.99 else 1.0)
        assert error.value.name == "angleOfAttack"
        assert error.value.time == pytest.approx(1.0, abs=0.06)


def test_missing_wires_are_told_once(tmp_path):
    for T in (0.0, 0.1):
        wing = DaveML(str(written(tmp_path, WING)), T=T)
        sim = Simulation([wing], [], dt=0.1, log=False)
        with pytest.warns(RuntimeWarning, match="measures 0 at unconnected inputs: angleOfAttack$"):
            sim.run(0.5)
        sim.run(0.5)


def test_bad_parameters_are_refused(tmp_path):
    file, other = (
        written(tmp_path, WING),
        written(tmp_path, WING.replace('"lift"', '"L"').replace(">lift<", ">L<"), "b.dml"),
    )
    with pytest.raises(ParameterError) as error:
        DaveML(str(file), T=-1.0)
    assert (error.value.parameter, error.value.value) == ("T", -1.0)
    with pytest.raises(BlocksError) as error:
        DaveML("nothing.dml")
    assert error.value.path == "nothing.dml"
    wing = DaveML(str(file))
    for parameter, value in (("file", str(other)), ("T", 0.1)):
        with pytest.raises(ParameterError) as error:
            setattr(wing, parameter, value)
        assert (error.value.parameter, error.value.value) == (parameter, value)
    assert (wing.file, wing.T) == (str(file), 0.0)
