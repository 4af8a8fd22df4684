"""Gain tables and numbers: what is taken, what is refused, and by which words."""

from __future__ import annotations

import csv
import dataclasses
import json
from fractions import Fraction
from pathlib import Path
from typing import get_args

import all_holds
import numpy as np
import pytest
from hand_tuned import DESIGNED, GAINS

from pathsim_jsbsim_blocks import (
    AirspeedHold,
    Autopilot,
    HeadingHold,
    ParameterError,
    PitchHold,
    RollHold,
)
from pathsim_jsbsim_blocks.control.gain_tables import (
    FORMAT,
    TABLES,
    document_of,
    loop_gains,
    read_gains,
    schedule_of,
)
from pathsim_jsbsim_blocks.control.gains import (
    AircraftGains,
    AttitudeGains,
    DesignPoint,
    EnvelopeLimits,
    GainSchedule,
    SpeedGains,
    TableName,
    YawGains,
)
from pathsim_jsbsim_blocks.errors import FileError

HOLDS = [*all_holds.HOLDS.values()]
PITCH = {"Kp": 0.1, "Ki": 0.1}


def test_editors_know_the_names_of_all_tables():
    assert sorted(get_args(TableName)) == sorted(path.stem for path in TABLES.glob("*.json"))


def test_gains_of_a_glider_have_no_airspeed_loop():
    glider = dataclasses.replace(GAINS["737"], altitude=None, speed=None)
    assert loop_gains(glider, "pitch") == (GAINS["737"].pitch,)
    with pytest.raises(ParameterError, match="lack the loop 'speed'") as refused:
        AirspeedHold(gains=glider)
    assert refused.value.value is glider


def test_an_aircraft_without_a_table_is_told_the_way_to_gains():
    with pytest.raises(ParameterError, match=r"design_gains, or from a file") as refused:
        PitchHold("ah1s")
    assert (refused.value.parameter, refused.value.value) == ("gains", "ah1s")


@pytest.mark.parametrize("hold", HOLDS)
def test_an_unknown_table_names_the_nearest(hold):
    with pytest.raises(ParameterError) as error:
        hold(gains="c172")
    assert "'c172p'" in str(error.value)
    assert error.value.parameter == "gains"


@pytest.mark.parametrize(
    ("hold", "gains", "words"),
    [
        (PitchHold, {**PITCH, "ramps": 1.0}, "there is no pitch gain 'ramps'.*did you mean 'ramp'"),
        (PitchHold, {"Kp": 0.1}, "pitch gain missing: Ki"),
        (PitchHold, 0.1, "pitch gains must be"),
        (RollHold, YawGains(K=0.1), "roll gains must be"),
        (HeadingHold, {"headings": "737", "roll": "737"}, "did you mean 'heading'"),
        (HeadingHold, {"heading": "737"}, "loop missing: roll"),
        (Autopilot, {"pitch": "737"}, "loop missing: roll, heading"),
        (HeadingHold, PITCH, "there is no loop 'Kp'"),
        (HeadingHold, AttitudeGains(0.1, 0.1), "heading, roll"),
        (PitchHold, {"Kp": "high", "Ki": 0.1}, "Kp must be a number"),
        (PitchHold, {**PITCH, "ramp": 0.0}, "ramp must be greater than 0"),
        (PitchHold, {**PITCH, "b": -0.1}, "b must be at least 0"),
        (PitchHold, Path("mine.json"), "did you mean 'mine.json'"),
        (AirspeedHold, {**PITCH, "band": 0.0}, "band must be"),
        (AirspeedHold, {**PITCH, "band": None}, "band must be"),
        (AirspeedHold, {**PITCH, "bnad": 4.0}, "no speed gain 'bnad'.*did you mean 'band'"),
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


def test_the_ends_of_a_range_are_in_it():
    assert HeadingHold(bank_max=80.0).bank_max == 80.0
    assert PitchHold(theta_ref=-90.0).theta_ref == -90.0


@pytest.mark.parametrize("kind", [int, np.int64, np.float32, np.float64, Fraction])
def test_gains_are_plain_floats(kind):
    # arithmetic with a numpy.float32 is in single precision, and JSON has neither it nor an int64
    gains = SpeedGains(kind(1), kind(1), ramp=kind(2), Kc=kind(1), band=kind(4))
    assert {type(value) for value in vars(gains).values()} == {float}
    point = DesignPoint(kind(5000), kind(90), GAINS["c172p"])
    assert {type(point.altitude), type(point.speed)} == {float}
    schedule = GainSchedule("c172p", (point,), nominal=0.0)
    assert type(schedule.nominal) is int
    assert json.loads(json.dumps(document_of(schedule))) == document_of(schedule)
    assert loop_gains(schedule, "speed") == (GAINS["c172p"].speed,)


def point(altitude, speed, **values):
    gains = dataclasses.replace(
        GAINS["737"],
        pitch=AttitudeGains(Kp=values.get("Kp", 0.1), Ki=0.1),
        envelope=EnvelopeLimits(12.0, 130.0, values.get("climb", 40.0), 30.0),
    )
    return DesignPoint(altitude, speed, gains)


@pytest.fixture
def schedule():
    return GainSchedule(
        "737",
        (
            point(5000.0, 200.0, Kp=0.4),
            point(5000.0, 300.0, Kp=0.2, climb=60.0),
            point(15000.0, 240.0, Kp=0.8),
        ),
        nominal=1,
    )


@pytest.mark.parametrize(
    ("h", "vc", "Kp", "climb"),
    [
        (5000, 200, 0.4, 40),
        (5000, 250, 0.3, 50),
        (10_000, 250, 0.55, 45),  # half of 0.3 and half of 0.8
        (7500, 300, 0.35, 55),  # three quarters of 0.2 and a quarter of 0.8
        (0, 100, 0.4, 40),  # constant beyond the outermost points
        (40_000, 500, 0.8, 40),
        (5000, 300, 0.2, 60),
        (15_000, 210, 0.8, 40),
    ],
)
def test_between_its_points_a_schedule_interpolates(schedule, h, vc, Kp, climb):
    gains = schedule.at(h, vc)
    assert gains.pitch.Kp == pytest.approx(Kp, rel=1e-12)
    assert gains.envelope.climb_max == pytest.approx(climb, rel=1e-12)
    assert gains.heading == GAINS["737"].heading


@pytest.mark.filterwarnings("ignore:FlareHold. no landings")
@pytest.mark.parametrize("hold", HOLDS)
def test_every_hold_takes_a_schedule_and_its_file(hold, schedule, tmp_path, monkeypatch):
    assert hold(gains=schedule).gains is schedule
    path = tmp_path / "mine.json"
    document = {**document_of(schedule), "versions": {"jsbsim": "1.3"}}
    document["points"][0]["report"] = {"Ms": 1.3}
    path.write_text(json.dumps(document))
    assert read_gains(path) == schedule_of(str(path)) == schedule
    assert hold(gains=str(path)).gains == str(path)
    monkeypatch.chdir(tmp_path)
    assert hold(gains="mine.json").gains == "mine.json"
    Path("CAPITALS.JSON").write_bytes(path.read_bytes())
    assert schedule_of("CAPITALS.JSON") == schedule
    assert loop_gains("mine.json", "pitch")[0].Kp == 0.2  # of the nominal point
    with pytest.raises(FileError, match=r"did you mean 'mine.json'"):
        hold(gains="mime.json")
    with pytest.raises(ParameterError) as error:
        hold(gains="mi\0ne.json")
    assert (error.value.parameter, error.value.value) == ("gains", "mi\x00ne.json")
    Path("deep.json").write_text("[" * 100_000)
    with pytest.raises(ParameterError) as error:
        hold(gains="deep.json")
    assert error.value.parameter == "gains"
    document["points"][0]["gains"]["pitch"]["Kpp"] = 1.0
    path.write_text(json.dumps(document))
    with pytest.raises(ParameterError) as error:
        hold(gains="mine.json")
    assert error.value.parameter == "gains"


def test_a_file_of_an_older_version_has_no_band(schedule, tmp_path):
    path = tmp_path / "old.json"
    document = document_of(schedule)
    for point in document["points"]:
        del point["gains"]["speed"]["band"]
    path.write_text(json.dumps(document))
    assert read_gains(path) == schedule  # the 737's: no band


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not a JSON file"),
        ("[1]", "format must be 'pathsim-jsbsim-blocks gains 1'"),
        (json.dumps({"format": FORMAT}), "not a complete gain table: KeyError.*aircraft"),
        (
            json.dumps({"format": FORMAT, "aircraft": "x", "nominal": 0, "points": []}),
            "needs design points",
        ),
    ],
)
def test_files_that_are_no_gain_table(tmp_path, text, words):
    path = tmp_path / "other.json"
    path.write_text(text)
    with pytest.raises(ParameterError, match=words):
        PitchHold(gains=str(path))


BARE = DesignPoint(0.0, 200.0, dataclasses.replace(GAINS["737"], envelope=None))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda points: GainSchedule("737", points[::-1]), "sorted by altitude"),
        (lambda points: GainSchedule("737", points, nominal=3), "index of one of 3 points"),
        (lambda points: GainSchedule("737", (BARE, *points)), "envelope gains, or none"),
        (lambda points: GainSchedule("737", points[0]), "list of DesignPoint"),
        (lambda points: GainSchedule("737", iter([1])), "list of DesignPoint"),
        (lambda points: DesignPoint(0.0, 200.0, "737"), "AircraftGains"),
        (lambda points: GainSchedule("737", points).at(np.nan, 90.0), "must be"),
        (lambda points: GainSchedule("737", points).at(0.0, None), "must be"),
    ],
)
def test_schedules_that_cannot_be(schedule, make, words):
    with pytest.raises(ParameterError, match=words):
        make(schedule.points)


def test_the_page_shows_the_gains_that_are_flown():
    path = Path(__file__).parents[2] / "docs" / "evidence" / "autopilots-gains.csv"
    with path.open(encoding="utf-8", newline="") as file:
        head, _, *rows = csv.reader(file)
    assert head[2:] == list(GAINS)
    shown = {
        (table, loop, gain): float(value)
        for loop, gain, *values in rows
        for table, value in zip(GAINS, values, strict=True)
    }
    flown = {
        (table, loop.name, gain): value
        for table, gains in GAINS.items()
        for loop in dataclasses.fields(gains)
        if getattr(gains, loop.name) is not None
        for gain, value in dataclasses.asdict(getattr(gains, loop.name)).items()
    }
    assert shown == flown


def test_the_page_of_designed_gains_shows_how_slowly_the_airspeed_settles():
    page = (Path(__file__).parents[2] / "docs" / "designed-gains.md").read_text(encoding="utf-8")
    nominal = [loop_gains(str(file), "speed")[0] for file in DESIGNED]
    (time,) = {round(gains.Kp / gains.Ki) for gains in nominal}
    assert f"Kp / Ki is {time} s." in page


@pytest.mark.parametrize(
    "kind", [AttitudeGains, YawGains, EnvelopeLimits, DesignPoint, GainSchedule, AircraftGains]
)
def test_gains_cannot_be_changed_in_place(kind):
    # blocks share them, and tell a change by another object
    name = dataclasses.fields(kind)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(object.__new__(kind), name, 1.0)
