"""JSBSim's scripts and reset files in the block, beside plain JSBSim that flies the same files."""

import logging
import math

import numpy as np
import pytest
from flown_scripts import OUTPUTS, bundled_reset_files, recorded, scripted
from how_many import first
from pathsim import Simulation
from pathsim.blocks import StepSource
from plain_jsbsim import flown_reset_file, flown_script, open_fdm, rows_from_start
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, RampSource, TrimCondition
from pathsim_jsbsim_blocks.errors import (
    BlocksError,
    FlightError,
    KeywordError,
    LinearisationError,
    ParameterError,
)

SCRIPT = """
<runscript name="t">
  <use aircraft="c172x" initialize="reset00"/>
  <run start="{start}" end="{end}" dt="{dt}">{events}</run>{more}
</runscript>
"""


def written(folder, events="", start="0", end="10", dt="0.01", more="", name="t.xml"):
    file = folder / name
    file.write_text(SCRIPT.format(start=start, end=end, dt=dt, events=events, more=more))
    return str(file)


def event(sets="", condition="simulation/sim-time-sec ge 1", more="", name="e"):
    return f'<event name="{name}"><condition>{condition}</condition>{sets}{more}</event>'


def put(name, value):
    return f'<set name="{name}" value="{value}"/>'


# a trim in flight; a ramp on the ground; the state file that it writes; a trim that the reset file
# asks for; an airship; a bomb, whose script terminates
SIX = ["737_cruise", "c1722", "c1723", "B737_Runway", "Submarine_Scout_1", "mk82_script"]


@pytest.mark.parametrize("name", SIX)
def test_a_script_flies_bit_for_bit_as_in_jsbsim_and_again_after_a_reset(
    name, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    seconds = 1.0 if name == "Submarine_Scout_1" else 4.0
    rows = flown_script(f"scripts/{name}.xml", OUTPUTS, seconds)
    plane = scripted(f"scripts/{name}.xml")
    first, again = recorded(plane, seconds), recorded(plane, seconds, reset=True)
    np.testing.assert_array_equal(first[: len(rows)], rows)
    np.testing.assert_array_equal(again, first)
    assert list(tmp_path.iterdir()) == []


# the model of a blank aircraft is no model
FILES = [("737", "cruise_init"), ("c172x", "reset01"), ("ball", "reset00_v2")]
FILES += [pair for pair in bundled_reset_files() if pair[0] != "blank" and pair not in FILES]


@pytest.mark.parametrize(("aircraft", "file"), first(FILES, 3))
def test_a_reset_file_is_the_start_of_the_flight(aircraft, file):
    plane = JSBSimFDM(aircraft_model=aircraft, initialize=file, output_properties=OUTPUTS)
    rows, flown = flown_reset_file(aircraft, file, OUTPUTS, 5.0), recorded(plane, 5.0)
    np.testing.assert_array_equal(flown, rows[: len(flown)])
    assert plane.duration is None
    if len(flown) < len(rows):
        # where the block ends a flight without a script
        fdm = plane.airframe.fdm
        values = fdm["position/h-agl-ft"], fdm["accelerations/Nz"]
        assert values[0] < -1.0 or abs(values[1]) > 50.0 or not np.isfinite(sum(values))


def test_a_file_of_outputs_is_found_beside_the_script_when_a_write_is_left_out(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    plane = JSBSimFDM(
        script="scripts/737_cruise.xml",
        input_properties=["simulation/notify-time-trigger"],
        allow_files=True,
    )
    Simulation([plane], dt=plane.T, log=False).run(0.5)
    assert [p.name for p in tmp_path.iterdir()] == ["737_cruise_output.csv"]


def test_substeps_show_each_fourth_row_of_a_script():
    rows = flown_script("scripts/rudder_kick.xml", OUTPUTS, 2.0)
    fdm = scripted("scripts/rudder_kick.xml", substeps=4)
    assert fdm.T == 4 * 0.008333
    flown = recorded(fdm, 2.0)
    np.testing.assert_array_equal(flown, rows[::4][: len(flown)])


def test_an_input_of_the_block_owns_its_property():
    script = flown_script("scripts/rudder_kick.xml", OUTPUTS, 6.0)
    T = 0.008333
    plane = scripted("scripts/rudder_kick.xml", input_properties=["fcs/rudder-cmd-norm"])
    rudder = RampSource(final=0.92, start=12 * T, rise_time=3.0)
    sim, scope = diagram(plane, OUTPUTS, {0: rudder})
    sim.run(6.0)
    away = np.abs(scope.read()[1].T[: len(script)] - script)
    # the ramps are equal to rounding errors: 1e-9 of the force and of the state
    assert (away[:, :-1].max(axis=0) <= 1e-7).all(), away.max(axis=0)
    assert script[:, OUTPUTS.index("fcs/rudder-cmd-norm")].max() > 0.9


@pytest.mark.parametrize(
    "name", ["fcs/rudder-cmd-norm", "/fdm/jsbsim/fcs/rudder-cmd-norm", "fcs/throttle-cmd-norm[0]"]
)
def test_an_input_that_is_not_connected_silences_the_events(tmp_path, name):
    sets = put("fcs/rudder-cmd-norm", 0.5) + put("fcs/throttle-cmd-norm", 0.5)
    script = written(tmp_path, event(sets, "simulation/sim-time-sec ge 0.1"))
    plane = JSBSimFDM(script=script, input_properties=[name], output_properties=[name])
    Simulation([plane], dt=plane.T, log=False).run(0.5)
    assert plane.outputs.to_array() == [0.0]


def test_a_script_ends_with_one_warning_and_the_aircraft_flies_on():
    plane = scripted("scripts/x151.xml")
    assert plane.duration == 600 * 0.0083333  # the last step before 5 s
    sim = Simulation([plane], dt=plane.T, log=False)
    sim.run(plane.duration)  # without a warning
    with pytest.warns(RuntimeWarning, match=r"script x151\.xml ends at t = 5\.0\d+ s") as warned:
        sim.run(1.0)
    assert len(warned) == 1
    assert plane.outputs.to_array()[-1] == pytest.approx(6.0, abs=plane.T)


def test_a_script_that_terminates_warns_alike(tmp_path):
    script = written(tmp_path, event(put("simulation/terminate", 1)))
    plane = JSBSimFDM(script=script)
    sim = Simulation([plane], dt=plane.T, log=False)
    with pytest.warns(RuntimeWarning, match=r"script t\.xml ends at t = 1 s") as warned:
        sim.run(3.0)
    assert len(warned) == 1


def test_an_event_starts_the_aircraft_again_while_the_time_goes_on(tmp_path):
    script = written(tmp_path, event(put("simulation/reset", 1)), end="60")
    rows = flown_script(script, OUTPUTS, 3.0)
    assert (np.diff(rows[:, -1]) < 0).any()
    plane = scripted(script)
    sim = Simulation([plane], dt=plane.T, log=False)
    for row in range(0, 300, 20):
        np.testing.assert_array_equal(plane.outputs.to_array(), rows[row])
        sim.run(0.2)
    assert sim.time == pytest.approx(3.0)


def test_a_reset_by_an_event_does_not_begin_an_ended_flight_again(tmp_path):
    name = "fcs/elevator-cmd-norm"
    script = written(tmp_path, event(put("simulation/reset", 1)), end="60")
    plane = JSBSimFDM(
        script=script, input_properties=[name], output_properties=["position/h-sl-ft"]
    )
    sick = StepSource(amplitude=[0.0, math.nan], tau=[0.0, 0.995])
    sim, _ = diagram(plane, sources={name: sick})
    for _ in range(2):  # the event is due in the period after the end
        with pytest.raises(FlightError) as error:
            sim.run(3.0)
        assert (error.value.name, error.value.time) == (name, pytest.approx(1.0))
    assert "reset to fly again" in str(error.value)
    sim.run(0.5, reset=True)
    assert plane.samples == 50


def test_a_crash_in_a_script_warns_once():
    # 64 g in the second step, in plain JSBSim too
    plane = scripted("scripts/p51_start_test.xml")
    rows = flown_script("scripts/p51_start_test.xml", ["accelerations/Nz", *OUTPUTS], 1.0)
    assert np.abs(rows[:, 0]).max() > 50.0
    sim = Simulation([plane], dt=plane.T, log=False)
    with pytest.warns(RuntimeWarning, match="p51d: crashed, load factor .* at t =") as warned:
        sim.run((len(rows) - 1) * plane.T)
    assert len(warned) == 1
    np.testing.assert_array_equal(plane.outputs.to_array(), rows[-1, 1:])


def test_notices_go_to_the_logger(tmp_path, caplog, capfd):
    notice = "<notify><property>position/h-agl-ft</property></notify>"
    plane = JSBSimFDM(script=written(tmp_path, event(more=notice, name="gear check")))
    with caplog.at_level(logging.INFO, "pathsim_jsbsim_blocks.jsbsim"):
        Simulation([plane], dt=plane.T, log=False).run(1.5)
    [text] = [r.getMessage() for r in caplog.records if "gear check" in r.getMessage()]
    assert "executed at time: 1 position/h-agl-ft = " in text
    assert capfd.readouterr() == ("", "")


def test_setup_is_written_before_the_start_and_properties_after_it(tmp_path):
    script = written(tmp_path)
    plane = JSBSimFDM(
        script=script,
        setup={"ic/h-agl-ft": 3000.0},
        properties={"fcs/rudder-cmd-norm": 0.25},
        output_properties=["position/h-agl-ft", "fcs/rudder-cmd-norm"],
    )
    assert plane.outputs.to_array() == pytest.approx([3000.0, 0.25], abs=1e-6)
    with pytest.raises(ParameterError, match="overwritten"):
        JSBSimFDM(script=script, setup={"position/h-sl-ft": 3000.0})


@pytest.mark.parametrize(
    "parameters",
    [
        {"T": 0.02},
        {"aircraft_model": "f16"},
        {"condition": TrimCondition()},
        {"trim_airspeed": 90},
        {"trim_mode": "none"},
        {"gear": 1.0},
        {"flaps": 0.5},
        {"planet": "round"},
        {"initialize": "reset01"},
    ],
)
def test_parameters_of_another_start_are_refused(tmp_path, parameters):
    [name] = parameters
    with pytest.raises(ParameterError, match=name) as caught:
        JSBSimFDM(script=written(tmp_path), **parameters)
    assert caught.value.parameter == name
    if name not in ("T", "aircraft_model", "initialize"):
        with pytest.raises(ParameterError, match=f"{name}.*cannot be combined with initialize"):
            JSBSimFDM(aircraft_model="c172x", initialize="reset00", **parameters)


def test_what_the_script_has_may_be_repeated(tmp_path):
    plane = JSBSimFDM(script=written(tmp_path), T=0.03, substeps=3, aircraft_model="c172x")
    np.testing.assert_allclose(plane.T, 0.03)
    assert repr(plane) == "JSBSimFDM('c172x', script t.xml)"


def test_another_script_is_set_in_flight_and_a_bad_one_refused(tmp_path):
    plane = JSBSimFDM(script=written(tmp_path), output_properties=["fcs/rudder-cmd-norm"])
    sim = Simulation([plane], dt=plane.T, log=False)
    sim.run(1.5)
    other = written(tmp_path, event(put("fcs/rudder-cmd-norm", 0.5)), name="other.xml")
    with pytest.raises(ParameterError, match="no script"):
        plane.script = "othr.xml"
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.script = other
    sim.run(1.5, reset=True)
    assert plane.outputs.to_array() == [0.5]


def test_the_period_follows_the_script_and_the_substeps(tmp_path):
    script = written(tmp_path)
    plane = JSBSimFDM(script=script, output_properties=["simulation/sim-time-sec"])
    sim = Simulation([plane], dt=0.01, log=False)
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.substeps = 7
    np.testing.assert_allclose(plane.T, 0.07)
    sim.run(0.7, reset=True)
    np.testing.assert_allclose(plane.outputs.to_array(), [0.7])
    other = written(tmp_path, dt="0.02", name="other.xml")
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.script = other
    np.testing.assert_allclose(plane.T, 0.14)
    with pytest.raises(ParameterError, match=r"T=0\.02, but script t\.xml has the step 0\.01 s"):
        plane.set(script=script, T=0.02)
    np.testing.assert_allclose(plane.T, 0.14)
    plane = JSBSimFDM(aircraft_model="c172x", initialize="reset00")
    with pytest.warns(RuntimeWarning, match="next reset"):
        plane.set(initialize=None, script=script)
    assert plane.T == 0.01


def test_aircraft_refuses_a_script():
    for name in ("script", "initialize"):
        with pytest.raises(KeywordError, match="use JSBSimFDM"):
            Aircraft("c172p", **{name: "scripts/c1723.xml"})


def test_a_trim_of_the_present_has_no_events(tmp_path):
    events = '<property value="1">guidance/own</property>' + event(
        put("fcs/elevator-cmd-norm", -1) + put("guidance/own", 2), "simulation/sim-time-sec ge 0"
    )
    plane = JSBSimFDM(
        script=written(tmp_path, events),
        setup={"ic/h-agl-ft": 5000.0, "ic/vc-kts": 90.0, "propulsion/set-running": -1},
        output_properties=["velocities/vc-kts"],
    )
    Simulation([plane], dt=plane.T, log=False).run(0.5)
    state = plane.trim_here(gamma=0.0)
    assert state.speed == pytest.approx(plane.outputs.to_array()[0], abs=0.01)
    assert state.elevator > -0.9
    with pytest.raises(LinearisationError):
        plane.linear_model()


def test_a_trim_at_rest_is_refused_for_its_speed():
    plane = Aircraft("c172p", mode="none", speed=0.0)
    with pytest.raises(ParameterError, match="speed"):
        plane.trim_here()


def test_a_script_in_orbit_is_not_clamped():
    plane = scripted("scripts/ball_orbit_phase.xml")
    assert plane.trim.condition.altitude == pytest.approx(1.365e6, rel=1e-3)
    with pytest.raises(ParameterError, match="altitude"):
        plane.trim_here()


def test_a_reset_file_is_the_start_of_a_trim():
    condition = TrimCondition.from_file("cruise_init", "737", mode="full", gear=0.0)
    # the file's altitude is that above the terrain, its latitude geocentric
    assert condition.altitude == pytest.approx(30000.0, abs=0.2)
    assert (condition.mode, condition.gear) == ("full", 0.0)
    state = Aircraft("737", condition=condition).trim
    assert state.altitude == pytest.approx(condition.altitude)
    assert state.udot == pytest.approx(0.0, abs=1e-4)


# 285 KCAS with the gear down
@pytest.mark.filterwarnings("ignore:737 at")
@pytest.mark.parametrize(("aircraft", "file"), first(FILES, 3))
def test_a_reset_file_in_mode_none_is_its_state(aircraft, file):
    if (aircraft, file) == ("pogo-jsbsim", "reset00"):
        pytest.skip("stands upright, where roll and heading are not defined")
    names = OUTPUTS[:11]
    condition = TrimCondition.from_file(file, aircraft, mode="none")
    plane = JSBSimFDM(aircraft_model=aircraft, condition=condition, output_properties=names)
    fdm = open_fdm(aircraft, 1 / 120)
    fdm.load_ic(file, True)
    away = plane.outputs.to_array() - rows_from_start(fdm, names, 0.0, trims=False)[0]
    away[-1] = (away[-1] + np.pi) % (2 * np.pi) - np.pi
    np.testing.assert_allclose(away, 0.0, atol=1e-7)


@pytest.mark.parametrize("values", [{}, {"mode": "none"}])
def test_what_is_that_of_the_file_is_not_changed(values):
    assert TrimCondition.from_file("reset01", "c172x", **values).mode == "none"
    with pytest.raises(ParameterError, match="altitude is that of the file"):
        TrimCondition.from_file("reset01", "c172x", altitude=3000.0, **values)


def test_a_file_that_asks_for_a_trim_gives_its_mode():
    assert TrimCondition.from_file("reset00", "737").mode == "ground"
    assert TrimCondition.from_file("reset00", "737", mode="none").mode == "none"


FUNCTION = "<function><product><property>a/b</property><value>1</value></product></function>"

# text of the file, and what the message names
SCRIPTS = {
    "wrong root": ("<initialize/>", "is a reset file .*, not a script: JSBSimFDM"),
    "an aircraft": ("<fdm_config/>", "is an aircraft .*, not a script"),
    "another root": ("<note/>", "is no file of JSBSim's .<note>.*script needs <runscript>"),
    "not XML": ("<runscript", "not well-formed"),
    "no run": ('<runscript><use aircraft="c172x" initialize="reset00"/></runscript>', "<run>"),
    "no use": ('<runscript><run start="0" end="1" dt="0.01"/></runscript>', "<use"),
}
# parts of a script, and what the message names
PARTS = {
    "dt 0": ({"dt": "0"}, "a step of 0 s"),
    "dt fast": ({"dt": "fast"}, "'fast' as dt"),
    "end early": ({"start": "5", "end": "1"}, "ends at 1 s, before its start at 5 s"),
    "no value": ({"events": event('<set name="fcs/elevator-cmd-norm"/>')}, "no value"),
    "no name": ({"events": event('<set value="1"/>')}, "without a name in event 'e'"),
    "value up": ({"events": event(put("fcs/elevator-cmd-norm", "up"))}, "t.xml:.*up"),
    "no condition": ({"events": '<event name="a"/>'}, "No condition .*event a"),
    "comparison is": ({"events": event("", "simulation/sim-time-sec is 1")}, '"is"'),
    "pause": ({"events": event(put("simulation/pause", 1))}, "simulation/pause in event 'e'"),
    "linearise": ({"events": event(put("simulation/do_linearization", 1))}, "allow_files"),
    "in condition": ({"events": event("", "velocities/vc-ktz ge 50")}, "vc-kts.*event 'e' of t"),
    "in set": ({"events": event(put("fcs/elevator-cmd-nrm", 1))}, "elevator-cmd-norm.*event 'e'"),
    "in function": (
        {"events": event(f'<set name="fcs/elevator-cmd-norm">{FUNCTION}</set>')},
        "'a/b' in event 'e' of t.xml",
    ),
    "injection": ({"events": event(put("propulsion/engine/injection_cmd", 1))}, "injection"),
    "malformed set": ({"events": event(put("fcs/a b", 1))}, "fcs/a b"),
    "malformed condition": ({"events": event("", "fcs/1a:b ge 50")}, "t.xml"),
    "malformed declared": ({"events": '<property value="1">a b[x]</property>'}, "t.xml"),
    "declared word": ({"events": '<property value="one">own</property>'}, "'one' as own"),
}
IN_FLIGHT = {
    "trim fails": (put("simulation/do_simple_trim", 1), "t.xml: Trim Failed"),
    "trim 77": (put("simulation/do_simple_trim", 77), "t.xml"),
    "engine 9": (put("propulsion/set-running", 9), "non-existent engine"),
}


@pytest.mark.parametrize("case", SCRIPTS)
def test_a_file_that_is_no_script_is_refused(tmp_path, case):
    text, why = SCRIPTS[case]
    file = tmp_path / "t.xml"
    file.write_text(text)
    with pytest.raises(ParameterError, match=why) as caught:
        JSBSimFDM(script=str(file))
    assert caught.value.parameter == "script"
    assert "t.xml" in str(caught.value)


@pytest.mark.parametrize("case", PARTS)
def test_a_bad_part_of_a_script_is_refused_before_the_flight(tmp_path, monkeypatch, case):
    parts, why = PARTS[case]
    script = written(tmp_path, **parts)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(BlocksError, match=why) as caught:
        JSBSimFDM(script=script)
    assert "t.xml" in str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == ["t.xml"]


@pytest.mark.parametrize("case", IN_FLIGHT)
def test_an_event_that_fails_ends_the_flight(tmp_path, case):
    sets, why = IN_FLIGHT[case]
    plane = JSBSimFDM(script=written(tmp_path, event(sets)))
    with pytest.raises(FlightError, match=why) as caught:
        Simulation([plane], dt=plane.T, log=False).run(2.0)
    assert caught.value.time == pytest.approx(0.99)


def test_unknown_files_are_refused_with_the_nearest(tmp_path, monkeypatch):
    with pytest.raises(ParameterError, match=r"no script 'scripts/c1773\.xml'.*scripts/c172"):
        JSBSimFDM(script="scripts/c1773.xml")
    beside = written(tmp_path)
    # as it would be written
    with pytest.raises(ParameterError, match=f"did you mean '{beside}'"):
        JSBSimFDM(script=beside.replace("t.xml", "tt.xml"))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ParameterError, match=r"did you mean 't\.xml'"):
        JSBSimFDM(script="tt.xml")
    with pytest.raises(ParameterError, match=r"no reset file 'reset77'.*reset0"):
        JSBSimFDM(aircraft_model="c172x", initialize="reset77")
    with pytest.raises(ParameterError, match=r"no reset file 'crise_init'.*cruise_init"):
        TrimCondition.from_file("crise_init", "737")
    text = SCRIPT.format(start="0", end="1", dt="0.01", events="", more="")
    file = tmp_path / "t.xml"
    file.write_text(text.replace("reset00", "reset77"))
    with pytest.raises(ParameterError, match=r"t\.xml.*no reset file 'reset77'.*reset0"):
        JSBSimFDM(script=str(file))
    file.write_text(text.replace("c172x", "c172z"))
    with pytest.raises(BlocksError, match=r"t\.xml.*no aircraft 'c172z'.*c172x"):
        JSBSimFDM(script=str(file))


def test_a_script_of_another_root_names_it(tmp_path):
    (tmp_path / "aircraft" / "own").mkdir(parents=True)
    (tmp_path / "scripts").mkdir()
    script = written(tmp_path / "scripts").replace("\\", "/")
    text = (tmp_path / "scripts" / "t.xml").read_text()
    (tmp_path / "scripts" / "t.xml").write_text(text.replace("c172x", "own"))
    with pytest.raises(BlocksError, match=f"JSBSim root is '{tmp_path}'"):
        JSBSimFDM(script=script)


def test_a_property_that_is_only_reported_is_a_warning(tmp_path):
    notice = "<notify><property>velocities/vcc</property></notify>"
    script = written(tmp_path, event("", more=notice))
    with pytest.warns(RuntimeWarning, match="event 'e' of t.xml reports 'velocities/vcc'"):
        plane = JSBSimFDM(script=script)
    with pytest.raises(FlightError, match="velocities/vcc"):
        Simulation([plane], dt=plane.T, log=False).run(2.0)


RESETS = {
    "version 3": ('<initialize version="3"/>', "formats 1 and 2"),
    "number": ("<initialize><altitude>high</altitude></initialize>", "high"),
    "not XML": ("", "not well-formed"),
    "latitude": ('<initialize><latitude unit="DEG">100</latitude></initialize>', "latitude"),
    "unit": ('<initialize><altitude unit="PARSEC">1</altitude></initialize>', "PARSEC"),
    "root": ("<runscript/>", "a script"),
    "no position": ('<initialize version="2.0"/>', "position"),
}


@pytest.mark.parametrize("case", RESETS)
def test_a_bad_reset_file_is_refused(tmp_path, case):
    text, why = RESETS[case]
    file = tmp_path / "start.xml"
    file.write_text(text)
    for read in (
        lambda: JSBSimFDM(aircraft_model="c172x", initialize=str(file)),
        lambda: TrimCondition.from_file(file, "c172x"),
    ):
        with pytest.raises(BlocksError, match=why) as caught:
            read()
        assert "start.xml" in str(caught.value)


def test_files_and_sockets_of_a_script_need_permission(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    more = (
        '<output name="o.csv" type="CSV" rate="100"><property>fcs/rudder-cmd-norm</property>'
        "</output>"
        '<output name="localhost" type="SOCKET" protocol="TCP" port="59991" rate="1"/>'
        '<input port="59992"/>'
    )
    events = event(put("simulation/write-state-file", 2) + put("fcs/rudder-cmd-norm", 0.5))
    script = written(tmp_path, events, more=more)
    plane = JSBSimFDM(script=script)
    Simulation([plane], dt=plane.T, log=False).run(1.5)
    assert [p.name for p in tmp_path.iterdir()] == ["t.xml"]
    plane = JSBSimFDM(script=script, allow_files=True)
    Simulation([plane], dt=plane.T, log=False).run(1.5)
    rows = (tmp_path / "o.csv").read_text().splitlines()
    # from the start on, as in JSBSim
    assert rows[1].startswith("0,")
    assert len(rows) == 1 + 151
