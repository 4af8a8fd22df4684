"""The end of a flight, interrupts, and what else runs or holds an aircraft: its own clock tells."""

import copy
import pickle

import jsbsim
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator

from pathsim_jsbsim_blocks import Aircraft, FlightError
from pathsim_jsbsim_blocks.errors import CopyError


def flying(plane, elevator=0.0):
    command = Constant(elevator)
    return Simulation([command, plane], [Connection(command, plane[0])], dt=plane.T, log=False)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_an_interrupt_between_the_steps_of_a_sample_loses_none_and_adds_none(steps):
    plane, other = (Aircraft("c172p", speed=90, T=1 / 40, substeps=3) for _ in range(2))
    u = [0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    for index in range(1, 12):
        plane.advance(index, u)
        other.advance(index, u)
    (run, *others), left = plane._bound, steps

    def interrupted():
        nonlocal left
        run()
        left -= 1
        if not left:
            raise KeyboardInterrupt

    plane._bound = (interrupted, *others)
    with pytest.raises(KeyboardInterrupt):
        plane.advance(12, u)
    plane._bound = (run, *others)
    assert plane.advance(12, u) == other.advance(12, u)


@pytest.mark.long
def test_an_aircraft_that_something_holds_ends_the_flight():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = flying(plane)
    sim.run(1.0)
    jsbsim.FGLinearization(plane.fdm)  # leaves JSBSim's time standing still
    for _ in range(2):
        with pytest.raises(FlightError) as error:
            sim.run(1.0)
        assert error.value.name == "simulation/sim-time-sec"
        assert plane.samples == 120
    sim.reset()
    sim.run(1.0)
    assert plane.samples == 120


def test_a_simulation_made_later_changes_nothing_before_it_runs():
    def run(later):
        plane, kick, angle = Aircraft(), Constant(0.02), Integrator(0.0)
        wires = [Connection(kick, plane["elevator"]), Connection(plane["q"], angle)]
        sim = Simulation([plane, kick, angle], wires, dt=plane.T, log=False)
        if later:
            flying(plane)
        sim.run(0.25)
        return angle.outputs[0]

    assert run(True) == run(False)


def test_an_aircraft_that_is_run_from_outside_ends_the_flight():
    plane = Aircraft("c172p", altitude=5000, speed=90, substeps=2)
    sim = flying(plane)
    sim.run(1.0)
    plane.fdm.run()
    for _ in range(2):
        with pytest.raises(FlightError) as error:
            sim.run(1.0)
        assert error.value.name == "simulation/sim-time-sec"


@pytest.mark.parametrize("terrain", [0.0, 4000.0])
def test_under_the_ground_the_flight_ends(terrain):
    # gear up nothing of a 737 touches the ground
    plane = Aircraft(
        "737",
        altitude=terrain + 800,
        speed=300,
        gamma=-5,
        gear=0,
        mode="none",
        properties={"ic/terrain-elevation-ft": terrain},
    )
    with pytest.raises(FlightError) as error:
        flying(plane).run(120.0)
    assert error.value.name == "position/h-agl-ft"
    # it sinks at some 100 ft/s, less than a foot in a period
    assert -2.0 < error.value.value < -1.0
    assert plane.outputs["h"] == pytest.approx(terrain - 1.0, abs=1.0)


@pytest.mark.parametrize("copies", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_flight_is_not_copied(copies):
    plane = Aircraft("c172p", altitude=5000, speed=90)
    with pytest.raises(CopyError) as error:
        copies(plane)
    assert isinstance(error.value, TypeError)
    assert (error.value.block, error.value.aircraft) == ("Aircraft", "c172p")
    again = pickle.loads(pickle.dumps(error.value))
    assert again.aircraft == "c172p"
