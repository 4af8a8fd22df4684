"""Named points of a model, against the numbers in its XML."""

import xml.etree.ElementTree as ET

import jsbsim
import pytest

from pathsim_jsbsim_blocks.axes.points import aircraft_points
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.flight.airframe import Airframe


@pytest.fixture(scope="module")
def points():
    airframe = Airframe("c172p")
    airframe.run_ic()
    return aircraft_points(airframe)


def xml_points(path, kind):
    model = ET.parse(f"{jsbsim.get_default_root_dir()}/aircraft/c172p/c172p.xml").getroot()
    for item in model.iterfind(path):
        if kind in (None, item.get("name"), item.get("type")):
            location = item if item.tag == "location" else item.find("location")
            assert location.get("unit") == "IN"
            yield tuple(float(location.findtext(axis)) for axis in "xyz")


@pytest.mark.parametrize(
    ("kind", "path", "name"),
    [
        ("empty-weight CG", "mass_balance/location", "CG"),
        ("aerodynamic reference point", "metrics/location", "AERORP"),
        ("eye point", "metrics/location", "EYEPOINT"),
        ("visual reference point", "metrics/location", "VRP"),
        ("wheels", "ground_reactions/contact", "BOGEY"),
        ("other contact points", "ground_reactions/contact", "STRUCTURE"),
        ("point masses", "mass_balance/pointmass", None),
        ("tanks", "propulsion/tank", None),
    ],
)
def test_points_are_those_of_the_models_xml(points, kind, path, name):
    assert points[kind] == [pytest.approx(p) for p in xml_points(path, name)]


def test_the_cg_lies_between_the_loads(points):
    # 1500 lb empty, 180 lb of pilot and 200 lb of fuel: the sum of moments over the sum of weights
    ((x, y, z),) = points["centre of gravity"]
    loads = [
        (1500.0, points["empty-weight CG"][0]),
        (180.0, points["point masses"][0]),
        (100.0, points["tanks"][0]),
        (100.0, points["tanks"][1]),
    ]
    for found, axis in ((x, 0), (y, 1), (z, 2)):
        assert found == pytest.approx(sum(w * p[axis] for w, p in loads) / 1880.0)


def test_the_command_draws_them(tmp_path, capsys):
    figure = tmp_path / "points.png"
    assert main(["aircraft", "c172p", "--points", str(figure)]) == 0
    assert figure.stat().st_size > 10_000
    assert "aerodynamic reference point" in capsys.readouterr().out
    assert main(["aircraft", "--points", str(figure)]) == 1
