"""Engines of models from outside: what they are, whether they have fuel, why they do not run."""

import dataclasses
import math
from pathlib import Path

import jsbsim
import models_from_outside as outside
import numpy as np
import pytest
from pathsim import Connection, Simulation
from plain_jsbsim import open_fdm

from pathsim_jsbsim_blocks import (
    Aircraft,
    FlightError,
    JSBSimFDM,
    ParameterError,
    PitchHold,
    TrimCondition,
    TrimError,
)
from pathsim_jsbsim_blocks.design import design_gains
from pathsim_jsbsim_blocks.flight import Airframe, model_xml, trim
from pathsim_jsbsim_blocks.flight.model_xml import ModelXml
from pathsim_jsbsim_blocks.flight.settling import Settling
from pathsim_jsbsim_blocks.flight.trimming.effects import responses

SINGLE = {"altitude": 5000, "speed": 90}
TWIN = {"altitude": 5000, "speed": 110, "gear": 0}


@pytest.fixture
def single(tmp_path):
    return outside.electric_single(tmp_path)


@pytest.fixture
def twin(tmp_path):
    return outside.electric_twin(tmp_path)


def refused(root, aircraft="c172x", **condition):
    """The error of a trim that is not found."""
    airframe = Airframe(aircraft, root=root)
    with pytest.raises(TrimError) as error:
        trim(airframe, TrimCondition(**{**SINGLE, **condition}))
    return error.value


def system(output, value, name="own"):
    """A system of a model that writes a property in each step."""
    return f"""<system name="{name}"><property value="{value}">{name}/value</property>
    <channel name="{name}"><pure_gain name="{name}/gain"><input>{name}/value</input><gain>1</gain>
    <output>{output}</output></pure_gain></channel></system>"""


@pytest.mark.parametrize(
    ("aircraft", "types", "thrusters"),
    [
        ("c172p", "piston", "propeller"),
        ("737", "turbine", "direct"),
        ("DHC6", "turboprop", "propeller"),  # in its own folder Engines
        ("X15", "rocket", "nozzle"),
        ("F450", "electric", "propeller"),  # propulsion in a file of its own, brushless motors
        ("ah1s", "electric", "rotor"),
        ("C130", "turbine", "propeller"),
    ],
)
def test_engines_are_known_by_their_files(aircraft, types, thrusters):
    engines = Airframe(aircraft).engine_list
    assert {engine.type for engine in engines} == {types}
    assert {engine.thruster for engine in engines} == {thrusters}
    assert [engine.number for engine in engines] == list(range(len(engines)))


def test_the_engines_are_those_of_the_files_that_were_loaded(tmp_path):
    root = outside.changed(tmp_path, "c172p")
    airframe = Airframe("c172p", root=root)
    (tmp_path / "aircraft/c172p/c172p.xml").write_text("<no", encoding="utf-8")
    assert [engine.type for engine in airframe.engine_list] == ["piston"]


def test_a_file_that_python_cannot_read_is_no_error(tmp_path):
    # an undeclared namespace, which JSBSim's parser ignores
    root = outside.changed(tmp_path, "c172p")
    file = tmp_path / "aircraft/c172p/c172p.xml"
    text = file.read_text(encoding="utf-8").replace("<propulsion>", "<propulsion><x:note/>")
    file.write_text(text, encoding="utf-8")
    assert [engine.type for engine in Airframe("c172p", root=root).engine_list] == ["unknown"]


def test_an_engine_file_that_has_changed_is_read_again(tmp_path):
    root = outside.changed(tmp_path, "c172x")
    assert Airframe("c172x", root=root).engine_list[0].type == "piston"
    outside.electric_single(tmp_path)
    assert Airframe("c172x", root=root).engine_list[0].type == "electric"


def test_another_thread_may_read_files_of_the_model_meanwhile(monkeypatch):
    path = Path(jsbsim.get_default_root_dir(), "aircraft", "c172p", "c172p.xml")
    xml, stamp = ModelXml.of(path), model_xml._stamp

    def meanwhile(file):
        xml._stamps[path.with_name("read_meanwhile.xml")] = stamp(path)
        return stamp(file)

    assert xml.references
    monkeypatch.setattr(model_xml, "_stamp", meanwhile)
    assert ModelXml.of(path) is xml


@pytest.mark.parametrize(
    ("aircraft", "make", "condition", "watts"),
    [
        ("c172x", outside.electric_single, SINGLE, 120_000.0),
        ("c310", outside.electric_twin, TWIN, 180_000.0),
    ],
)
def test_electric_motors_trim_and_stay(tmp_path, aircraft, make, condition, watts):
    airframe = Airframe(aircraft, root=make(tmp_path))
    state = trim(airframe, TrimCondition(**condition), fly=10.0)
    assert 0.1 < min(state.throttle) == max(state.throttle) < 1.0
    assert abs(state.drift.height) < 1.0  # ft
    # power is throttle times that of the motor; JSBSim's propeller takes it all
    for name in airframe.of_engines("power-hp"):
        assert airframe.fdm[name] == pytest.approx(state.throttle[0] * watts / 745.7, rel=1e-6)


def plain(aircraft, root, state, dt, setup=None):
    """A plain JSBSim aircraft at the attitude and throttle of a trim at SINGLE."""
    fdm = open_fdm(aircraft, dt, setup, root)
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = SINGLE["altitude"], SINGLE["speed"]
    for angle in ("alpha", "theta", "phi"):
        fdm[f"ic/{angle}-deg"] = getattr(state, angle)
    fdm["fcs/throttle-cmd-norm"] = state.throttle[0]
    fdm.run_ic()
    fdm["fcs/throttle-cmd-norm"] = state.throttle[0]
    return fdm


def test_a_motor_trims_as_a_plain_loop_holds_it(single):
    state = trim(Airframe("c172x", root=single), TrimCondition(**SINGLE))
    surfaces = ("pitch-trim", "aileron", "rudder")
    commands = {f"fcs/{n}-cmd-norm": getattr(state, n.replace("-", "_")) for n in surfaces}
    fdm = plain("c172x", single, state, 1 / 120, commands)
    # the propeller of a fresh model stands still: it takes a few seconds to turn as in the trim
    fdm["propulsion/set-running"] = -1
    fdm["fcs/throttle-cmd-norm"] = state.throttle[0]
    for _ in range(120):
        fdm.run()
    assert fdm["propulsion/engine/thrust-lbs"] == pytest.approx(state.thrust, rel=0.02)
    assert fdm["velocities/vc-kts"] == pytest.approx(90.0, abs=0.5)


_WINDINGS = """<brushless_dc_motor name="motor"><velocityconstant>6</velocityconstant>
<coilresistance>0.05</coilresistance><noloadcurrent>1</noloadcurrent><maxvolts>480</maxvolts>
</brushless_dc_motor>"""


@pytest.mark.parametrize(
    ("aircraft", "change", "files"),
    [
        ("c172x", (), {"engine/eng_io320.xml": _WINDINGS}),
        # in the aircraft's own folder, and in the aircraft's own file
        (
            "c172p",
            ('file="eng_io320"', 'file="motor.xml"'),
            {"aircraft/c172p/Engines/motor.xml": outside.ELECTRIC.format(115_000)},
        ),
        ("c172p", ('file="eng_io320">', ">" + outside.ELECTRIC.format(115_000)), {}),
        # tanks that it does not burn from
        (
            "c172p",
            ("<contents.*?</contents>", ""),
            {"engine/eng_io320.xml": outside.ELECTRIC.format(115_000)},
        ),
    ],
    ids=["brushless", "own folder", "inline", "empty tanks"],
)
def test_so_do_motors_in_other_places(tmp_path, aircraft, change, files):
    root = outside.changed(tmp_path, aircraft, *[change] * bool(change), files=files)
    airframe = Airframe(aircraft, root=root)
    assert [engine.type for engine in airframe.engine_list] == ["electric"]
    assert abs(trim(airframe, TrimCondition(**SINGLE), fly=10.0).drift.height) < 1.0  # ft


@pytest.fixture
def mixed(tmp_path):
    """A c310 with a piston engine, number 0, and a motor."""
    first = r'(<engine file="engIO470D">.*?<engine file=")engIO470D', r"\1motor"
    files = {"engine/motor.xml": outside.ELECTRIC.format(180_000)}
    return outside.changed(tmp_path, "c310", first, files=files)


def test_beside_a_motor_a_piston_engine_may_be_off(mixed):
    airframe = Airframe("c310", root=mixed)
    off = TrimCondition(altitude=2000, speed=100, gear=0, engines_off=[0])
    state = trim(airframe, off, fly=10.0)
    left, right = (airframe.fdm[name] for name in airframe.of_engines("thrust-lbs"))
    assert left <= 0.0 < right
    assert abs(state.drift.height) < 1.0  # ft
    with pytest.raises(ParameterError):
        trim(airframe, dataclasses.replace(off, engines_off=[1]))


def test_the_excess_of_the_throttle_is_that_of_motors_too(mixed):
    # JSBSim marks neither: the motor follows its throttle, the piston engine is off
    plane = Aircraft(
        "c310",
        condition=TrimCondition(altitude=2000, speed=100, gear=0, engines_off=[0]),
        root=mixed,
        input_properties=["throttle[1]"],
    )
    plane.advance(1, [0.0] * 7 + [1.0])
    expected = plane.trim.throttle[1]  # of the motor alone; 1 more than the trimmed one is asked
    assert plane.advance(2, [0.0] * 7 + [1.0])[plane.output_port_labels["thr_sat"]] == (
        pytest.approx(expected, abs=1e-12)
    )


@pytest.mark.long
@pytest.mark.parametrize(("aircraft", "condition"), [("c172p", SINGLE), ("c310", TWIN)])
def test_electric_aircraft_have_linear_models_gains_and_holds(tmp_path, aircraft, condition):
    make = outside.electric_single if aircraft == "c172p" else outside.electric_twin
    root = make(tmp_path, aircraft=aircraft) if aircraft == "c172p" else make(tmp_path)
    designed = design_gains(aircraft, TrimCondition(**condition), root=root)
    plane = Aircraft(aircraft, **condition, root=root)
    assert "short period" in [mode.name for mode in plane.linear_model().modes()]
    target = plane.trim.theta + 2.0
    hold = PitchHold(T=plane.T, gains=designed.gains, theta_ref=target, reference="absolute")
    ports = [(plane, "theta", hold), (plane, "q", hold), (hold, "elevator", plane)]
    wires = [Connection(source[name], to[name]) for source, name, to in ports]
    Simulation([plane, hold], wires, dt=plane.T, log=False).run(15.0)
    assert plane.outputs["theta"] == pytest.approx(target, abs=0.1)  # deg


def test_in_flight_a_motor_is_not_called_stopped(single):
    plane = Aircraft("c172x", **SINGLE, root=single)
    state = plane.trim_here()
    assert state.condition.engines_off == ()
    assert state.throttle == pytest.approx(plane.trim.throttle, abs=1e-6)


@pytest.mark.parametrize("engines", [[0], [1], "all"])
def test_a_motor_cannot_be_stopped_but_by_its_throttle(twin, engines):
    with pytest.raises(ParameterError) as error:
        trim(Airframe("c310", root=twin), TrimCondition(**TWIN, engines_off=engines))
    assert error.value.parameter == "engines_off"
    name = "propulsion/engine[1]/set-running"
    for written in ({"setup": {name: 0}}, {"properties": {name: 0}}):
        with pytest.raises(ParameterError):
            Aircraft("c310", **TWIN, root=twin, **written)
    # what a user of an earlier version wrote to have it trim
    assert Aircraft("c310", **TWIN, root=twin, setup={name: 1}).trim.thrust > 100.0


def test_in_flight_a_motor_cannot_be_stopped_either(twin):
    plane = JSBSimFDM(
        aircraft_model="c310",
        JSBSim_path=twin,
        condition=TrimCondition(**TWIN),
        input_properties=["propulsion/engine[1]/set-running"],
        output_properties=["propulsion/engine[1]/thrust-lbs"],
    )
    with pytest.raises(FlightError) as error:
        plane.advance(1, [0.0])
    assert error.value.name == "propulsion/engine[1]/set-running"


@pytest.mark.parametrize("frozen", [0.0, 1.0])
@pytest.mark.parametrize("solver", ["newton", "jsbsim"])
def test_empty_tanks_are_named(frozen, solver):
    # frozen fuel keeps JSBSim's engine running on empty tanks, with 217 lbf
    condition = TrimCondition(
        **SINGLE, fuel=[0, 0], setup={"propulsion/fuel_freeze": frozen}, solver=solver
    )
    with pytest.raises(TrimError) as error:
        trim(Airframe("c172p"), condition)
    assert (error.value.reason, error.value.engines) == ("fuel", [0])
    tanks = [f"propulsion/tank[{i}]/contents-lbs" for i in (0, 1)]
    assert error.value.properties == dict.fromkeys(tanks, 0.0)


def test_tanks_without_contents_are_named_and_filled_they_fly(tmp_path):
    root = outside.without_contents(tmp_path)
    error = refused(root)
    assert (error.reason, error.engines) == ("fuel", [0])
    full = dict.fromkeys(error.properties, 50.0)
    assert trim(Airframe("c172x", root=root), TrimCondition(**SINGLE, setup=full)).throttle[0] < 1


def test_one_engine_without_fuel_is_named_and_can_be_left_out():
    # engine 0 is fed by tanks 0 and 2, engine 1 by 1 and 2
    dry = {"altitude": 10_000, "speed": 250, "gear": 0, "fuel": {1: 0.0, 2: 0.0}}
    with pytest.raises(TrimError) as error:
        trim(Airframe("737"), TrimCondition(**dry))
    assert (error.value.reason, error.value.engines) == ("fuel", [1])
    assert trim(Airframe("737"), TrimCondition(**dry, engines_off=[1])).thrust > 0.0


def test_a_glide_needs_no_fuel():
    airframe = Airframe("c172p")
    state = trim(airframe, TrimCondition(altitude=5000, speed=70, mode="glide", fuel=[0, 0]))
    assert airframe.stopped == {0}
    assert state.thrust <= 0.0
    assert state.gamma < -4.0


def test_a_valve_that_the_model_shuts_is_named(tmp_path):
    text = "".join(system(f"propulsion/tank[{i}]/priority", 0, f"own{i}") for i in (0, 1))
    error = refused(outside.changed(tmp_path, "c172x", outside.before("aerodynamics", text)))
    assert (error.reason, error.engines) == ("fuel valve", [0])
    assert error.properties == {f"propulsion/tank[{i}]/priority": 0.0 for i in (0, 1)}


def test_cocks_that_keep_fuel_from_the_engines_are_told_from_empty_tanks():
    closed = {f"fcs/fuel-system/{side}-tank-cock-cmd-norm": 0 for side in ("left", "right")}
    error = refused(None, "Short_S23", speed=130, setup=closed)
    assert (error.reason, error.engines) == ("fuel valve", [0, 1, 2, 3])
    assert error.properties == {f"propulsion/tank[{i}]/contents-lbs": 0.0 for i in range(8, 12)}


@pytest.mark.parametrize(
    ("mixture", "altitude"), [(1.0, 10_000), (0.3, 2000)], ids=["too rich", "too lean"]
)
def test_a_mixture_is_named_with_one_that_runs(mixture, altitude):
    setup = {"fcs/mixture-cmd-norm[0]": mixture}
    condition = TrimCondition(altitude=altitude, speed=80, setup=setup)
    with pytest.raises(TrimError) as error:
        trim(Airframe("c182"), condition, hint=False)
    assert (error.value.reason, error.value.engines) == ("mixture", [0])
    assert set(error.value.properties) == set(setup)
    trim(Airframe("c182"), dataclasses.replace(condition, setup=error.value.properties))


def test_ignition_that_the_model_cuts_is_not_called_a_mixture(tmp_path):
    text = system("propulsion/magneto_cmd", 0)
    error = refused(outside.changed(tmp_path, "c172x", outside.before("aerodynamics", text)))
    assert (error.reason, error.engines) == ("engine", [0])


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        # pumps of its own fill the tanks of its engines
        ("Short_S23", {"altitude": 5000, "speed": 130}),
        ("Short_S23", {"altitude": 5000, "speed": 110}),
        ("Short_S23", {"altitude": 2000, "speed": 150}),
        # beside the limit of their torque
        ("DHC6", {"altitude": 2400, "speed": 141, "mode": "turn", "bank": 32}),
        ("DHC6", {"altitude": 2000, "speed": 118, "gamma": 3.3}),
    ],
)
def test_what_was_refused_for_its_engines_flies(aircraft, condition):
    airframe = Airframe(aircraft)
    state = trim(airframe, TrimCondition(**condition), fly=10.0)
    climb = 0.02 * 10.0 * state.tas * math.sin(math.radians(state.gamma))
    assert abs(state.drift.height) < 0.5 + climb  # ft; thinner air has less power
    assert abs(state.drift.speed) < 0.2
    for _ in range(120):
        airframe.fdm.run()
    assert airframe.starved() == []


@pytest.mark.parametrize("frozen", [None, 0.0, 1.0])
def test_fuel_burns_after_the_trim_unless_the_user_froze_it(frozen):
    setup = {} if frozen is None else {"propulsion/fuel_freeze": frozen}
    airframe = Airframe("737")
    trim(airframe, TrimCondition(altitude=15_000, speed=280, gear=0, setup=setup))
    before = airframe.fdm["propulsion/total-fuel-lbs"]
    for _ in range(240):
        airframe.fdm.run()
    burns = before - airframe.fdm["propulsion/total-fuel-lbs"]
    assert burns == 0.0 if frozen else burns > 0.5


def test_a_trim_on_the_last_drops_is_refused():
    # the cruise of a c172p burns about 0.01 lb in a second
    drops = {"altitude": 5000, "speed": 90, "fuel": [0.002, 0.002]}
    with pytest.raises(TrimError) as error:
        trim(Airframe("c172p"), TrimCondition(**drops), hint=False)
    assert (error.value.reason, error.value.engines) == ("fuel", [0])
    trim(Airframe("c172p"), TrimCondition(**{**drops, "fuel": [0.1, 0.1]}), hint=False)


@pytest.mark.parametrize(
    ("make", "command", "name"),
    [
        (outside.lever_writes_throttle, "throttle", "fcs/throttle-cmd-norm[0]"),
        (outside.without_pitch_command, "pitch", "fcs/elevator-cmd-norm"),
    ],
)
def test_a_command_that_moves_nothing_is_named(tmp_path, make, command, name):
    error = refused(make(tmp_path))
    assert (error.reason, error.command) == ("no effect", command)
    # a lever of 0.3 is what the model writes
    assert error.properties[name] == (
        pytest.approx(0.3) if command == "throttle" else pytest.approx(error.properties[name])
    )


@pytest.mark.parametrize("command", ["roll", "yaw"])
def test_so_is_one_of_roll_or_yaw(tmp_path, command):
    name = {"roll": "aileron", "yaw": "rudder"}[command]
    cut = rf"<input>\s*fcs/{name}-cmd-norm\s*</input>", "<input>fcs/nothing</input>"
    text = '<system name="own"><property value="0">fcs/nothing</property></system>'
    root = outside.changed(tmp_path, "c172x", cut, outside.before("aerodynamics", text))
    # bank and sideslip cannot take their place in a steady turn
    error = refused(root, mode="turn", bank=20)
    assert (error.reason, error.command) == ("no effect", command)


@pytest.mark.parametrize(
    ("name", "low", "high", "condition", "end"),
    [
        ("rudder", -0.1, 0.1, {"beta": 8}, 1.0),
        ("rudder", -0.1, 0.1, {"beta": -8}, -1.0),
        ("rudder", 0.0, 0.1, {"beta": -8}, -1.0),
        ("rudder", -1.0, 0.0, {"beta": 8}, 1.0),
        ("rudder", -0.02, 0.02, {"mode": "turn", "bank": 40}, -1.0),
    ],
)
def test_a_command_that_the_model_limits_to_a_part_of_its_range_is_at_its_end(
    tmp_path, name, low, high, condition, end
):
    # beyond the model's limits no change of the command acts on anything; in plain JSBSim the
    # sideslip or turn needs more than they allow
    limits = f"""<system name="limits"><channel name="limits"><pure_gain name="limits/command">
        <input>fcs/{name}-cmd-norm</input><gain>1</gain>
        <clipto><min>{low}</min><max>{high}</max></clipto></pure_gain></channel></system>"""
    cut = rf"<input>\s*fcs/{name}-cmd-norm\s*</input>", "<input>limits/command</input>"
    root = outside.changed(tmp_path, "c172x", cut, outside.before("flight_control", limits))
    error = refused(root, **condition)
    assert (error.reason, error.limit) == (name, end)
    free = trim(Airframe("c172x"), TrimCondition(**{**SINGLE, **condition}))
    assert not low < free.rudder < high


def test_a_command_at_the_models_own_limit_has_an_effect():
    # above 0.35 the Camel's rudder moves no further; where the search ends there depends on the
    # last digit
    error = refused(None, "Camel", speed=85, mode="pull-up", load_factor=3, gamma=8)
    assert error.reason in ("thrust", "rudder")


def test_a_propeller_without_inertia_is_the_reason_at_any_speed(tmp_path):
    root = outside.light_propeller(tmp_path, math.inf)
    for speed in (70, 90, 110):
        error = refused(root, "c172p", speed=speed)
        assert error.reason == "propeller"
        assert "moment of inertia, ixx" in str(error)


@pytest.mark.parametrize("fraction", [10, 20])
def test_the_thrust_of_a_light_propeller_is_that_of_a_plain_loop(tmp_path, fraction):
    # JSBSim's own steady state of these is 2e8 and 9e8 lbf
    root = outside.light_propeller(tmp_path, fraction)
    state = trim(Airframe("c172p", root=root), TrimCondition(**SINGLE))
    motions = ("rate/translational", "rate/rotational", "position/translational")
    frozen = {f"simulation/integrator/{motion}": 0 for motion in motions}
    fdm = plain("c172p", root, state, 1 / 1000, frozen)
    for _ in range(20_000):
        fdm.run()
    assert state.thrust == pytest.approx(fdm["propulsion/engine/thrust-lbs"], rel=1e-8)


def test_a_propeller_too_light_for_the_step_is_told_substeps_that_fly(tmp_path):
    root = outside.light_propeller(tmp_path, 300)
    error = refused(root, "c172p")
    assert error.reason == "propeller"
    assert "substeps=8" in str(error)
    with pytest.raises(TrimError, match="substeps=16"):
        Aircraft("c172p", **SINGLE, root=root, T=1 / 60, substeps=2)
    plane = Aircraft("c172p", **SINGLE, root=root, substeps=8)
    Simulation([plane], dt=plane.T, log=False).run(10.0)
    assert plane.airframe.fdm["position/h-sl-ft"] == pytest.approx(5000.0, abs=0.1)


def test_a_propeller_that_alternates_from_step_to_step_has_a_warning(tmp_path):
    root = outside.light_propeller(tmp_path, 100)
    with pytest.warns(RuntimeWarning, match="substeps=2"):
        trim(Airframe("c172p", root=root), TrimCondition(**SINGLE))
    trim(Airframe("c172p", root=root, substeps=2), TrimCondition(**SINGLE))


def test_a_quadrotor_is_told_all_of_its_dead_commands():
    error = refused(None, "F450", speed=60)
    assert (error.reason, error.command) == ("no effect", "throttle")
    assert error.commands == ["throttle", "pitch", "roll", "yaw"]
    assert "mode='none'" in str(error)


def test_a_throttle_that_the_model_writes_is_named_with_its_source():
    error = refused(None, "p51d", speed=170)
    assert (error.reason, error.commands) == ("no effect", ["throttle"])
    assert "/controls/engines/engine/throttle" in str(error)


def test_a_rocket_without_oxidizer_has_no_fuel():
    error = refused(None, "X15", speed=232)
    assert (error.reason, error.engines) == ("fuel", [0])
    assert error.properties["propulsion/tank[0]/contents-lbs"] == 0.0


def test_a_model_without_aerodynamics_and_a_rotorcraft_are_called_so(tmp_path):
    empty = r"<aerodynamics>.*</aerodynamics>", "<aerodynamics></aerodynamics>"
    assert refused(outside.changed(tmp_path, "c172x", empty)).reason == "aerodynamics"
    assert refused(None, "ah1s").reason == "rotorcraft"


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [("c172p", {"speed": 90}), ("737", {"speed": 260, "gear": 0}), ("DHC6", {"speed": 133})],
)
def test_the_effects_of_commands_are_those_of_a_short_flight(aircraft, condition):
    airframe = Airframe(aircraft)
    effects = {e.command: e for e in responses(airframe, TrimCondition(**condition))[1]}
    assert all(e.moves and not e.written_by_model for e in effects.values())
    assert effects["throttle"].size > 1.0  # ft/s2
    plane = Airframe(aircraft)
    trim(plane, TrimCondition(**condition))
    fdm = plane.fdm
    for command in ("pitch", "roll", "yaw"):
        (name,) = effects[command].properties
        rate = f"accelerations/{effects[command].acceleration}-rad_sec2"
        fdm[name] += 0.1
        for _ in range(3):
            fdm.run()
        assert np.sign(fdm[rate]) == np.sign(effects[command].size)
        fdm[name] -= 0.1
        for _ in range(120):
            fdm.run()


def test_the_effect_of_a_command_whose_deflection_stays_is_that_in_plain_jsbsim():
    # in initialisations, one after another, the f22's ailerons move to a deflection and keep it
    pdot = {}
    for aileron in (0.0, 0.5):
        fdm = open_fdm("f22", 1 / 120, {"gear/gear-cmd-norm": 1.0, "gear/gear-pos-norm": 1.0})
        fdm["ic/h-sl-ft"], fdm["ic/vc-kts"], fdm["ic/alpha-deg"] = 5000.0, 300.0, 3.0
        fdm["fcs/aileron-cmd-norm"] = aileron
        fdm.set_trim_status(True)
        for _ in range(60):
            fdm.run_ic()
        pdot[aileron] = fdm["accelerations/pdot-rad_sec2"]
    *_, roll, _ = responses(Airframe("f22"), TrimCondition(altitude=5000, speed=300, gear=1))[1]
    assert roll.size == pytest.approx((pdot[0.5] - pdot[0.0]) / 0.5, rel=1e-6)


def test_a_command_that_the_model_writes_itself_has_no_effect():
    fdm = open_fdm("ah1s", 1 / 120, {"ic/h-sl-ft": 5000.0, "ic/vc-kts": 90.0})
    fdm.run_ic()
    fdm["fcs/pitch-trim-cmd-norm"] = 0.5
    fdm.run()
    assert fdm["fcs/pitch-trim-cmd-norm"] == 0.0
    _, pitch, *_ = responses(Airframe("ah1s"), TrimCondition(**SINGLE))[1]
    # 0.5 of it still changes qdot by 2e-5 rad/s2, two tolerances of the search
    assert pitch.properties == ("fcs/pitch-trim-cmd-norm",)
    assert (pitch.moves, pitch.written_by_model) == (False, True)


def test_a_propeller_that_stops_settles_the_second_time_as_the_first():
    """The rate of a propeller at rest, 10^7 / s, says nothing about the restarted one."""
    airframe = Airframe("c172p")
    # full rich, the engine does not run there: JSBSim's start turns it, and it stops
    trim(airframe, TrimCondition(altitude=25_000, speed=80, mode="none"))
    steps, speeds = [], []
    settling = Settling(airframe, steps.append)
    for _ in range(2):
        settling.start()
        assert airframe.fdm["propulsion/engine/propeller-rpm"] > 2000.0
        assert settling.settle()
        speeds.append(airframe.fdm["propulsion/engine/propeller-rpm"])
        assert sum(steps) < 1000
        steps.clear()
    assert speeds == pytest.approx([0.0, 0.0], abs=0.1)


@pytest.mark.parametrize("aircraft", ["c172r", "c172p", "J3Cub", "pa28"])
def test_an_engine_that_lags_is_not_taken_for_a_light_propeller(aircraft):
    """While its manifold fills, the changes of a propeller's speed do not show its time constant."""
    airframe, steps = Airframe(aircraft), []
    trim(airframe, TrimCondition(altitude=200, speed=70, mode="none"))
    settling = Settling(airframe, steps.append)
    settling.start()
    for throttle in (0.5, 0.1, 1.0, 0.05):
        airframe.fdm["fcs/throttle-cmd-norm"] = throttle
        steps.clear()
        assert settling.settle(1e-8)
        assert sum(steps) < 250, throttle


def test_a_propeller_that_creeps_stands():
    """The stopped engine of the p51d turns by 1e-4 rpm per s, and sticks again at 0.04 rpm."""
    airframe, steps = Airframe("p51d"), []
    trim(airframe, TrimCondition(altitude=1000, speed=103, mode="glide"))
    settling = Settling(airframe, steps.append)
    assert settling.settle()
    assert sum(steps) < 250
    assert airframe.fdm["propulsion/engine/propeller-rpm"] == pytest.approx(0.0, abs=0.1)


def test_level_flight_trims_between_two_speeds_that_trim():
    level = TrimCondition(altitude=200, setup={"propulsion/fuel_freeze": 1}, solver="newton")
    alphas = [
        trim(Airframe("c172r"), dataclasses.replace(level, speed=speed), hint=False).alpha
        for speed in (80.14, 79.34, 78.54)  # KCAS
    ]
    assert alphas == pytest.approx([4.14, 4.29, 4.45], abs=0.02)
