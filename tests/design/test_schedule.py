"""Schedules: designed, saved, read, flown; the tables that come with the package."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fleet_conditions import FLYING, flight
from hand_tuned import DESIGNED, GAINS

from pathsim_jsbsim_blocks import Aircraft, Autopilot, ParameterError, PitchHold, TrimCondition
from pathsim_jsbsim_blocks import design as design_package
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.control.gain_tables import TABLES, read_gains, tables
from pathsim_jsbsim_blocks.control.gains import AttitudeGains, GainSchedule
from pathsim_jsbsim_blocks.design import DesignedGains, design_gains, design_schedule, schedule
from pathsim_jsbsim_blocks.design.steps import STEPS, fly_step
from pathsim_jsbsim_blocks.errors import DesignError, KeywordError, TrimError

SHIPPED = [path.stem for path in DESIGNED]

# share of the gains that change by more than 1.5, and than the dynamic pressure; 0.32 in the
# tables made before neighbours counted
MOST_JUMPS = 0.13


@pytest.fixture(scope="module")
def found():
    # the first does not trim: it is left out
    frozen = {"propulsion/fuel_freeze": 1.0}
    condition = TrimCondition(altitude=5000, speed=260, gear=0.0, setup=frozen)
    return design_schedule("A320", condition, [5000.0], [120.0, 281.0, 230.0], check=False)


@pytest.mark.long
def test_a_schedule_has_the_conditions_that_can_be_held(found):
    points = found.schedule.points
    assert [(p.altitude, p.speed) for p in points] == [(5000.0, 230.0), (5000.0, 281.0)]
    assert found.nominal == 1  # the nearest to 260 KCAS, designed first
    ((condition, error),) = found.refused
    assert condition.speed == 120.0
    assert isinstance(error, TrimError)
    assert found.schedule.at(5000.0, 230.0) == found.designs[0].gains


@pytest.mark.long
def test_a_saved_schedule_is_read_back_to_six_digits(found, tmp_path):
    file = tmp_path / "a320.json"
    found.save(file)
    read = read_gains(file)
    assert read.nominal == found.nominal
    for point, design in zip(read.points, found.designs, strict=True):
        for loop in ("pitch", "roll", "heading", "altitude", "speed", "yaw", "envelope"):
            numbers = vars(getattr(design.gains, loop))
            assert vars(getattr(point.gains, loop)) == pytest.approx(numbers, rel=6e-6)
    digits = []
    document = json.loads(
        file.read_text(), parse_float=lambda text: digits.append(text) or float(text)
    )
    assert len(digits) > 50
    assert all(float(text) == float(f"{float(text):.6g}") for text in digits)
    report = document["points"][0]["report"]
    assert report["pitch"]["Ms"] == pytest.approx(found.designs[0].report[0].Ms, rel=6e-6)
    assert PitchHold(gains=str(file)).gains == str(file)


LEVEL = TrimCondition(altitude=5000, speed=250, gear=0.0)


@pytest.mark.parametrize(
    ("condition", "altitudes", "speeds", "named"),
    [
        (LEVEL, [], [250.0], "altitudes"),
        (LEVEL, 5000.0, [250.0], "altitudes"),
        (LEVEL, "5000", [250.0], "altitudes"),
        (LEVEL, np.array(5000.0), [250.0], "altitudes"),
        (LEVEL, [5000.0], None, "speeds"),
        (LEVEL, [5000.0, "high"], [250.0], "altitudes"),
        (LEVEL, [5000.0, math.nan], [281.0], "altitudes"),
        (LEVEL, [5000.0], [281.0, math.inf], "speeds"),
        (replace(LEVEL, mach=0.4), [5000.0], [250.0], "mach"),
        (None, [5000.0], [281.0], "condition"),
        ({"altitude": 5000.0}, [5000.0], [281.0], "condition"),
    ],
)
def test_what_a_schedule_cannot_be_over(condition, altitudes, speeds, named, monkeypatch):
    # refused before the first design
    monkeypatch.setattr(schedule, "design_gains", None)
    with pytest.raises(ParameterError) as error:
        design_schedule("A320", condition, altitudes, speeds)
    assert error.value.parameter == named


def over_one(**options):
    return design_schedule("A320", LEVEL, [5000.0], [281.0], **options)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: over_one(progres=print), "design_schedule.*did you mean 'progress'"),
        (lambda: over_one(checks=False), "design_schedule.*did you mean 'check'"),
        (lambda: over_one(progress=True), "progress must be callable"),
        # without its condition
        (lambda: over_one(near=[GAINS["737"]]), "near must be a list of DesignedGains"),
        (lambda: design_gains("A320", setups={}), "design_gains.*did you mean 'setup'"),
        (lambda: design_gains("A320", substep=2), "design_gains.*did you mean 'substeps'"),
        # these belong in the condition
        (lambda: design_gains("A320", altitude=5000), "design_gains has no parameter 'altitude'"),
        (lambda: design_gains("A320", check="no"), "check"),
        *(
            (lambda near=near: design_gains("A320", near=near), "near must be a list of AircraftG")
            for near in ("A320", [0.3], GAINS["737"], [{"pitch": 0.3}], None)
        ),
    ],
)
def test_options_that_cannot_be(call, words):
    with pytest.raises(ParameterError, match=words):
        call()


@pytest.mark.long
def test_designed_gains_are_replaced_by_their_names(found):
    slow = replace(found.designs[0].speed, band=12.0)
    assert replace(found.designs[0], speed=slow).gains.speed.band == 12.0
    with pytest.raises(KeywordError, match="did you mean 'speed'"):
        replace(found.designs[0], speeds=slow)


@pytest.mark.long
def test_a_hold_takes_the_schedule_that_was_found(found):
    for hold in (Autopilot, PitchHold):
        with pytest.raises(ParameterError, match="did you mean its attribute 'schedule'"):
            hold(gains=found)
        assert hold(gains=found.schedule).gains == found.schedule


def test_no_condition_at_all_is_the_first_error():
    with pytest.raises(TrimError):
        design_schedule("A320", TrimCondition(speed=100, gear=0.0), [5000.0], [100.0])


def test_the_command_reports_and_saves(tmp_path, capsys):
    file = tmp_path / "gains.json"
    arguments = ["--altitude", "5000", "--speed", "281", "--gear", "0", "--save", str(file)]
    assert main(["gains", "A320", *arguments]) == 0
    text = capsys.readouterr().out
    assert "pitch" in text
    assert f"gains saved: {file}" in text
    (point,) = read_gains(file).points
    assert (point.altitude, point.speed) == (5000.0, 281.0)
    assert_in_table("A320", (5000.0, 281.0), point.gains)


def test_the_command_creates_what_a_model_expects(monkeypatch):
    asked = []

    def design(aircraft, condition, *places, create, **options):
        asked.append((condition, create))
        raise DesignError("none", aircraft=aircraft, reason="unstable", loop="pitch")

    monkeypatch.setattr(design_package, "design_schedule", design)
    level = ["gains", "f104", "--altitude", "5000", "--speed", "274"]
    for arguments in (level, [*level, "--gear", "0"]):
        assert main(arguments) == 1
    assert asked[0] == asked[1]
    condition, create = asked[0]
    assert create == {"systems/radar/range": 0.0}
    assert condition.gear == 0.0
    assert condition.setup == {"propulsion/fuel_freeze": 1.0}


@pytest.mark.long
def test_the_command_says_it_once(capsys):
    too_fast = ["gains", "c172p", "--altitude", "5000", "--speed"]
    assert main([*too_fast, "300"]) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("pathsim-jsbsim: aircraft 'c172p' does not trim at altitude=5000.0")
    assert err.count("does not trim") == 1
    assert main([*too_fast, "300", "310"]) == 1
    assert capsys.readouterr().err.count("does not trim") == 2


def test_the_command_saves_what_can_be_read_only(tmp_path, capsys):
    assert main(["gains", "c172p", "--save", str(tmp_path / "gains.txt")]) == 1
    assert f"did you mean {str(tmp_path / 'gains.json')!r}" in capsys.readouterr().err


@pytest.mark.parametrize("name", SHIPPED)
def test_a_table_of_the_fleet_is_taken_by_its_name(name):
    aircraft = name.removesuffix("-designed")
    assert name in tables()
    assert (aircraft in GAINS) == name.endswith("-designed")
    schedule = read_gains(TABLES / f"{name}.json")
    assert schedule.aircraft == aircraft
    point = schedule.points[schedule.nominal]
    if aircraft != "dr1":  # designed at 48 KCAS, before its trim at 59 was found
        assert (point.altitude, point.speed) == FLYING[aircraft][:2]
    assert point.gains.envelope.vc_min < point.speed
    assert Autopilot(gains=name).gains == name
    speed = schedule.points[0].gains.speed
    for point in schedule.points:
        # one loop, but for the throttle that a climb takes
        assert point.gains.speed == replace(speed, Kc=point.gains.speed.Kc)
        assert all(
            math.isfinite(x) for loop in vars(point.gains).values() for x in vars(loop).values()
        )


def assert_in_table(table, place, made):
    schedule = read_gains(TABLES / f"{table}.json")
    (point,) = [p for p in schedule.points if (p.altitude, p.speed) == place]
    published = {"vmo", "mmo"}  # not designed
    # loops that were designed again within others, which would now be different over them
    over = {"yaw": {"yaw", "roll"}, "speed": {"altitude"}}
    again = over.keys() & json.loads((TABLES / f"{table}.json").read_text(encoding="utf-8")).keys()
    skipped = {"yaw"}.union(*(over[name] for name in again))
    for loop, gains in vars(point.gains).items():
        if loop in skipped:
            continue
        found = {k: v for k, v in vars(getattr(made, loop)).items() if k not in published}
        of_table = {k: v for k, v in vars(gains).items() if k not in published}
        assert of_table == pytest.approx(found, rel=1e-3, abs=1e-6), loop


@pytest.mark.long  # the command has one of these in each run of the tests
@pytest.mark.parametrize(
    ("table", "place"),
    [
        ("c182", (7500.0, 98.0)),
        ("L17", (5000.0, 84.0)),
        ("OV10", (5000.0, 193.0)),
        ("fokker100", (35_000.0, 231.0)),
    ],
)
def test_a_table_of_the_fleet_can_be_made_again(table, place):
    name = table.removesuffix("-designed")
    points = read_gains(TABLES / f"{table}.json")
    middle = points.points[points.nominal]

    def turn(there):
        """When docs/gain_tables.py designs a point: altitudes outwards, then airspeeds."""
        apart = abs(math.log(there[1] / middle.speed))
        return there[0] != middle.altitude, there[0] > middle.altitude, there[0], apart

    before = [
        DesignedGains(
            **vars(p.gains),
            condition=flight(name, altitude=p.altitude, speed=p.speed)["condition"],
        )
        for p in points.points
        if turn((p.altitude, p.speed)) < turn(place)
    ]
    altitudes, speeds = ([x] for x in place)
    made = design_schedule(
        name, altitudes=altitudes, speeds=speeds, near=before, check=False, **flight(name)
    )
    assert_in_table(table, place, made.designs[0].gains)


def test_gains_change_little_from_one_point_of_a_table_to_the_next(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "docs")
    import gain_tables

    # by hand: Kp of the pitch angle 0.2 to 0.31 between airspeeds of 1.25, of the roll 0.2 to 0.32
    points = read_gains(TABLES / "A320.json").points[:2]
    loops = AttitudeGains(Kp=0.2, Ki=0.1), AttitudeGains(Kp=0.31, Ki=0.1)
    first, second = (
        replace(p, altitude=1000.0, speed=vc, gains=replace(points[0].gains, pitch=loop))
        for p, vc, loop in zip(points, (200.0, 250.0), loops, strict=True)
    )
    counted = gain_tables.jumps(GainSchedule("A320", (first, second), 0))
    assert counted["pitch"] == [3, 0]
    faster = replace(second, gains=replace(second.gains, pitch=replace(loops[1], Kp=0.32)))
    assert gain_tables.jumps(GainSchedule("A320", (first, faster), 0))["pitch"] == [3, 1]

    found = [gain_tables.jumps(read_gains(file)) for file in DESIGNED]
    pairs, jumped = (sum(x[loop][i] for x in found for loop in x) for i in (0, 1))
    assert pairs > 4000
    assert jumped < MOST_JUMPS * pairs


@pytest.mark.long
@pytest.mark.parametrize("altitude", [24_000.0, 33_000.0])
@pytest.mark.parametrize(
    "table", ["737-designed", "787-8", "A320", "fokker100", "global5000-designed"]
)
def test_a_step_of_the_airspeed_settles_at_cruise_altitude(table, altitude):
    name = table.removesuffix("-designed")
    flown = fly_step(
        lambda: Aircraft(name, **flight(name, altitude=altitude)),
        read_gains(TABLES / f"{table}.json"),
        STEPS["speed"],
        seconds=80.0,
    )
    # one loop for all altitudes; at the highest its throttle has less effect
    tolerance = 2.0 if (name, altitude) == ("fokker100", 33_000.0) else 1.0
    assert flown.quality.steady_error <= tolerance
    assert flown.quality.overshoot <= 2.5
    assert np.abs(flown.outputs["h"] - altitude).max() <= 22.5
