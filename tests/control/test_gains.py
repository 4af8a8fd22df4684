"""Gain tables and numbers: what is taken, what is refused, and by which words."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    HeadingHold,
    ParameterError,
    PitchHold,
    RollHold,
    YawDamper,
)
from pathsim_jsbsim_blocks.control import holds
from pathsim_jsbsim_blocks.control.gains import GAINS, AttitudeGains, YawGains, loop_gains

HOLDS = [*(getattr(holds, name) for name in holds.__all__), Autopilot]
PITCH = {"Kp": 0.1, "Ki": 0.1}


@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("table", ["c172p", "737", "global5000"])
def test_every_hold_takes_every_table(hold, table):
    block = hold(gains=table)
    assert block.gains == table
    assert hold(gains=GAINS[table]).gains is GAINS[table]


@pytest.mark.parametrize("hold", HOLDS)
def test_an_unknown_table_names_the_nearest(hold):
    with pytest.raises(ParameterError, match="did you mean 'c172p'") as error:
        hold(gains="c172")
    assert error.value.parameter == "gains"


@pytest.mark.parametrize(
    ("hold", "gains", "words"),
    [
        (PitchHold, {**PITCH, "ramps": 1.0}, "'ramps' is no pitch gain.*did you mean 'ramp'"),
        (PitchHold, {"Kp": 0.1}, "pitch gain missing: Ki"),
        (PitchHold, 0.1, "pitch gains must be"),
        (RollHold, YawGains(K=0.1), "roll gains must be"),
        (AltitudeHold, {"altitudes": "737", "pitch": "737"}, "did you mean 'altitude'"),
        (AltitudeHold, {"altitude": "737"}, "loop missing: pitch"),
        (AltitudeHold, PITCH, "'Kp' is no loop"),
        (HeadingHold, AttitudeGains(0.1, 0.1), "heading, roll"),
        (Autopilot, {"pitch": "737"}, "loop missing: roll, heading"),
        (PitchHold, {"Kp": "high", "Ki": 0.1}, "Kp must be a number"),
        (PitchHold, {**PITCH, "ramp": 0.0}, "ramp must be greater than 0"),
        (PitchHold, {**PITCH, "b": -0.1}, "b must lie in"),
    ],
)
def test_what_gains_cannot_be(hold, gains, words):
    with pytest.raises(ParameterError, match=words):
        hold(gains=gains)


def test_numbers_and_tables_mix_by_loop():
    mixed = {"altitude": "737", "pitch": {**PITCH, "Kr": 0.02}}
    altitude, pitch = loop_gains(mixed, "altitude", "pitch")
    assert altitude == GAINS["737"].altitude
    assert pitch == AttitudeGains(Kp=0.1, Ki=0.1, Kr=0.02)
    gentle = dataclasses.replace(GAINS["737"].pitch, ramp=1.0)
    assert loop_gains({"altitude": "737", "pitch": gentle}, "altitude", "pitch")[1] is gentle


@pytest.mark.parametrize(
    ("hold", "name", "value"),
    [
        (PitchHold, "gains", "cessna"),
        (PitchHold, "authority", -0.1),
        (PitchHold, "authority", (0.1, 0.2)),
        (PitchHold, "authority", (-0.1, 0.0, 0.1)),
        (PitchHold, "theta_ref", "level"),
        (RollHold, "phi_ref", float("nan")),
        (HeadingHold, "bank_max", 0.0),
        (AltitudeHold, "hdot_max", -10.0),
        (AltitudeHold, "theta_max", -20.0),
        (AirspeedHold, "vc_ref", [90.0]),
        (Autopilot, "throttle_authority", "full"),
        (Autopilot, "psi_ref", "north"),
        (YawDamper, "T", -1.0),
    ],
)
def test_bad_parameters_are_refused_when_built_and_in_flight(hold, name, value):
    with pytest.raises(ParameterError):
        hold(**{name: value})
    block = hold()
    before = getattr(block, name)
    with pytest.raises(ParameterError):
        setattr(block, name, value)
    assert getattr(block, name) == before


def test_authority_is_one_number_or_two():
    assert PitchHold(authority=0.2).authority == 0.2
    hold = PitchHold(authority=(-0.1, 0.3), theta_ref=90.0, gains={"Kp": 10.0, "Ki": 0.0})
    state = hold.initial_state()
    for _ in range(3):
        (elevator, _), state = hold.law([0.0] * 5, state)
    assert elevator == -0.1  # nose up


def test_the_page_shows_the_gains_that_are_flown():
    page = (Path(__file__).parents[2] / "docs" / "autopilots.md").read_text(encoding="utf-8")
    loops = "pitch|roll|heading|altitude|speed|yaw"
    rows = re.findall(rf"^\| ({loops}) \| (\w+) \| (.+) \|$", page, re.M)
    shown = {
        (table, loop, gain): float(value)
        for loop, gain, values in rows
        for table, value in zip(GAINS, values.split(" | "), strict=True)
    }
    flown = {
        (table, loop.name, gain): value
        for table, gains in GAINS.items()
        for loop in dataclasses.fields(gains)
        for gain, value in dataclasses.asdict(getattr(gains, loop.name)).items()
    }
    assert shown == flown
