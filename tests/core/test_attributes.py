"""Parameters of an aircraft that are set while it flies act at its next reset."""

import warnings

import pytest
from pathsim import Connection, Simulation

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, fly
from pathsim_jsbsim_blocks.catalogue import load_diagram

pytestmark = pytest.mark.matrix


def flying(plane):
    source = DoubletSource(amplitude=0.02, start=0.1, width=0.1)
    return Simulation([plane, source], [Connection(source, plane["elevator"])], dt=plane.T, log=0)


def test_a_new_speed_says_once_that_it_acts_at_the_next_reset():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = flying(plane)
    fly(sim, 0.1)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        plane.speed = 110
        plane.set(speed=105, altitude=4000)
        plane.heading = 30
    assert [str(w.message) for w in caught] == [
        "plane.speed = 110 acts at the next reset: sim.reset() or sim.run(..., reset=True)"
    ]
    assert caught[0].filename == __file__
    fly(sim, 0.1)
    assert plane.outputs["vc"] == pytest.approx(90, abs=0.5)
    sim.reset()
    assert plane.outputs["vc"] == pytest.approx(105, abs=0.5)
    assert plane.outputs["h"] == pytest.approx(4000, abs=0.5)


def test_nothing_is_said_where_the_flight_has_the_value_or_a_script_is_set():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plane = Aircraft("c172p", altitude=5000, speed=90)
        plane.speed = 90
        plane.record_inputs = True  # acts at once
        sim = flying(plane)
        fly(sim, 0.1)
        sim.reset()
        diagram = load_diagram("pitch_hold", {"aircraft.speed": 95.0})
        fly(diagram.sim, 0.1)
    assert diagram.aircraft.outputs["vc"] == pytest.approx(95, abs=0.5)
