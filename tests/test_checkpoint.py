"""Stop and go on: a checkpoint continues bit for bit, by flying the recorded inputs again."""

import math

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope, Source
from pathsim.solvers import RK4

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, ParameterError, PitchHold

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
        [Connection(plane["theta"], hold["theta"], scope[0], *integrators),
         Connection(plane["q"], hold["q"]),
         Connection(hold["elevator"], plane["elevator"], scope[1]),
         Connection(doublet, plane["rudder"]), Connection(wobble, plane["aileron"]),
         Connection(plane["phi"], scope[2])],
        dt=dt, Solver=RK4, log=False)
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
    assert np.array_equal(first, scope.read()[1][:, :first.shape[1]])


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
@pytest.mark.parametrize("change", [
    {"aircraft": "c172x"}, {"T": 1 / 60}, {"substeps": 2}, {"properties": {"fcs/flap-cmd-norm": 1}},
    {"setup": {"propulsion/tank/contents-lbs": 10}}, {"create": {"a/b": 1.0}}, {"heading": 1},
], ids=lambda change: next(iter(change)))
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


def test_a_checkpoint_of_other_ports_is_refused(tmp_path):
    def build(input_, output):
        fdm = JSBSimFDM(input_properties=[f"fcs/{input_}-cmd-norm"], output_properties=[output],
                        aircraft_model="c172p", trim_airspeed=90, trim_altitude=5000,
                        record_inputs=True)
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
    plane.heading = 90.0
    plane.T = 1 / 60
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
        fdm = JSBSimFDM(input_properties=["fcs/elevator-cmd-norm"],
                        output_properties=["attitude/theta-deg"], aircraft_model="737",
                        trim_airspeed=280, trim_altitude=10000, record_inputs=True,
                        properties={"atmosphere/turb-type": 3,
                                    "atmosphere/randomseed": 7,
                                    "atmosphere/turbulence/milspec/severity": 4,
                                    "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 50})
        source, scope = Source(lambda t: 0.05 * math.sin(t)), Scope()
        return Simulation([fdm, source, scope],
                          [Connection(source, fdm[0]), Connection(fdm[0], scope)],
                          dt=1 / 120, log=False), scope

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
        return Simulation([hold := PitchHold(T=T)], dt=1 / 120, log=False), hold

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
