"""An aircraft's own control system, listed and drawn."""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ET

import pytest

from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.errors import AircraftError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names
from pathsim_jsbsim_blocks.flight.control_system import Component, control_system

SVG = "{http://www.w3.org/2000/svg}"


def test_the_channels_of_a_c172p_are_those_of_its_file():
    pitch, roll, yaw, flaps = control_system("c172p")
    assert [c.name for c in (pitch, roll, yaw, flaps)] == ["Pitch", "Roll", "Yaw", "Flaps"]
    assert pitch.section == "flight_control"
    assert pitch.components[:2] == (
        Component(
            "summer",
            "Pitch Trim Sum",
            ("fcs/elevator-cmd-norm", "fcs/pitch-trim-cmd-norm"),
            ("fcs/pitch-trim-sum",),
        ),
        Component(
            "aerosurface_scale",
            "Elevator Control",
            ("fcs/pitch-trim-sum",),
            ("fcs/elevator-control", "fcs/elevator-pos-rad"),
        ),
    )


@pytest.mark.parametrize("aircraft", ["737", "A4", "c172p", "f15"])
def test_what_is_listed_is_there_in_flight(aircraft):
    airframe = Airframe(aircraft)
    airframe.run_ic()
    channels = control_system(aircraft)
    components = [c for channel in channels for c in channel.components]
    assert len(components) > 10
    for name in (name for c in components for name in (*c.inputs, *c.outputs)):
        assert airframe.has(name), name


def test_systems_in_files_of_their_own_are_read_and_all_models_can_be():
    # the f16's hook is in the folder systems of jsbsim, its pushback too
    assert {"Hook", "Pushback"} <= {channel.name for channel in control_system("f16")}
    for aircraft in aircraft_names():
        control_system(aircraft)
    with pytest.raises(AircraftError, match="c172p"):
        control_system("c172")


@pytest.mark.parametrize("aircraft", ["c172p", "f16"])
def test_the_picture_has_every_component_and_none_covers_another(aircraft, tmp_path, capsys):
    file = tmp_path / "own.svg"
    assert main(["systems", aircraft, "--save", str(file)]) == 0
    printed = capsys.readouterr().out
    root = ET.parse(file).getroot()
    width, height = float(root.get("width")), float(root.get("height"))
    wanted = [c for channel in control_system(aircraft) for c in channel.components]
    shown = [text.text for text in root.iter(f"{SVG}text") if text.get("class") == "type"]
    assert sorted(shown) == sorted(c.type for c in wanted)
    for component in wanted:
        assert f"  {component.type} {component.name!r}: " in printed
    for part in root.iter(f"{SVG}g"):
        x0, y0 = map(float, part.get("transform")[10:-1].split(","))
        boxes = [
            [float(box.get(name)) for name in ("x", "y", "width", "height")]
            for box in part.iter(f"{SVG}rect")
        ]
        for x, y, w, h in boxes:
            assert x0 + x >= 0
            assert x0 + x + w <= width
            assert 0 <= y0 + y <= height - h
        for (xa, ya, wa, ha), (xb, yb, wb, hb) in itertools.combinations(boxes, 2):
            assert xa + wa <= xb or xb + wb <= xa or ya + ha <= yb or yb + hb <= ya
