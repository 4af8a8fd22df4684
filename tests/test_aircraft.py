"""The ready ports of `Aircraft`: commands within their range, and by how much they fell short."""

import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from plain_jsbsim import FLIGHTS

from pathsim_jsbsim_blocks import Aircraft

pytestmark = pytest.mark.matrix

T = 1 / 120


@pytest.mark.parametrize(("aircraft", "port", "increment", "command", "excess"), [
    ("c172p", "elevator", 1.0, 0.86993, 0.13007),
    ("c172p", "elevator", -2.0, -1.0, -1.0),
    ("c172p", "elevator", 0.5, 0.5, 0.0),
    ("737", "elevator", -2.0, -0.84041, -1.15959),
    ("737", "elevator", 2.0, 1.0, 1.0),
    ("737", "aileron", 1.25, 1.0, 0.25), ("737", "aileron", -3.0, -1.0, -2.0),
    ("737", "rudder", 1.25, 1.0, 0.25), ("737", "rudder", -3.0, -1.0, -2.0),
])
def test_the_aircraft_limits_its_commands_and_says_by_how_much(aircraft, port, increment, command,
                                                               excess):
    altitude, speed = FLIGHTS[aircraft]
    gear = 0 if aircraft == "737" else None
    plane = Aircraft(aircraft, altitude=altitude, speed=speed, gear=gear)
    constant = Constant(increment)
    Simulation([constant, plane], [Connection(constant, plane[port])], dt=T, log=False).run(2 * T)
    # six figures of a trim whose tolerance is 1e-4 rad/s2
    assert plane.fdm[f"fcs/{port}-cmd-norm"] == pytest.approx(command, abs=1e-5)
    saturations = {"elevator": "elev_sat", "aileron": "ail_sat", "rudder": "rud_sat"}
    for other, saturation in saturations.items():
        expected = excess if other == port else 0.0
        assert plane.outputs[saturation] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("increment", "command"), [(1.0, 1.0), (-1.0, 0.0)])
def test_the_aircraft_limits_its_throttles(increment, command):
    plane = Aircraft("737", altitude=10000, speed=280, gear=0)
    constant = Constant(increment)
    Simulation([constant, plane], [Connection(constant, plane["throttle"])],
               dt=T, log=False).run(2 * T)
    assert [plane.fdm[f"fcs/throttle-cmd-norm[{i}]"] for i in (0, 1)] == [command, command]
    assert plane.outputs["thr_sat"] == pytest.approx(
        plane.trim.throttle[0] + increment - command, abs=1e-12)
