"""The first look at a model: of all that are bundled, and of models as other people have them."""

import math
import re
from pathlib import Path

import pytest
from models_from_outside import (
    before,
    changed,
    electric_single,
    electric_twin,
    lever_writes_throttle,
    without_contents,
    without_pitch_command,
)

from pathsim_jsbsim_blocks import AircraftError, ParameterError
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names
from pathsim_jsbsim_blocks.studies import aircraft_report


def subjects(report):
    return [fault.subject for fault in report.faults]


def on_one_screen(report):
    lines = str(report).splitlines()
    return len(lines) <= 40 and max(map(len, lines)) <= 100


def test_a_good_model_has_no_fault():
    report = aircraft_report("c172p")
    assert report.loads
    assert report.faults == ()
    assert [(e.type, e.thruster, e.tanks) for e in report.engines] == [
        ("piston", "propeller", (0, 1))
    ]
    # as its file says
    assert report.tanks == (100.0, 100.0)
    assert not report.retracts
    assert not report.missing
    assert not report.sealed
    assert report.trim.steady
    assert report.method == "flown"
    assert {"short period", "phugoid", "Dutch roll"} <= {mode.name for mode in report.modes}
    # forward by the throttle; nose down, right and left by positive commands (docs/conventions.md)
    signs = {effect.command: math.copysign(1.0, effect.size) for effect in report.effects}
    assert signs == {"throttle": 1.0, "pitch": -1.0, "roll": 1.0, "yaw": -1.0}
    assert on_one_screen(report)


def test_a_ball_has_no_effect_trim_or_gains(capsys):
    report = aircraft_report("ball")
    assert report.loads
    assert report.engines == ()
    assert report.trim is None
    assert [effect.moves for effect in report.effects] == [False] * 3
    assert subjects(report) == ["commands", "trim"]
    assert report.method == ""
    assert main(["aircraft", "ball"]) == 0
    assert capsys.readouterr().out == f"{report}\n"
    assert on_one_screen(report)


def test_a_model_that_does_not_load_has_a_report(tmp_path, capsys):
    report = aircraft_report("blank")
    assert not report.loads
    assert subjects(report) == ["model"]
    root = changed(tmp_path, "c172x", ("</fdm_config>", ""))
    assert subjects(aircraft_report("c172x", root)) == ["model"]
    assert main(["aircraft", "blank"]) == 1
    assert capsys.readouterr().out == f"{report}\n"
    assert main(["aircraft", "c172q"]) == 1
    assert "'c172x'" in capsys.readouterr().err
    with pytest.raises(AircraftError) as refused:
        aircraft_report("c172q")
    assert "c172x" in refused.value.nearest


@pytest.mark.long
def test_empty_tanks_are_a_fault_and_the_rest_is_of_half_full_ones(tmp_path):
    report = aircraft_report("c172x", without_contents(tmp_path))
    assert report.tanks == (0.0, 0.0)
    assert subjects(report)[0] == "fuel"
    # of 130 lb, as the file says
    assert report.condition.setup["propulsion/tank[0]/contents-lbs"] == 65.0
    assert report.trim.steady


@pytest.mark.long
def test_properties_from_outside_are_named_and_the_rest_is_with_zeros(tmp_path):
    force = (
        '<axis name="SIDE"><function name="aero/x"><property>outside/a</property></function></axis>'
    )
    root = changed(tmp_path, "c172p", before("axis", force))
    report = aircraft_report("c172p", root)
    assert report.missing == ("outside/a",)
    assert subjects(report) == ["properties"]
    assert report.trim.steady
    report = aircraft_report("c172p", root, create={"outside/a": 0.0})
    assert report.missing == ()
    assert report.faults == ()


@pytest.mark.long
def test_created_zeros_that_change_something_at_1_are_named(tmp_path):
    # 342 lbf of drag at 1
    drag = """<function name="aero/outside"><product><value>342</value><property>outside/a
    </property></product></function>"""
    axis = '<axis name="DRAG">'
    still = """<system name="s"><channel name="c"><pure_gain name="x/f"><input>outside/b</input>
    <gain>1</gain></pure_gain></channel></system>"""
    root = changed(tmp_path, "c172p", (axis, axis + drag), before("aerodynamics", still))
    report = aircraft_report("c172p", root)
    reason = report.faults[0].reason
    assert report.missing == ("outside/b", "outside/a")
    assert "outside/b at 1" not in reason
    change = re.search(r"outside/a at 1 changes udot by (\S+) ft/s2", reason)
    assert float(change[1]) == pytest.approx(-342 / report.trim.weight * 32.174, rel=0.01)


@pytest.mark.long
def test_what_jsbsim_finds_only_when_it_initialises_is_created_too(tmp_path):
    system = """<system name="late"><channel name="late"><switch name="late/a">
    <default value="0"/><test logic="AND" value="1">
    sim-time-sec le 30
    /engines/engine[1]running == 0
    </test></switch></channel></system>"""
    root = changed(tmp_path, "c172p", ("</fdm_config>", system + "</fdm_config>"))
    report = aircraft_report("c172p", root)
    assert report.missing == ("sim-time-sec", "/engines/engine[1]running")
    assert subjects(report) == ["properties"]
    with pytest.warns(RuntimeWarning, match=r"engine\[1\]running"):
        airframe = Airframe("c172p", root=root, create={"missing": True, "sim-time-sec": 3.0})
    assert airframe.created == {"sim-time-sec": 3.0, "/engines/engine[1]running": 0.0}
    for fresh in (airframe, airframe.twin()):
        fresh.run_ic()


@pytest.mark.long
def test_an_unstable_aircraft_is_not_steady(tmp_path):
    # the pitching moment grows with the angle of attack, instead of falling
    slope = r"(aero/alpha-rad</property>\s*<value>)-1.8", r"\g<1>0.8"
    root = changed(tmp_path, "c172p", slope)
    report = aircraft_report("c172p", root)
    assert report.trim.steady
    modes = [mode for mode in report.modes if mode.name == "short period"]
    doubles = min(mode.time_to_double for mode in modes if mode.pole.real > 0.0)
    assert doubles < 4.0
    [fault] = [fault for fault in report.faults if fault.subject == "hands off"]
    assert f"short period doubles in {doubles:.3g} s" in fault.reason
    assert "hands off  not steady: after 10 s" in str(report)


def test_an_impossible_property_to_create_is_refused_and_is_no_fault_of_the_model():
    with pytest.raises(ParameterError) as error:
        aircraft_report("c172p", create={"outside/a": "high"})
    assert error.value.parameter == "create['outside/a']"


def test_a_reversed_aileron_is_a_fault_and_no_gains_are_offered(tmp_path):
    command = r"<input>\s*fcs/aileron-cmd-norm\s*</input>", "<input>-fcs/aileron-cmd-norm</input>"
    report = aircraft_report("c172p", changed(tmp_path, "c172p", command))
    assert subjects(report) == ["signs"]
    assert report.effects[2].size < 0.0
    assert report.trim.steady
    assert not any("pathsim-jsbsim gains" in line for line in str(report).splitlines())


def test_sockets_and_files_that_are_closed_to_it(tmp_path):
    elements = (
        '<output name="127.0.0.1" type="SOCKET" protocol="UDP" port="5999" rate="1"/>'
        '<output name="log.csv" type="CSV" rate="1"/><input port="5998"/>'
    )
    report = aircraft_report(
        "ball", changed(tmp_path, "ball", ("</fdm_config>", elements + "</fdm_config>"))
    )
    ports = [text for text in report.sealed if "599" in text]
    assert len(ports) == 2
    assert any("log.csv" in text for text in report.sealed)


@pytest.mark.long
def test_commands_without_effect_are_faults(tmp_path):
    report = aircraft_report("c172x", lever_writes_throttle(tmp_path / "a"))
    throttle = report.effects[0]
    assert throttle.written_by_model
    assert not throttle.moves
    assert subjects(report) == ["commands", "trim"]
    report = aircraft_report("c172x", without_pitch_command(tmp_path / "b"))
    assert [e.command for e in report.effects if not e.moves] == ["pitch"]


@pytest.mark.long
@pytest.mark.parametrize("make", [electric_single, electric_twin])
def test_electric_aircraft_trim_and_stay(make, tmp_path):
    report = aircraft_report("c310" if make is electric_twin else "c172x", make(tmp_path))
    assert {engine.type for engine in report.engines} == {"electric"}
    assert report.trim.steady
    assert report.method


@pytest.mark.long
@pytest.mark.parametrize("aircraft", aircraft_names())
def test_each_bundled_model_has_a_report(aircraft):
    report = aircraft_report(aircraft)
    assert on_one_screen(report)
    assert report.loads == (aircraft not in ("blank",))
    assert (report.trim is None) == ("trim" in subjects(report) or not report.loads)
    if report.trim is not None:
        assert report.trim.steady or "hands off" in subjects(report)
        assert report.method or "linear model" in subjects(report)


@pytest.mark.parametrize(
    ("change", "faults"),
    [
        # it does not load
        (("<mass_balance>.*</mass_balance>", ""), ["model"]),
        (('<engine file="[^"]*"', '<engine file="none_such"'), ["model"]),
        (("<aerodynamics>.*</aerodynamics>", ""), ["model"]),
        (("<retractable>.*?</retractable>", "<retractable>yes</retractable>"), ["model"]),
        (("^.*$", "text"), ["model"]),
        # it loads: without wing area, controls, and room in its tanks
        (("<wingarea.*?</wingarea>", ""), ["commands", "trim"]),
        (("<flight_control.*</flight_control>", "<flight_control/>"), ["commands", "trim"]),
        (("(<(capacity|contents) .*?>).*?<", r"\g<1>0<"), ["fuel", "trim"]),
    ],
)
def test_a_model_without(change, faults, tmp_path):
    report = aircraft_report("c172p", changed(tmp_path, "c172p", change))
    assert report.loads == ("model" not in faults)
    assert subjects(report) == faults
    assert report.trim is None
    assert on_one_screen(report)


@pytest.mark.long
def test_the_report_on_the_page_is_the_one_of_today():
    page = Path(__file__).parents[2] / "docs" / "models-from-elsewhere.md"
    assert f"```\n{aircraft_report('c172x')}\n```" in page.read_text(encoding="utf-8")
