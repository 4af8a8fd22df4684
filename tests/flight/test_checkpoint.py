"""Stop and go on: a checkpoint continues bit for bit, by flying the recorded inputs again."""

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from corruptions import flight, loaded_from_corruptions
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope, Source
from pathsim.events import Schedule
from pathsim.solvers import RK4

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, ParameterError, PitchHold, fly
from pathsim_jsbsim_blocks.errors import FileError

pytestmark = pytest.mark.matrix


def diagram(states=0, aircraft="c172p", dt=1 / 120, **options):
    plane = Aircraft(aircraft, altitude=5000, speed=90, **{"record_inputs": True, **options})
    hold = PitchHold(gains="c172p", theta_ref=3.0)
    doublet = DoubletSource(amplitude=0.1, start=1.0)
    wobble = Source(lambda t: 0.02 * math.sin(2 * t))
    scope = Scope()
    integrators = [Integrator(0.0) for _ in range(states)]
    sim = Simulation(
        [hold, plane, doublet, wobble, scope, *integrators],
        [
            Connection(plane["theta"], hold["theta"], scope[0], *integrators),
            Connection(plane["q"], hold["q"]),
            Connection(hold["elevator"], plane["elevator"], scope[1]),
            Connection(doublet, plane["rudder"]),
            Connection(wobble, plane["aileron"]),
            Connection(plane["phi"], scope[2]),
        ],
        dt=dt,
        Solver=RK4,
        log=False,
    )
    return sim, plane, scope


@pytest.mark.parametrize("states", [0, 1])
@pytest.mark.parametrize("parts", [1, 2], ids=["dt = T", "dt = T/2, stopped between samples"])
def test_a_loaded_checkpoint_goes_on_bit_for_bit(states, parts, tmp_path):
    dt = 1 / 120 / parts
    whole, plane, scope = diagram(states, dt=dt)
    # an odd number of steps: with dt = T/2 it ends between two samples
    whole.run(301 * dt)
    whole.save_checkpoint(str(tmp_path / "stop"))
    whole.run(3.0)

    again, other, other_scope = diagram(states, dt=dt)
    again.load_checkpoint(str(tmp_path / "stop"))
    assert again.time == pytest.approx(301 * dt, abs=1e-12)
    again.run(3.0)
    assert np.array_equal(other_scope.read()[1], scope.read()[1])
    assert other.samples == plane.samples

    # and a reset still starts from the beginning
    again.run(301 * dt, reset=True)
    first = other_scope.read()[1]
    assert np.array_equal(first, scope.read()[1][:, : first.shape[1]])


@pytest.mark.parametrize("run", [Simulation.run, fly])
def test_no_checkpoint_is_loaded_inside_a_step(run, tmp_path):
    """The aircraft would be at the checkpoint's time, and the run at its own."""
    sim, plane, _ = diagram()
    stop = tmp_path / "stop"
    load = Schedule(t_start=0.2, t_period=10, func_act=lambda t: sim.load_checkpoint(stop))
    sim.add_event(load)
    sim.run(0.1)
    sim.save_checkpoint(stop)
    with pytest.raises(ParameterError, match="cannot be loaded inside a step"):
        run(sim, 0.4)
    sim.load_checkpoint(stop)
    load.off()
    run(sim, 0.4)
    assert plane.fdm.get_sim_time() == pytest.approx(sim.time)
    assert sim.time == pytest.approx(0.5)


def test_a_checkpoint_of_a_checkpoint(tmp_path):
    whole, _, scope = diagram()
    whole.run(1.0)
    whole.save_checkpoint(str(tmp_path / "a"))
    whole.run(2.0)
    middle, _, _ = diagram()
    middle.load_checkpoint(str(tmp_path / "a"))
    middle.run(1.0)
    middle.save_checkpoint(str(tmp_path / "b"))
    last, _, last_scope = diagram()
    last.load_checkpoint(str(tmp_path / "b"))
    last.run(1.0)
    assert np.array_equal(last_scope.read()[1], scope.read()[1])


def test_without_recorded_inputs_it_refuses(tmp_path):
    sim, _, scope = diagram(record_inputs=False)
    sim.run(1.0)
    with pytest.raises(ParameterError, match="record_inputs=True"):
        sim.save_checkpoint(str(tmp_path / "stop"))
    assert list(tmp_path.iterdir()) == []
    assert len(scope.read()[0]) == 121


def test_recording_is_off_by_default_so_memory_stays_bounded():
    sim, plane, _ = diagram(record_inputs=False)
    sim.run(1.0)
    assert len(plane._flown) == 0


@pytest.mark.parametrize("duration", [0, 1], ids=["not flown yet", "flown"])
@pytest.mark.parametrize(
    "change",
    [
        {"aircraft": "c172x"},
        {"T": 1 / 60},
        {"substeps": 2},
        {"properties": {"fcs/flap-cmd-norm": 1}},
        {"setup": {"propulsion/tank/contents-lbs": 10}},
        {"create": {"a/b": 1.0}},
        {"heading": 1},
    ],
    ids=lambda change: next(iter(change)),
)
def test_a_checkpoint_of_another_flight_is_refused(change, duration, tmp_path):
    sim, _, _ = diagram()
    if duration:
        sim.run(duration)
    sim.save_checkpoint(str(tmp_path / "stop"))
    other, plane, _ = diagram(**change)
    with pytest.raises(ParameterError, match="another flight"):
        other.load_checkpoint(str(tmp_path / "stop"))
    # and what was refused has changed nothing
    assert plane.clock.period == plane.T
    assert plane.samples == 0


def test_the_refusal_names_what_differs_between_the_flights(tmp_path):
    sim, _, _ = diagram()
    sim.save_checkpoint(str(tmp_path / "stop"))
    other, _, _ = diagram(substeps=2)
    with pytest.raises(ParameterError, match=r"it has substeps=1; this block has substeps=2$"):
        other.load_checkpoint(str(tmp_path / "stop"))


def test_a_checkpoint_of_other_ports_is_refused(tmp_path):
    def build(input_, output):
        fdm = JSBSimFDM(
            input_properties=[f"fcs/{input_}-cmd-norm"],
            output_properties=[output],
            aircraft_model="c172p",
            trim_airspeed=90,
            trim_altitude=5000,
            record_inputs=True,
        )
        return Simulation([fdm], dt=fdm.T, log=False)

    sim = build("elevator", "attitude/theta-deg")
    sim.run(0.5)
    sim.save_checkpoint(str(tmp_path / "stop"))
    for ports in (("aileron", "attitude/theta-deg"), ("elevator", "aero/alpha-deg")):
        with pytest.raises(ParameterError, match="another flight"):
            build(*ports).load_checkpoint(str(tmp_path / "stop"))


def test_parameters_edited_in_flight_do_not_count_before_the_reset(tmp_path):
    sim, plane, scope = diagram()
    sim.run(1.0)
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.set(heading=90.0, T=1 / 60)
    sim.save_checkpoint(str(tmp_path / "stop"))
    again, _, other_scope = diagram()
    again.load_checkpoint(str(tmp_path / "stop"))
    sim.run(1.0)
    again.run(1.0)
    assert np.array_equal(other_scope.read()[1], scope.read()[1])


def test_inputs_recorded_in_part_are_refused(tmp_path):
    sim, plane, _ = diagram(record_inputs=False)
    sim.run(0.5)
    plane.record_inputs = True
    sim.run(0.5)
    with pytest.raises(ParameterError, match="record_inputs=True"):
        sim.save_checkpoint(str(tmp_path / "stop"))
    sim.run(0.5, reset=True)
    plane.record_inputs = False
    sim.run(0.5)
    with pytest.raises(ParameterError, match="record_inputs=True"):
        sim.save_checkpoint(str(tmp_path / "stop"))


def test_a_checkpoint_of_an_aircraft_that_has_not_flown(tmp_path):
    sim, _, scope = diagram(record_inputs=False)
    sim.save_checkpoint(str(tmp_path / "stop"))
    sim.run(1.0)
    again, _, other_scope = diagram(record_inputs=False)
    again.load_checkpoint(str(tmp_path / "stop"))
    again.run(1.0)
    assert np.array_equal(other_scope.read()[1], scope.read()[1])


def test_any_property_block_too(tmp_path):
    def build():
        fdm = JSBSimFDM(
            input_properties=["fcs/elevator-cmd-norm"],
            output_properties=["attitude/theta-deg"],
            aircraft_model="737",
            trim_airspeed=280,
            trim_altitude=10000,
            gear=1,
            record_inputs=True,
            properties={
                "atmosphere/turb-type": 3,
                "atmosphere/randomseed": 7,
                "atmosphere/turbulence/milspec/severity": 4,
                "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 50,
            },
        )
        source, scope = Source(lambda t: 0.05 * math.sin(t)), Scope()
        return Simulation(
            [fdm, source, scope],
            [Connection(source, fdm[0]), Connection(fdm[0], scope)],
            dt=1 / 120,
            log=False,
        ), scope

    sim, scope = build()
    sim.run(2.0)
    sim.save_checkpoint(str(tmp_path / "stop"))
    sim.run(2.0)
    again, other_scope = build()
    again.load_checkpoint(str(tmp_path / "stop"))
    again.run(2.0)
    theta = scope.read()[1][0]
    # the air is not still
    assert np.std(np.diff(theta)) > 1e-4
    assert np.array_equal(other_scope.read()[1][0], theta)


def test_a_hold_of_another_period_is_refused(tmp_path):
    def simulation(T):
        hold, rest, scope = PitchHold(T=T), Constant(0.0), Scope()
        wires = [Connection(rest, hold["theta"], hold["q"]), Connection(hold[0], scope)]
        return Simulation([hold, rest, scope], wires, dt=1 / 120, log=False), hold

    sim, _ = simulation(1 / 120)
    sim.run(1.0)
    sim.save_checkpoint(str(tmp_path / "stop"))
    other, hold = simulation(1 / 30)
    with pytest.raises(ParameterError, match=r"PitchHold with T = 0.00833.* has T = 0.0333"):
        other.load_checkpoint(str(tmp_path / "stop"))
    assert hold.clock.period == 1 / 30


def test_what_is_no_switch_does_not_record():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    sim = Simulation([plane], dt=plane.T, log=False)
    plane.record_inputs = np.array([])
    sim.run(0.1)
    assert len(plane._flown) == 0


def test_corrupted_files_load_the_same_flight_or_are_refused(tmp_path):
    assert 20 < loaded_from_corruptions(tmp_path, seed=11, count=40) <= 40


@pytest.fixture
def saved(tmp_path):
    sim, _, _ = diagram(states=1)
    sim.run(0.5)
    sim.save_checkpoint(str(tmp_path / "stop"))
    return tmp_path / "stop"


@pytest.mark.parametrize(
    "change",
    [
        lambda data: data["simulation"].update(time=1.0),
        lambda data: data["simulation"].update(dt=0.01),
        lambda data: data.pop("digest"),
        lambda data: data.update(digest=None),
        lambda data: data["blocks"].pop(),
        lambda data: data["blocks"][0].update(active=False),
        lambda data: data["blocks"][1].update(latched="no"),
        lambda data: data["blocks"][-1]["engine"].update(n=3),
    ],
)
def test_a_changed_value_is_refused_wherever_it_is(saved, change):
    file = saved.with_suffix(".json")
    data = json.loads(file.read_text())
    change(data)
    file.write_text(json.dumps(data))
    other, plane, _ = diagram(states=1)
    with pytest.raises(ParameterError, match="is damaged"):
        other.load_checkpoint(str(saved))
    assert (other.time, plane.samples) == (0.0, 0)


def test_arrays_of_another_save_are_refused(saved, tmp_path):
    sim, _, _ = diagram(states=1)
    sim.run(0.4)
    sim.save_checkpoint(tmp_path / "other.npz")
    (tmp_path / "other.npz").replace(saved.with_suffix(".npz"))
    with pytest.raises(ParameterError, match="is damaged"):
        diagram(states=1)[0].load_checkpoint(str(saved))


def test_the_same_data_written_otherwise_is_loaded(saved):
    file = saved.with_suffix(".json")
    file.write_text(json.dumps(json.loads(file.read_text()), indent=None))
    sim, plane, _ = diagram(states=1)
    sim.load_checkpoint(saved.with_suffix(".json"))
    assert plane.samples == 60


@pytest.mark.parametrize("gone", [".json", ".npz"])
def test_a_missing_file_is_named(saved, gone):
    saved.with_suffix(gone).unlink()
    with pytest.raises(FileError, match=rf"cannot read .*stop\{gone}': No such file"):
        diagram(states=1)[0].load_checkpoint(str(saved))


def test_no_folder_to_save_in(tmp_path):
    with pytest.raises(FileError, match=r"cannot write .*: No such file"):
        diagram(states=1)[0].save_checkpoint(str(tmp_path / "no" / "stop"))


FULL = """
import resource, signal, sys
sys.path.insert(0, sys.argv[2])
from corruptions import flight
from pathsim_jsbsim_blocks.errors import FileError
sim, _ = flight()
sim.run(0.5)
sim.save_checkpoint(sys.argv[1])
sim.run(2.0)
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
for size in (100, 8000):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))
    try:
        sim.save_checkpoint(sys.argv[1])
    except FileError as error:
        print(error.reason)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="no such limit")
def test_a_save_that_does_not_fit_on_the_disk_keeps_the_last_one(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", FULL, str(tmp_path / "stop"), str(Path(__file__).parents[1])],
        capture_output=True,
        text=True,
    )
    assert done.stderr == ""
    assert done.stdout.split("\n") == ["File too large"] * 2 + [""]
    assert sorted(file.name for file in tmp_path.iterdir()) == ["stop.json", "stop.npz"]
    sim, _ = flight()
    sim.load_checkpoint(str(tmp_path / "stop"))
    assert sim.time == pytest.approx(0.5)


def test_a_checkpoint_of_laws_with_other_states_is_refused(tmp_path, monkeypatch):
    from pathsim_jsbsim_blocks._core import sampling

    def build():
        return Simulation([PitchHold()], [], dt=1 / 120, log=False)

    sim = build()
    monkeypatch.setattr(sampling, "_STATES", 1)
    sim.save_checkpoint(str(tmp_path / "stop"))
    monkeypatch.undo()
    with pytest.raises(ParameterError, match="another version of this package, whose PitchHold"):
        build().load_checkpoint(str(tmp_path / "stop"))
