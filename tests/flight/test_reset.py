"""A reset flies the same flight again, bit for bit, with every aircraft that trims."""

import os
import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import jsbsim
import numpy as np
import pytest
from fleet_conditions import FEW, FLYING, keywords
from how_many import first
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope
from plain_jsbsim import FLIGHTS

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, PitchHold
from pathsim_jsbsim_blocks.flight import has_retractable_gear

OUTPUTS = [
    "aero/alpha-deg",
    "attitude/theta-deg",
    "attitude/phi-deg",
    "velocities/vt-fps",
    "position/h-sl-ft",
    "position/long-gc-deg",
    "propulsion/engine/thrust-lbs",
    "inertia/weight-lbs",
    "simulation/sim-time-sec",
]


def wire(fdm, outputs):
    # the c172x's elevator actuator has a hysteresis that swallows 0.02
    doublet, scope = DoubletSource(amplitude=0.1, start=1.0, width=0.5), Scope()
    sim = Simulation(
        [doublet, fdm, scope],
        [
            Connection(doublet, fdm[0], scope[0]),
            *(Connection(fdm[i], scope[1 + i]) for i in range(len(outputs))),
        ],
        dt=fdm.T,
        log=False,
    )
    return scope, sim


def flown(scope):
    time, data = scope.read()
    return np.vstack([time, data])


@pytest.mark.parametrize("aircraft", first([*FEW, *sorted(set(FLYING) - set(FEW))], len(FEW)))
def test_the_same_ten_seconds_twice(aircraft):
    fdm = JSBSimFDM(
        input_properties=["fcs/elevator-cmd-norm"], output_properties=OUTPUTS, **keywords(aircraft)
    )
    scope, sim = wire(fdm, OUTPUTS)
    sim.run(10.0)
    first = flown(scope)
    trim, executive = fdm.trim, fdm.fdm
    sim.run(10.0, reset=True)
    assert fdm.fdm is not executive
    assert fdm.trim == trim
    assert first.shape[1] == 1201
    assert np.array_equal(flown(scope), first)
    # the aircraft did move, so that repeating the flight is a real test
    assert np.ptp(first[2]) > 0.01


def test_fuel_burnt_is_back_after_a_reset():
    # the Concorde's feed tanks run dry within 20 s, which changes its weight and thrust for good
    flight = keywords("Concorde") | {"setup": {}}
    fdm = JSBSimFDM(input_properties=["fcs/elevator-cmd-norm"], output_properties=OUTPUTS, **flight)
    scope, sim = wire(fdm, OUTPUTS)
    with pytest.warns(RuntimeWarning, match="stopped for want of fuel"):
        sim.run(30.0)
    first = flown(scope)
    assert first[8, 0] - first[8, -1] > 100.0
    with pytest.warns(RuntimeWarning, match="stopped for want of fuel"):
        sim.run(30.0, reset=True)
    assert np.array_equal(flown(scope), first)


@pytest.mark.parametrize("aircraft", FLIGHTS)
def test_the_aircraft_block(aircraft):
    altitude, speed = FLIGHTS[aircraft]
    plane = Aircraft(aircraft, altitude=altitude, speed=speed, gear=1)
    scope, sim = wire(plane, Aircraft.output_port_labels)
    sim.run(5.0)
    first = flown(scope)
    sim.run(5.0, reset=True)
    assert np.array_equal(flown(scope), first)


def test_what_was_written_by_hand_is_forgotten():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    scope, sim = wire(plane, Aircraft.output_port_labels)
    sim.run(2.0)
    first = flown(scope)
    plane.fdm["fcs/flap-cmd-norm"] = 1.0
    plane.fdm["atmosphere/wind-north-fps"] = 30.0
    sim.run(2.0)
    sim.run(2.0, reset=True)
    assert np.array_equal(flown(scope), first)


def test_edited_parameters_count_from_the_reset_on():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    scope, sim = wire(plane, Aircraft.output_port_labels)
    sim.run(2.0)
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.altitude, plane.speed = 6000.0, 95.0
    sim.run(2.0, reset=True)
    other = Aircraft("c172p", altitude=6000, speed=95)
    other_scope, other_sim = wire(other, Aircraft.output_port_labels)
    other_sim.run(2.0)
    assert np.array_equal(flown(scope), flown(other_scope))


@pytest.mark.parametrize("states", [0, 1])
def test_another_simulation_of_the_same_blocks_flies_on(states):
    # as PathSim's own blocks do, when a notebook cell rebuilds the simulation
    def blocks():
        plane, hold = Aircraft("c172p", altitude=5000, speed=90), PitchHold(theta_ref=3.0)
        return plane, hold, *(Integrator(0.0) for _ in range(states))

    def simulation(plane, hold, *integrators):
        return Simulation(
            [plane, hold, *integrators],
            [
                Connection(plane["theta"], hold["theta"], *integrators),
                Connection(plane["q"], hold["q"]),
                Connection(hold["elevator"], plane["elevator"]),
            ],
            dt=1 / 120,
            log=False,
        )

    once = blocks()
    simulation(*once).run(7.0)
    twice = blocks()
    simulation(*twice).run(5.0)
    again = simulation(*twice)
    assert again.time == 0.0
    again.run(2.0)
    assert twice[0].samples == once[0].samples == 840
    assert np.array_equal(twice[0].outputs.to_array(), once[0].outputs.to_array())


@pytest.mark.filterwarnings("ignore:.*landing gear is down:RuntimeWarning")
def test_a_reset_does_not_read_the_model_for_the_gear_again(monkeypatch, tmp_path):
    root = tmp_path / "root"
    shutil.copytree(Path(jsbsim.get_default_root_dir(), "aircraft", "T38"), root / "aircraft/T38")
    for folder in ("engine", "systems"):
        os.symlink(Path(jsbsim.get_default_root_dir(), folder), root / folder)
    model, parse, read = root / "aircraft/T38/T38.xml", ET.parse, []
    monkeypatch.setattr(ET, "parse", lambda file: read.append(file) or parse(file))
    plane = Aircraft("T38", altitude=5000, speed=223, root=str(root))
    for _ in range(3):
        plane.reset()
    assert read == [model]
    # an edited model is another one
    text = model.read_text()
    model.write_text(re.sub(r"<retractable>\s*1\s*<", "<retractable> 0 <", text))
    assert not has_retractable_gear("T38", root=str(root))
