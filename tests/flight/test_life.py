"""The end of a flight, interrupts, and what else runs or holds an aircraft: its own clock tells."""

import copy
import math
import pickle
import re

import jsbsim
import pytest
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Function, Integrator, Source
from pathsim.exceptions import LinearizationError
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, FlightError, PitchHold, fly
from pathsim_jsbsim_blocks.errors import CopyError


def flying(plane):
    return diagram(plane, sources={"elevator": Constant(0.0)})[0]


@pytest.mark.parametrize(
    "disturb",
    [
        lambda fdm: fdm.run(),
        # leaves JSBSim's time standing still
        pytest.param(jsbsim.FGLinearization, marks=pytest.mark.long),
    ],
    ids=["run from outside", "held"],
)
def test_an_aircraft_whose_time_is_not_its_own_ends_the_flight(disturb):
    plane = Aircraft("c172p", altitude=5000, speed=90, substeps=2)
    sim = flying(plane)
    sim.run(1.0)
    disturb(plane.fdm)
    for _ in range(2):
        with pytest.raises(FlightError) as error:
            sim.run(1.0)
        assert error.value.name == "simulation/sim-time-sec"
        assert plane.samples == 120
    sim.reset()
    sim.run(1.0)
    assert plane.samples == 120


# a c172p that reaches the ground within 1 s at some 20 ft/s, without flying as far as a trim
CRASHING = {"altitude": 20.0, "speed": 70.0, "gamma": -9.0, "mode": "none"}


def stepped(sim, duration):
    for _ in range(math.ceil(duration / sim.dt)):
        sim.timestep(sim.dt, adaptive=False)


def nested(sim):
    return Simulation([Subsystem([Interface(), *sim.blocks], sim.connections)], dt=1 / 120, log=0)


@pytest.mark.parametrize("inside", [False, True], ids=["flat", "in a subsystem"])
@pytest.mark.parametrize("fly_on", [Simulation.run, fly, stepped], ids=["run", "fly", "timestep"])
def test_an_ended_flight_stays_ended_until_a_reset(fly_on, inside, monkeypatch):
    plane = Aircraft("c172p", **CRASHING)
    sim = flying(plane)
    sim = nested(sim) if inside else sim
    with pytest.raises(FlightError) as crash:
        fly_on(sim, 5.0)
    ended, shown = sim.time, plane.outputs.to_array().tolist()
    for more in (fly_on, Simulation.run, fly, stepped, fly_on):
        with pytest.raises(FlightError) as again:
            more(sim, 5.0)
        assert str(again.value) == f"{crash.value}. This flight has ended: reset to fly again"
        data = [
            (e.value.aircraft, e.value.time, e.value.name, e.value.value) for e in (crash, again)
        ]
        assert data[0] == data[1]
        assert sim.time == pytest.approx(ended, abs=1e-9)
    assert plane.outputs.to_array().tolist() == shown
    with pytest.warns(RuntimeWarning, match="acts at the next reset"):
        plane.altitude = 3000.0
    with monkeypatch.context() as patched:
        patched.setattr(plane, "_connect", lambda: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            sim.reset()
    with pytest.raises(FlightError, match=re.escape(str(crash.value))):
        sim.run(0.1)
    sim.reset()
    fly_on(sim, 1.0)
    assert plane.samples == 120


@pytest.mark.parametrize("substeps", [1, 4])
def test_ctrl_c_at_the_end_does_not_lose_it(substeps):
    """After each call of the period of the crash, where Python may deliver the signal."""

    def end(place):
        plane, calls = Aircraft("c172p", **CRASHING, substeps=substeps), 0

        def interrupted(usual):
            def call(*arguments):
                nonlocal calls
                result = usual(*arguments)
                calls += plane.fdm["gear/wow"] != 0.0
                if calls == place > 0:
                    calls += 1000
                    raise KeyboardInterrupt
                return result

            return call

        plane._bound = tuple(interrupted(x) if callable(x) else x for x in plane._bound)
        sim, errors = flying(plane), []
        for _ in range(2 if place else 1):
            with pytest.raises((FlightError, KeyboardInterrupt)) as error:
                sim.run(5.0)
            errors.append(error.value)
        crash = errors[-1]
        if place and calls > 1000:
            assert isinstance(errors[0], KeyboardInterrupt)
        return calls > 1000, (crash.time, crash.name, crash.value)

    _, expected = end(0)
    struck, place = True, 0
    while struck:
        place += 1
        struck, crash = end(place)
        assert crash == expected
    assert place > 5


def test_one_that_has_ended_ends_the_run_of_others():
    low, high = Aircraft("c172p", **CRASHING), Aircraft("c172p", altitude=5000, speed=90)
    sim = Simulation([high, low], dt=1 / 120, log=False)
    for _ in range(2):
        with pytest.raises(FlightError):
            sim.run(5.0)
    with pytest.raises(FlightError):
        Simulation([low], dt=1 / 120, log=False).run(1.0)
    Simulation([high], dt=1 / 120, log=False).run(1.0)


@pytest.mark.parametrize("depth", [0, 1, 2])
@pytest.mark.parametrize("kind", [Aircraft, PitchHold])
@pytest.mark.filterwarnings("ignore:.*(measures 0|no effect)")
def test_a_refused_linearisation_leaves_all_blocks_as_they_were(kind, depth):
    square, command, refusing = Function(lambda x: x * x), Source(lambda t: 3.0 * t), kind()
    blocks, wires = [square, refusing], []
    for _ in range(depth):
        blocks, wires = [Subsystem([Interface(), *blocks], wires)], []
    wire = [Connection(command, square)] if depth == 0 else []
    sim = Simulation([command, *blocks], wire, dt=1 / 120, log=False)
    sim.run(0.25)
    with pytest.raises(LinearizationError):
        sim.linearize()
    square.inputs[0] = 7.0
    square.update(0.0)
    assert square.outputs[0] == 49.0
    with pytest.raises(LinearizationError, match="to_statespace gives the linear model"):
        refusing.linearize(0.0)


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
    with pytest.raises(CopyError, match=r"studies\.branch") as error:
        copies(plane)
    assert isinstance(error.value, TypeError)
    assert (error.value.block, error.value.aircraft) == ("Aircraft", "c172p")
    again = pickle.loads(pickle.dumps(error.value))
    assert again.aircraft == "c172p"
