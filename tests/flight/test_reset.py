"""A reset flies the same flight again, bit for bit, with every aircraft that trims."""

import random
import re
import xml.etree.ElementTree as ET

import jsbsim
import numpy as np
import pytest
from fleet_conditions import FLYING, keywords
from how_many import first
from models_from_outside import changed
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, PitchHold, TrimCondition
from pathsim_jsbsim_blocks.errors import FlightError
from pathsim_jsbsim_blocks.flight import has_retractable_gear

VARIED = ["c172p", "737", "f16", "Concorde"]

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
    simulation(*once).run(1.5)
    twice = blocks()
    simulation(*twice).run(1.0)
    again = simulation(*twice)
    assert again.time == 0.0
    again.run(0.5)
    assert twice[0].samples == once[0].samples == 180
    assert np.array_equal(twice[0].outputs.to_array(), once[0].outputs.to_array())


@pytest.mark.filterwarnings("ignore:.*landing gear is down:RuntimeWarning")
def test_a_reset_does_not_read_the_model_again(monkeypatch, tmp_path):
    root, model = changed(tmp_path, "T38"), tmp_path / "aircraft/T38/T38.xml"
    parse, read = ET.parse, []
    monkeypatch.setattr(ET, "parse", lambda file: read.append(file) or parse(file))
    plane = Aircraft("T38", altitude=5000, speed=223, root=root)
    # its engines' files too: the properties to which it refers
    assert model in read
    read.clear()
    for _ in range(3):
        plane.reset()
    assert not read
    # an edited model is another one
    text = model.read_text()
    model.write_text(re.sub(r"<retractable>\s*1\s*<", "<retractable> 0 <", text))
    assert not has_retractable_gear("T38", root=root)


def plane(aircraft):
    return JSBSimFDM(
        input_properties=["fcs/elevator-cmd-norm", "fcs/aileron-cmd-norm"],
        output_properties=OUTPUTS,
        **keywords(aircraft),
    )


def wiggled(fdm, periods=300):
    """The outputs of a flight with small inputs, up to a crash."""
    u, rows = fdm.trimmed_inputs(), [fdm.outputs.to_array().tolist()]
    for k in range(1, periods):
        try:
            wave = [0.1 * np.sin(k / 20), 0.05 * np.sin(k / 30)]
            rows.append(fdm.advance(k, [a + b for a, b in zip(u, wave, strict=True)]))
        except FlightError:
            break
    return np.array(rows)


def fail_an_engine(fdm, airframe):
    for name in airframe.of_engines("set-running")[:1]:
        fdm[name] = 0.0


def empty_the_tanks(fdm, airframe):
    for tank in airframe.tanks:
        fdm[tank] = 0.0


def meet_a_storm(fdm, airframe):
    fdm["atmosphere/gust-north-fps"], fdm["atmosphere/wind-down-fps"] = 300.0, 30.0


def meet_turbulence(fdm, airframe):
    fdm["atmosphere/turb-type"], fdm["atmosphere/turbulence/milspec/severity"] = 3, 6
    fdm["atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps"] = 60.0


def be_not_a_number(fdm, airframe):
    fdm["fcs/elevator-cmd-norm"] = np.nan


def extend_and_load(fdm, airframe):
    fdm["fcs/flap-cmd-norm"] = fdm["gear/gear-cmd-norm"] = 1.0
    if airframe.has("inertia/pointmass-weight-lbs"):
        fdm["inertia/pointmass-weight-lbs"] = 500.0


WILD = (
    fail_an_engine,
    empty_the_tanks,
    meet_a_storm,
    meet_turbulence,
    be_not_a_number,
    extend_and_load,
)


def fly_wildly(block, event, rng, periods):
    """Fly without any check, in JSBSim alone, full travel on every control."""
    fdm, airframe = block.fdm, block.airframe
    event(fdm, airframe)
    controls = [f"fcs/{name}-cmd-norm" for name in ("aileron", "rudder", "elevator")]
    controls += [f"fcs/throttle-cmd-norm[{i}]" for i in range(airframe.engines)]
    for k in range(periods):
        if k % 30 == 0 and event is not be_not_a_number:
            for name in controls:
                fdm[name] = rng.uniform(-1, 1)
        try:
            fdm.run()
        except (jsbsim.BaseError, RuntimeError):
            break


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("aircraft", first([*VARIED, *sorted({*FLYING} - {*VARIED})], len(VARIED)))
def test_a_flight_is_the_same_whatever_went_before(aircraft):
    block, rng = plane(aircraft), random.Random(aircraft)
    usual = wiggled(block)
    for event in WILD:
        fly_wildly(block, event, rng, rng.choice([60, 600]))
        block.reset()
        assert np.array_equal(wiggled(block), usual, equal_nan=True), event


@pytest.mark.parametrize("kind", first([3, 2]))  # milspec, Culp
def test_turbulence_of_the_model_is_the_same_again(kind):
    turbulence = {
        "atmosphere/turb-type": kind,
        "atmosphere/turbulence/milspec/severity": 6,
        "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 60.0,
        "atmosphere/turb-rate": 2.0,
        "atmosphere/turb-gain": 2.0,
        "atmosphere/turb-rhythmicity": 0.5,
    }
    for seed in ({}, {"simulation/randomseed": 7}):
        block = Aircraft("c172p", altitude=5000, speed=90, setup=seed, properties=turbulence)
        flights = []
        for _ in range(2):
            flights.append([block.advance(k, 7 * [0.0]) for k in range(1, 200)])
            block.reset()
        assert flights[0] == flights[1]
        assert np.ptp(np.array(flights[0])[:, 1]) > 0.1


def test_wind_place_and_turn_come_back():
    for flight in (
        {"mode": "turn", "bank": 30.0},
        {"wind_north": 20.0, "wind_east": -5.0, "heading": 30.0},
        {"latitude": 47.0, "longitude": 8.0, "flaps": 0.5},
    ):
        block = Aircraft("c172p", condition=TrimCondition(speed=90.0, **flight))
        u = [0.02, 0.1, 0.0, 0.0, 30.0, 0.0, 0.0]
        first = [block.advance(k, u) for k in range(1, 100)]
        for _ in range(2):
            block.reset()
            assert block.fdm["atmosphere/gust-north-fps"] == 0.0
            assert [block.advance(k, u) for k in range(1, 100)] == first


def test_overridden_air_is_that_of_the_model_again():
    def dived():
        return [block.advance(k, [0.15, *6 * [0.0]]) for k in range(1, 600)]

    block = Aircraft("c172p", altitude=5000, speed=90)
    first = dived()
    for name, now in (("temperature", "T-R"), ("density", "rho-slugs_ft3")):
        for _ in range(2):
            block.reset()
        # the same as at the start, so that it shows in the descent only
        block.fdm[f"atmosphere/override/{name}"] = block.fdm[f"atmosphere/{now}"]
        block.reset()
        assert dived() == first


def test_an_edited_model_is_loaded_at_a_reset(tmp_path):
    block = Aircraft("c172p", altitude=5000, speed=90, root=changed(tmp_path, "c172p"))
    block.reset()
    weight, model = block.trim.weight, tmp_path / "aircraft/c172p/c172p.xml"
    model.write_text(re.sub(r"(<emptywt[^>]*>)\s*1500", r"\1 1600", model.read_text()))
    block.reset()
    assert block.trim.weight == pytest.approx(weight + 100.0)
    block.reset()
    throttle, engine = block.trim.throttle, tmp_path / "engine/eng_io320.xml"
    engine.write_text(re.sub(r"320.0( *</disp)", r"400.0\1", engine.read_text()))
    block.reset()
    assert np.less(block.trim.throttle, throttle).all()
