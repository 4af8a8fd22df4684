"""The law as JSBSim XML: it flies what the block flies, bit for bit."""

from __future__ import annotations

import dataclasses
import re
import tempfile

import numpy as np
import pytest
from flights import POINTS
from how_many import first
from xml_flights import both, during, in_jsbsim, step

from pathsim_jsbsim_blocks import (
    Actuator,
    Aircraft,
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    CourseHold,
    DiscretePID,
    GlideslopeHold,
    HeadingHold,
    ParameterError,
    PitchHold,
    RollHold,
    YawDamper,
)
from pathsim_jsbsim_blocks._core.aircraft_ports import OUTPUTS
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.control import holds
from pathsim_jsbsim_blocks.control.controller import Hold
from pathsim_jsbsim_blocks.control.gain_tables import table, tables
from pathsim_jsbsim_blocks.errors import FileError
from pathsim_jsbsim_blocks.flight.fleet import prepared

HOLDS = [
    (PitchHold, {"theta_ref": step(4.0, 0.5)}),
    (RollHold, {"phi_ref": step(20.0, 0.5), "off": during(1.0, 1.5)}),
    (HeadingHold, {"psi_ref": step(-20.0, 0.5)}),  # through north
    (AltitudeHold, {"h_ref": step(100.0, 0.5)}),
    (AirspeedHold, {"vc_ref": step(-8.0, 0.5)}),
    (YawDamper, {}),
]
REFUSED = [CourseHold, GlideslopeHold]
LAWS = [Actuator, Autopilot, DiscretePID, *(getattr(holds, name) for name in holds.__all__)]
LAWS = [kind for kind in LAWS if kind not in REFUSED]
MODES = {
    "h_ref": step(200.0, 0.5),
    "psi_ref": step(20.0, 0.5),
    "vc_ref": step(-10.0, 1.0),
    "theta_ref": step(2.0, 1.5),
    "pitch_mode": during(1.5, 2.5),
    "roll_mode": during(2.0, 2.5),
    "speed_off": step(1.0, 2.5),
}


def start(name, **options):
    return {"aircraft": name, **POINTS[name], **options}


@pytest.mark.parametrize(("kind", "ports"), HOLDS, ids=lambda x: getattr(x, "__name__", ""))
def test_a_hold_flies_in_jsbsim_what_it_flies_in_pathsim(kind, ports, tmp_path):
    flown, alone = both(lambda: kind("c172p"), start("c172p", heading=2.0), 3.0, ports, tmp_path)
    assert np.ptp(flown[:, -1]) > 0.01
    assert np.array_equal(alone, flown)


@pytest.mark.parametrize(("name", "gains"), first([("737", "737-designed"), ("c172p", "c172p")]))
def test_an_autopilot_on_a_schedule_and_protected_does(name, gains, tmp_path):
    flown, alone = both(lambda: Autopilot(gains), start(name), 4.0, MODES, tmp_path)
    assert (np.ptp(flown[:, -4:], axis=0) > 0.01).all()
    assert np.array_equal(alone, flown)


def whole_flight(seconds):
    """A step of every mode, spread over a flight."""
    at = seconds / 12.0
    return {
        "h_ref": step(200.0, at),
        "psi_ref": step(-25.0, 2.0 * at),
        "vc_ref": step(-5.0, 3.0 * at),
        "pitch_mode": during(5.0 * at, 7.0 * at),
        "theta_ref": step(2.0, 6.0 * at),
        "roll_mode": during(6.0 * at, 8.0 * at),
        "phi_ref": step(15.0, 7.0 * at),
        "speed_off": during(8.0 * at, 8.0 * at + 1.0),
        "yaw_off": during(8.5 * at, 8.5 * at + 1.0),
        "pitch_off": during(9.0 * at, 9.0 * at + 1.0),
        "roll_off": during(9.2 * at, 9.2 * at + 1.0),
    }


def nominal_flight(name):
    """The aircraft of a table at its nominal point."""
    schedule = table(name)
    point = schedule.points[schedule.nominal]
    _, create, clean = prepared(schedule.aircraft)
    place = {"altitude": point.altitude, "speed": point.speed}
    if name.endswith("-landing"):
        place |= {"flaps": 1.0, "gear": 1.0}
    condition = dataclasses.replace(clean, **place, solver="newton")
    return {"aircraft": schedule.aircraft, "condition": condition, "create": create}


@pytest.mark.long
@pytest.mark.parametrize("name", tables())
def test_every_table_flies_in_jsbsim_as_in_pathsim(name, tmp_path):
    seconds, flight = 40.0, nominal_flight(name)
    modes = whole_flight(seconds)
    flown, alone = both(lambda: Autopilot(name), flight, seconds, modes, tmp_path)
    assert len(flown) == round(seconds * 120) + 1
    assert np.array_equal(alone, flown)


def test_a_law_may_sample_less_often_than_jsbsim_steps(tmp_path):
    flight = start("c172p", T=1 / 60, substeps=2)
    make = lambda: AltitudeHold("c172p", T=1 / 30)  # noqa: E731
    flown, alone = both(make, flight, 3.0, {"h_ref": step(100.0, 0.5)}, tmp_path)
    assert len(np.unique(flown[:, -1])) <= len(flown) / 2 + 1
    assert np.array_equal(alone, flown)


MEASURED = {name: found for name, found in OUTPUTS.items() if found[0]}
MEASURED |= {"h_agl": ("position/h-agl-ft", 1.0), "wow": ("gear/wow", 1.0)}


@pytest.mark.parametrize("kind", LAWS, ids=lambda kind: kind.__name__)
def test_a_law_of_any_block_computes_the_same(kind, tmp_path):
    block = kind("737-designed") if issubclass(kind, Hold) else kind()
    file = tmp_path / "law.xml"
    file.write_text(block.to_jsbsim_xml("law", engines=2), encoding="utf-8")
    plane = Aircraft(**start("737"), systems=[str(file)])
    fdm, rng, state = plane.fdm, np.random.default_rng(4), block.initial_state()
    fdm["ap/pathsim/law/engaged"] = 1.0
    nodes = plane.airframe.property_names("ap/pathsim/law/")

    def own(port, given=""):
        name = f"ap/pathsim/law/{given}{port.replace('_', '-')}"
        return min((n for n in nodes if re.fullmatch(f"{name}(-[a-z_]+)?", n)), key=len)

    for _ in range(60):
        u = []
        for port in block.input_port_labels:
            if port in MEASURED and issubclass(kind, Hold):
                name, factor = MEASURED[port]
                u.append(fdm[name] * factor)
            elif port.endswith("_sat"):
                u.append(fdm[own(port)])
            else:
                u.append(float(rng.normal() * (rng.random() < 0.7)))
                fdm[own(port, "given-" * (port in block.output_port_labels))] = u[-1]
        outputs, state = block.law(u, state)
        fdm.run()
        assert [fdm[own(port)] for port in block.output_port_labels] == outputs


def test_the_reference_of_a_pid_is_no_yaw_rate(tmp_path):
    file = tmp_path / "pid.xml"
    file.write_text(DiscretePID(Kp=0.5).to_jsbsim_xml("pid"), encoding="utf-8")
    fdm = Aircraft(**start("c172p"), systems=[str(file)]).fdm
    fdm["ap/pathsim/pid/engaged"], fdm["ap/pathsim/pid/r"] = 1.0, 0.8
    fdm.run()
    assert fdm["ap/pathsim/pid/u"] == 0.4


def test_it_captures_the_commands_at_engagement(tmp_path):
    file = tmp_path / "pitch.xml"
    file.write_text(PitchHold("c172p").to_jsbsim_xml(), encoding="utf-8")
    engaged = "ap/pathsim/pitch-hold/engaged"
    plane = Aircraft(**start("c172p"), systems=[str(file)], input_properties=[engaged])
    fdm = plane.fdm
    fdm["fcs/elevator-cmd-norm"] = -0.05
    for _ in range(60):
        fdm.run()
    assert fdm["fcs/elevator-cmd-norm"] == -0.05
    fdm[engaged] = 1.0
    fdm.run()
    # the increment starts at 0
    assert fdm["fcs/elevator-cmd-norm"] == pytest.approx(-0.05, abs=1e-12)
    theta = fdm["ap/pathsim/pitch-hold/theta-cmd-deg"]
    for _ in range(1200):
        fdm.run()
    assert fdm["attitude/theta-deg"] == pytest.approx(theta, abs=0.05)
    fdm[engaged] = 0.0
    fdm.run()
    fdm["fcs/elevator-cmd-norm"] = 0.3
    fdm.run()
    assert fdm["fcs/elevator-cmd-norm"] == 0.3


def test_a_step_that_does_not_divide_the_period_leaves_it_inactive(tmp_path):
    block = PitchHold("c172p", T=1 / 120)
    flight = start("c172p", T=1 / 100)
    rows = in_jsbsim(block, flight, 0.5, {}, tmp_path)
    assert not rows[:, -1].any()


def low_flight(file, seconds=20.0, **how):
    """Height above the ground after an autopilot is told to go from 200 to 50 ft."""
    file.write_text(Autopilot("c172p-designed").to_jsbsim_xml("ap", **how), encoding="utf-8")
    properties = {"ap/pathsim/ap/engaged": 1.0, "ap/pathsim/ap/h-ref-ft": -150.0}
    plane = Aircraft("c172p", altitude=200, speed=90, systems=[str(file)], properties=properties)
    for _ in range(round(seconds * 120)):
        plane.fdm.run()
    return plane.fdm["position/h-agl-ft"]


def test_the_ground_protects_unless_its_port_is_left_unwired(tmp_path):
    assert low_flight(tmp_path / "a.xml") > 95.0
    assert low_flight(tmp_path / "a.xml", unwired=["h_agl"]) == pytest.approx(50.0, abs=10.0)
    for wrong in ("h_agl", ["h_alg"]):
        with pytest.raises(ParameterError, match="h_agl"):
            Autopilot().to_jsbsim_xml(unwired=wrong)


@pytest.mark.parametrize("kind", LAWS, ids=lambda kind: kind.__name__)
def test_any_input_can_be_left_unwired(kind, tmp_path):
    block, file = kind(), tmp_path / "law.xml"
    text = block.to_jsbsim_xml("law", unwired=list(block.input_port_labels))
    file.write_text(text, encoding="utf-8")
    plane = Aircraft(**start("c172p"), systems=[str(file)])
    fdm, state = plane.fdm, block.initial_state()
    fdm["ap/pathsim/law/engaged"] = 1.0
    for _ in range(5):
        outputs, state = block.law([0.0] * len(block.input_port_labels), state)
        fdm.run()
    nodes = plane.airframe.property_names("ap/pathsim/law/")
    for port, value in zip(block.output_port_labels, outputs, strict=True):
        name = f"ap/pathsim/law/{port.replace('_', '-')}"
        node = min((n for n in nodes if re.fullmatch(f"{name}(-[a-z_]+)?", n)), key=len)
        assert fdm[node] == value


def test_absolute_references_begin_at_the_parameters(tmp_path):
    file = tmp_path / "a.xml"
    block = AltitudeHold("c172p", h_ref=5040.0, reference="absolute")
    file.write_text(block.to_jsbsim_xml("law"), encoding="utf-8")
    fdm = Aircraft(**start("c172p", altitude=5000), systems=[str(file)]).fdm
    fdm["ap/pathsim/law/engaged"] = 1.0
    for _ in range(30 * 120):
        fdm.run()
    assert fdm["position/h-sl-ft"] == pytest.approx(5040.0, abs=10.0)


@pytest.mark.parametrize("kind", REFUSED)
def test_what_has_no_place_in_xml_is_refused_by_name(kind):
    with pytest.raises(ParameterError, match=kind.__name__):
        kind().to_jsbsim_xml()


@pytest.mark.parametrize("name", ["", "Pitch Hold", "a--b", "a/b", "-a", 3])
def test_a_name_that_makes_no_property_is_refused(name):
    with pytest.raises(ParameterError, match="small letters"):
        PitchHold().to_jsbsim_xml(name)


def test_an_aircraft_with_a_system_is_sealed_and_leaves_nothing(tmp_path, monkeypatch):
    # this model asks for a CSV file
    file, empty = tmp_path / "roll.xml", tmp_path / "empty"
    empty.mkdir()
    file.write_text(RollHold("c172p").to_jsbsim_xml(), encoding="utf-8")
    monkeypatch.chdir(empty)
    monkeypatch.setattr(tempfile, "tempdir", str(empty))
    plane = Aircraft("c172x", altitude=5000, speed=90, systems=[str(file)])
    before = plane.fdm["position/h-sl-ft"]
    plane.reset()
    assert plane.fdm["position/h-sl-ft"] == before
    plane.fdm["ap/pathsim/roll-hold/engaged"] = 1.0
    for _ in range(120):
        plane.fdm.run()
    assert plane.fdm["ap/pathsim/roll-hold/active"] == 1.0
    assert list(empty.iterdir()) == []
    assert main(["properties", "c172x", "pathsim"]) != 0  # the installed model is as it was


def test_a_file_that_is_no_system_is_refused(tmp_path):
    file = tmp_path / "a.xml"
    with pytest.raises(FileError, match=r"a\.xml"):
        Aircraft("c172p", systems=[str(file)])
    for text, why in (("<system>", "well-formed"), ("<output/>", "<output>, not a <system>")):
        file.write_text(text)
        with pytest.raises(ParameterError, match=why):
            Aircraft("c172p", systems=[str(file)])
    file.write_text('<system file="b"/>')
    with pytest.raises(ParameterError, match="includes 'b'"):
        Aircraft("c172p", systems=[str(file)])
    other = tmp_path / "b.xml"
    file.write_text(PitchHold().to_jsbsim_xml("ap"))
    other.write_text(RollHold().to_jsbsim_xml("ap"))
    # laws that share properties would count each frame twice
    for second in (file, other):
        with pytest.raises(ParameterError, match="second system with the name 'ap/pathsim/ap'"):
            Aircraft("c172p", systems=[str(file), str(second)])
    with pytest.raises(ParameterError, match="list of XML files"):
        Aircraft("c172p", systems=str(file))


def test_the_command_writes_the_autopilot_of_a_table(tmp_path, capsys):
    file = tmp_path / "a4.xml"
    assert main(["gains", "A4", "--table", "--xml", str(file)]) == 0
    assert "10000 ft" in capsys.readouterr().out
    assert file.read_text(encoding="utf-8") == Autopilot("A4").to_jsbsim_xml()
    assert main(["gains", "A4", "--table", "--xml", str(file), "--flaps", "1"]) != 0
    assert "--table takes no --flaps" in capsys.readouterr().err
