"""All scripts that jsbsim brings, flown by the block beside plain JSBSim."""

import numpy as np
import pytest
from flown_scripts import OUTPUTS, bundled_reset_files, bundled_scripts, recorded, scripted
from plain_jsbsim import flown_script

from pathsim_jsbsim_blocks import JSBSimFDM
from pathsim_jsbsim_blocks.errors import BlocksError

pytestmark = pytest.mark.long

# at most, of a flight; some scripts have steps of a millisecond
SECONDS, STEPS = 100.0, 12_000
# with events later than that, s
LONGER = {"c1722": 200.0, "c1723": 200.0, "c3101": 140.0, "c172_elevation_test": 400.0}
LONGER |= {"ah1s_flight_test": 200.0, "ball_chute": 200.0}
REFUSED = {
    "737_cruise_steady_turn_linearize": "do_linearization in event 'Trim and linearize'.*allow_files",
    "737_cruise_steady_turn_simplex": "'simulation/do_simplex_trim' .*do_simple_trim",
}
# the trim that the reset file asks for is that of JSBSim's command line
TRIMMED_AT_START = ("B737_Runway", "b737_runway_new")


def test_all_scripts_are_there():
    assert len(bundled_scripts()) == 58
    assert len(bundled_reset_files()) >= 19


@pytest.mark.parametrize("name", [n for n in bundled_scripts() if n not in REFUSED])
def test_a_script_flies_bit_for_bit_as_in_jsbsim(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = f"scripts/{name}.xml"
    plane = scripted(path)
    seconds = min(plane.duration, LONGER.get(name, min(SECONDS, STEPS * plane.T)))
    rows = flown_script(path, OUTPUTS, seconds, trims=name in TRIMMED_AT_START)
    flown = recorded(plane, seconds)
    number = min(len(rows), len(flown))
    np.testing.assert_array_equal(flown[:number], rows[:number])
    if len(flown) < len(rows):
        # the block ends a flight that is not finite
        assert name == "ball_chute"
        assert not np.isfinite(rows[len(flown)]).all()
    again = recorded(plane, min(seconds, 5.0), reset=True)
    np.testing.assert_array_equal(again, flown[: len(again)])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", REFUSED)
def test_a_script_is_refused_for_its_reason(name):
    with pytest.raises(BlocksError, match=REFUSED[name]):
        JSBSimFDM(script=f"scripts/{name}.xml")


def test_a_linearisation_is_made_where_files_are_allowed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = "scripts/737_cruise_steady_turn_linearize.xml"
    flown = recorded(scripted(path, allow_files=True), 10.0)
    assert list(tmp_path.iterdir()) != []
    np.testing.assert_array_equal(flown, flown_script(path, OUTPUTS, 10.0)[: len(flown)])
