"""Designed gains, flown on the nonlinear aircraft; and aircraft that are refused."""

import dataclasses
import math
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from fleet_conditions import flight
from how_many import first
from models_from_outside import changed

from pathsim_jsbsim_blocks import Aircraft, PitchHold, TrimCondition
from pathsim_jsbsim_blocks.control.gain_tables import TABLES, read_gains
from pathsim_jsbsim_blocks.control.gains import AircraftGains, YawGains
from pathsim_jsbsim_blocks.design import DesignedGains, design_gains
from pathsim_jsbsim_blocks.design.envelope import envelope
from pathsim_jsbsim_blocks.design.requirements import MARGINS
from pathsim_jsbsim_blocks.design.steps import STEPS, fly_step
from pathsim_jsbsim_blocks.flight import Airframe

designed_module = sys.modules["pathsim_jsbsim_blocks.design.designed"]

# a piston engine, an airliner, a fighter with control laws of its own
SOME = ("c172p", "A320", "f16")


@pytest.fixture(scope="module", params=first(SOME))
def designed(request):
    return design_gains(request.param, **flight(request.param))


def test_the_steps_are_as_asked_for(designed):
    report = {row.loop: row for row in designed.report}
    # the nonlinear aircraft, in a plain loop with the blocks' laws
    assert report["pitch"].flown_settling <= 4.0
    assert report["pitch"].flown_overshoot <= 0.05 * 5.0
    assert report["roll"].flown_settling <= 5.0
    for loop in ("pitch", "roll"):
        assert report[loop].settling == pytest.approx(report[loop].flown_settling, rel=0.25)


def test_the_margins_are_as_asked_for(designed):
    wanted = MARGINS[0]
    loops = {row.loop for row in designed.report}
    assert loops >= {"pitch", "roll", "heading", "speed", "altitude"}
    for row in (row for row in designed.report if not row.relaxed):
        assert row.Ms <= wanted.Ms
        assert row.Ms_delayed <= wanted.Ms_delayed
        assert row.gain_margin >= wanted.gain
        assert row.phase_margin >= wanted.phase
        # a phase margin follows from Ms
        assert row.phase_margin >= 2 * math.degrees(math.asin(0.5 / row.Ms)) - 0.5


def test_the_envelope_surrounds_the_trim(designed):
    name, limits = designed.aircraft, designed.envelope
    plane = Aircraft(name, **flight(name))
    assert plane.trim.alpha < limits.alpha_max <= 20.0
    assert 0.4 * plane.trim.speed < limits.vc_min < plane.trim.speed
    assert designed.altitude.hdot_max <= 0.8 * limits.climb_max
    # the slowest speed trims below the limit of the angle of attack
    at_limit = Aircraft(name, **flight(name, speed=limits.vc_min)).trim
    assert plane.trim.alpha < at_limit.alpha < limits.alpha_max + 0.5


def test_a_hold_takes_them_as_they_are(designed):
    assert isinstance(designed, DesignedGains)
    assert PitchHold(gains=designed).gains is designed
    assert type(designed.gains) is AircraftGains
    assert designed.gains.pitch == designed.pitch
    text = str(designed)
    assert designed.aircraft in text
    assert all(row.loop in text for row in designed.report)


@pytest.mark.long
@pytest.mark.parametrize(("row", "loop", "limit"), [(0, "pitch", 0.25), (1, "roll", 1.0)])
def test_an_overshoot_in_flight_shapes_the_loops_once_more(monkeypatch, row, loop, limit):
    flights = []

    def flown(fresh, design, step, seconds):
        overshoot = 0.0
        if step is STEPS[loop]:  # three times as much as is allowed, then half
            overshoot = limit * (0.5 if flights else 3.0)
            flights.append(design)
        return SimpleNamespace(quality=SimpleNamespace(settling=1.0, overshoot=overshoot))

    monkeypatch.setattr(designed_module, "fly_step", flown)
    found = design_gains("A320", **flight("A320"))
    first, second = flights
    assert second.report[row].overshoot <= first.report[row].overshoot
    assert getattr(found, loop) == getattr(second, loop)
    assert found.report[row].flown_overshoot == 0.5 * limit


@pytest.mark.parametrize("method", ["flown", "algebraic"])
def test_a_rudder_without_effect_leaves_the_yaw_loops_out(method, tmp_path):
    deflection = r"(<output>\s*)fcs/rudder-pos-rad", r"\1fcs/elsewhere"
    root = changed(tmp_path, "A320", deflection)
    designed = design_gains("A320", **flight("A320"), method=method, check=False, root=root)
    report = {row.loop: row.relaxed for row in designed.report}
    assert report["yaw"] == "left out: no rudder"
    assert designed.yaw == YawGains(K=0.0)
    assert not report["roll"]
    assert {"pitch", "heading", "speed", "altitude"} < {*report}


@pytest.mark.long
def test_the_climb_is_what_full_throttle_gives():
    # flown: the pitch angle of the trimmed climb found by bisection, at full throttle
    there = TrimCondition(altitude=5000, speed=260, gear=0.0)
    designed = design_gains("737", there, check=False)
    plane = Aircraft("737", condition=dataclasses.replace(there, throttle=1.0, gamma=10.0))
    climb = plane.outputs["vt"] * np.sin(np.radians(plane.outputs["gamma"]))
    assert designed.envelope.climb_max == pytest.approx(climb, rel=0.02)


def test_climb_and_descent_do_not_depend_on_a_steady_wind():
    there = TrimCondition(altitude=5000, speed=281, gear=0.0)

    def limits(wind):
        blown = dataclasses.replace(there, wind_north=wind)
        plane = Aircraft("A320", condition=blown)
        return envelope(lambda: Airframe("A320"), blown, plane.trim, plane.trim.speed)

    still, blown = limits(0.0), limits(-40.0)  # ft/s from ahead
    for name in ("climb_max", "descent_max", "alpha_max"):
        assert getattr(blown, name) == pytest.approx(getattr(still, name), rel=1e-3)


@pytest.mark.parametrize("name", first(["A4", "f15"]))
def test_roll_and_bank_are_fed_forward_for_turns_without_sideslip(name):
    schedule = read_gains(TABLES / f"{name}.json")
    gains = schedule.points[schedule.nominal].gains

    def slip(yaw):
        table = dataclasses.replace(gains, yaw=yaw)
        flown = fly_step(
            lambda: Aircraft(name, **flight(name)), table, STEPS["heading"], seconds=8.0
        )
        assert np.abs(flown.outputs["phi"]).max() == pytest.approx(25.0, abs=1.5)
        return np.abs(flown.outputs["beta"]).max()

    # the limit of the turn, and what the yaw rate and the sideslip alone leave
    assert slip(gains.yaw) < 1.0
    assert slip(dataclasses.replace(gains.yaw, Kroll=0.0, Kbank=0.0)) > 1.05


def test_the_bank_of_straight_flight_leaves_no_error_of_the_heading():
    # the c182 flies straight at a bank of 0.2 deg
    plane = Aircraft("c182", **flight("c182"))
    schedule = read_gains(TABLES / "c182.json")
    gains = schedule.points[schedule.nominal].gains
    assert gains.heading.bank == pytest.approx(plane.trim.phi, rel=1e-3)
    assert gains.heading.bank > 0.1
    flown = fly_step(
        lambda: Aircraft("c182", **flight("c182")), gains, STEPS["heading"], seconds=30.0
    )
    # without it 0.09 deg
    assert flown.quality.steady_error < 0.05
