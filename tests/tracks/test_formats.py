"""Each format is read back by another program's reader, and compared with the track."""

import base64
import dataclasses
import datetime
import json
import math
import re
import sys
from pathlib import Path

import fastkml
import numpy as np
import pandas
import pyacmi
import pymap3d
import pytest
from lxml import etree
from plotly.offline import get_plotlyjs

from pathsim_jsbsim_blocks.errors import MissingExtraError, ParameterError
from pathsim_jsbsim_blocks.tracks import Track, save_tracks

START = datetime.datetime(2025, 6, 1, 9, 30, tzinfo=datetime.timezone.utc)


def climbing_turn(name="one", n=121, **signals):
    """North of the Alps, through north, over the date of the track by whole seconds."""
    time = np.arange(n) / 4
    return Track(
        name,
        "c172p",
        time,
        lat=47.0 + 1e-3 * np.sin(time / 5),
        lon=11.0 + 1e-3 * np.cos(time / 5),
        h=5000 + 10 * time,
        theta=np.full(n, 4.0),
        phi=20 + 0 * time,
        psi=(340 + 3 * time) % 360,
        signals={
            "calibrated airspeed [kt]": 90 + time / 10,
            "elevator": np.sin(time),
            "Mach number": np.where(time < 1, np.nan, 0.14),
            "throttle [ft]": time,  # another quantity under a known name
            **signals,
        },
        about={"trimmed at": "5000 ft <level>"},
    )


def test_csv_and_parquet_hold_every_bit(tmp_path):
    track = climbing_turn()
    for ending, read in ((".csv", pandas.read_csv), (".parquet", pandas.read_parquet)):
        save_tracks(tmp_path / f"flight{ending}", [track])
        table = read(tmp_path / f"flight{ending}").reset_index()
        assert np.array_equal(table["time [s]"], track.time)
        for label, column in track.columns.items():
            assert np.array_equal(table[label], column, equal_nan=True), label
    assert list(track.to_frame().columns)[:6] == [
        "latitude [deg]",
        "longitude [deg]",
        "altitude [ft]",
        "pitch angle [deg]",
        "roll angle [deg]",
        "heading [deg]",
    ]


def test_a_table_of_several_aircraft_names_them(tmp_path):
    save_tracks(tmp_path / "two.csv", [climbing_turn("one"), climbing_turn("two, too", n=3)])
    table = pandas.read_csv(tmp_path / "two.csv", index_col=["aircraft", "time [s]"])
    assert len(table.loc["one"]) == 121
    assert list(table.loc["two, too"].index) == [0.0, 0.25, 0.5]


def test_tacview_by_an_independent_reader(tmp_path):
    tracks = [climbing_turn("one"), climbing_turn("two, too", n=9)]
    save_tracks(tmp_path / "flight.acmi", tracks, START)
    read = pyacmi.Acmi()
    read.load_acmi(str(tmp_path / "flight.acmi"))
    assert (read.file_type, read.file_version) == ("text/acmi/tacview", 2.2)
    assert str(read.reference_time).startswith("2025-06-01 09:30:00")
    assert read.timeframes == tracks[0].time.tolist()
    for identity, track in zip(("1", "2"), tracks, strict=True):
        seen = read.objects[identity]
        assert seen.tags == "Air+FixedWing"
        assert seen.get_value("Name") == "c172p"
        # the reader leaves the escapes of commas in
        assert seen.call_sign().replace("\\,", ",") == track.name
        for i, t in enumerate(track.time):
            assert seen.latitude(t) == pytest.approx(track.lat[i], abs=1e-9)
            assert seen.longitude(t) == pytest.approx(track.lon[i], abs=1e-9)
            assert seen.altitude(t) == pytest.approx(track.h[i] * 0.3048, abs=1e-4)
            for value, column in (
                (seen.roll(t), track.phi),
                (seen.pitch(t), track.theta),
                (seen.yaw(t), track.psi),
            ):
                assert value == pytest.approx(column[i], abs=1e-4)
            # 1 kt is 1852 m in an hour
            cas = track.signals["calibrated airspeed [kt]"][i] * 1852 / 3600
            assert seen.cas(t) == pytest.approx(cas, rel=1e-5)
            elevator = seen.get_value("Elevator", t)
            assert elevator == pytest.approx(track.signals["elevator"][i], rel=1e-5)
        assert seen.mach(8.0) == pytest.approx(0.14)
        assert seen.throttle() is None
    # a line has what has changed only
    text = (tmp_path / "flight.acmi").read_text(encoding="utf-8-sig")
    assert text.count("Type=Air+FixedWing") == text.count("Mach=") == 2


def test_google_earth_by_an_independent_reader(tmp_path):
    track = climbing_turn("a & b")
    save_tracks(tmp_path / "flight.kml", [track, climbing_turn("<c>", n=5)], START)
    document = fastkml.KML.parse(tmp_path / "flight.kml").features[0]
    mark, other = document.features
    assert (mark.name, other.name) == ("a & b", "<c>")
    drawn = mark.kml_geometry
    places = np.array(drawn.coords)
    assert places[:, 0] == pytest.approx(track.lon, abs=1e-9)
    assert places[:, 1] == pytest.approx(track.lat, abs=1e-9)
    assert places[:, 2] == pytest.approx(track.h * 0.3048, abs=1e-3)
    turns = np.array(drawn.angles)
    assert turns[:, 0] == pytest.approx(track.psi)
    # nose up is a negative tilt, right wing down a negative roll
    assert turns[:, 1] == pytest.approx(-track.theta)
    assert turns[:, 2] == pytest.approx(-track.phi)
    assert [w.dt for w in drawn.whens] == [
        START + datetime.timedelta(seconds=t) for t in track.time
    ]
    for schema in ("ogckml22.xsd", "kml22gx.xsd"):
        valid = etree.XMLSchema(etree.parse(Path(fastkml.__file__).parent / "schema" / schema))
        valid.assertValid(etree.parse(tmp_path / "flight.kml"))
    text = (tmp_path / "flight.kml").read_text(encoding="utf-8")
    assert re.match(r"<\?xml version=.1\.0. encoding=.utf-8.\?>", text, re.IGNORECASE)
    assert "<displayName>calibrated airspeed [kt]</displayName>" in text
    assert text.count("<gx:value>") == 4 * (121 + 5)


def test_google_earth_gets_5_of_the_steps_per_second(tmp_path):
    n = 5 * 120 + 8  # the end is no whole fifth of a second
    time, still = 3.7 + np.arange(n) / 120, np.zeros(n)
    columns = (time, 47 + time / 1e4, still, 1e3 + time, still, still, still)
    steps = Track("steps", "c172p", *columns, signals={"Mach number": time}, every_step=True)
    chosen = Track("chosen", "c172p", *columns)
    slow = dataclasses.replace(climbing_turn("slow"), every_step=True)  # 4 per second
    save_tracks(tmp_path / "flight.kml", [steps, chosen, slow], START)
    few, whole, same = fastkml.KML.parse(tmp_path / "flight.kml").features[0].features
    seconds = [
        (w.dt - START - datetime.timedelta(seconds=3.7)).total_seconds()
        for w in few.kml_geometry.whens
    ]
    assert seconds == pytest.approx([*np.arange(26) / 5, (n - 1) / 120], abs=2e-6)
    # the values are those of the same samples
    places = np.array(few.kml_geometry.coords)
    assert places[:, 1] == pytest.approx(47 + (3.7 + np.array(seconds)) / 1e4, abs=2e-9)
    assert (tmp_path / "flight.kml").read_text(encoding="utf-8").count("<gx:value>") == 27 + 4 * 121
    assert len(list(whole.kml_geometry.coords)) == n
    assert len(list(same.kml_geometry.coords)) == 121
    # no other format has fewer
    save_tracks(tmp_path / "flight.csv", [steps])
    assert len(pandas.read_csv(tmp_path / "flight.csv")) == n


def long_flight(seconds, rate=5, signals=23):
    """Legs at 100 m/s, half an hour each, with a turn of 3 deg/s after each, on a small globe."""
    time = np.arange(seconds * rate) / rate
    heading = np.cumsum(np.where(time % 1800 > 1740, 3.0, 0.0)) / rate
    step = np.degrees(100 / rate / 6.37e6)
    lat = np.cumsum(step * np.cos(np.radians(heading)))
    lon = np.cumsum(step * np.sin(np.radians(heading)))
    level = np.zeros_like(time)
    # the longest numbers
    values = -1.234567e-200 * (1 + np.arange(len(time)) / len(time))
    return Track(
        "long",
        "c172p",
        time,
        *(lat, lon + 100, level + 2e5, level, level, heading % 360),
        signals={f"signal {i} [ft]": values for i in range(signals)},
        every_step=True,
    )


@pytest.mark.long
def test_ten_hours_for_google_earth_take_5_megabytes(tmp_path):
    flight = long_flight(36000)
    save_tracks(tmp_path / "flight.kml", [flight])
    assert 4e6 < (tmp_path / "flight.kml").stat().st_size <= 5e6
    drawn = fastkml.KML.parse(tmp_path / "flight.kml").features[0].features[0].kml_geometry
    noon = datetime.datetime(2024, 3, 20, 12, tzinfo=datetime.timezone.utc)
    seconds = np.array([(w.dt - noon).total_seconds() for w in drawn.whens])
    assert (seconds[0], seconds[-1]) == (0.0, 35999.8)
    assert np.ptp(np.diff(seconds[:-1])) < 0.3
    # m from where the aircraft was: as a viewer that interpolates over time draws it
    places = np.array(drawn.coords)
    there = np.array(pymap3d.geodetic2ecef(places[:, 1], places[:, 0], places[:, 2]))
    real = np.array(pymap3d.geodetic2ecef(flight.lat, flight.lon, flight.h * 0.3048))
    drawn = [np.interp(flight.time, seconds, x) for x in there]
    # in a turn of 3 deg/s at 100 m/s: chords of 9 s
    assert np.linalg.norm(real - drawn, axis=0).max() < 60
    # several aircraft share the size
    two = [dataclasses.replace(long_flight(3600), name=name) for name in "ab"]
    save_tracks(tmp_path / "two.kml", two)
    assert 4e6 < (tmp_path / "two.kml").stat().st_size <= 5e6


def test_points_are_even_over_hours_of_summed_steps():
    time = np.cumsum(np.full(2 * 3600 * 60, 1 / 60))
    still = np.zeros_like(time)
    track = Track("long", "c172p", time, *[still] * 6)
    points = track.at_most(5.0 * (time[-1] - time[0])).time
    assert len(points) == 2 * 3600 * 5 + 1
    assert np.diff(points[:-1]) == pytest.approx(0.2, abs=1e-6)


def test_a_report_is_one_page_and_text_of_the_user_is_text_in_it(tmp_path):
    save_tracks(tmp_path / "flight.html", [climbing_turn("</script><b>&")])
    page = (tmp_path / "flight.html").read_text(encoding="utf-8").replace(get_plotlyjs(), "")
    assert not re.findall(r"(?:src|href)=\"(?!data:)", page)
    assert "http" not in page
    assert "<!--" not in page.replace("<!DOCTYPE", "")
    assert "</script><b>" not in page
    assert "&lt;/script&gt;&lt;b&gt;&amp;" in page
    assert "5000 ft &lt;level&gt;" in page


def test_a_report_holds_the_flights_east_north_and_up_of_the_first(tmp_path):
    n = 30_001
    time = np.linspace(0.0, 300.0, n)
    still = np.zeros(n)
    moved = time / 3e4
    first = Track("a", "c172p", time, 47 + moved, 11 + moved, 1e3 + time, still, still, still)
    heading = (350 + time) % 360
    # 0.01 deg further north and east, 100 ft higher
    second = Track(
        "b", "ov10", time, 47.01 + still, 11.01 + still, 1.1e3 + still, still, still + 5.0, heading
    )
    save_tracks(tmp_path / "flight.html", [first, second])
    page = (tmp_path / "flight.html").read_text(encoding="utf-8").replace(get_plotlyjs(), "")
    start = page.index('{"aircraft"')
    a, b = json.JSONDecoder().raw_decode(page[start:])[0]["aircraft"]

    def column(packed):
        return np.frombuffer(base64.b64decode(packed), "<f4")

    assert [column(a[key])[0] for key in ("east", "north", "up")] == [0.0, 0.0, 0.0]
    assert column(a["time"])[-1] == 300.0
    # two of three samples, and the last
    assert len(column(a["time"])) == 20_001
    # WGS84's radii of curvature at 47 deg: 6,369,620 m along the meridian, 6,389,587 m across
    north, east = math.radians(0.01) * 6369620, math.radians(0.01) * 6389587 * math.cos(0.8203)
    for key, expected in (("north", north), ("east", east), ("up", 30.48)):
        # m; the earth curves away by 0.15 m, and the meridians converge
        assert column(b[key]) == pytest.approx(expected, abs=0.2), key
    assert column(a["up"])[-1] == pytest.approx(300 * 0.3048, abs=0.2)
    assert np.all(column(b["phi"]) == 5.0)
    assert column(b["psi"])[-1] == pytest.approx(290.0)
    # without the jump at north
    signals = {signal["name"]: signal for signal in b["signals"]}
    assert column(signals["heading"]["values"])[-1] == pytest.approx(650.0)
    assert signals["heading"]["unit"] == "deg"
    assert not {"latitude", "longitude"} & set(signals)
    assert "thinned out to 20,000 for each aircraft" in page
    save_tracks(tmp_path / "short.html", [first.at_most(1000)])
    assert "thinned out" not in (tmp_path / "short.html").read_text(encoding="utf-8")


def test_a_long_flight_is_thinned_out_and_keeps_its_end():
    track = climbing_turn(n=1001).at_most(100)
    assert track.time.tolist() == pytest.approx([*np.arange(0, 251, 2.5)], abs=0.25)
    assert (track.time[0], track.time[-1]) == (0.0, 250.0)
    assert track.signals["elevator"].tolist() == np.sin(track.time).tolist()
    assert climbing_turn().at_most(121).time.size == 121
    assert climbing_turn(n=1).at_most(1).time.size == 1
    assert climbing_turn(n=2).at_most(1).time.tolist() == [0.0, 0.25]


ONE = [climbing_turn(n=3)]


@pytest.mark.parametrize(
    ("name", "tracks", "start", "text"),
    [
        ("flight.acm", ONE, None, "flight.acmi'?"),
        ("flight", ONE, None, "must end in .csv or .parquet or .acmi or .kml or .html"),
        ("flight.csv", [], None, "one or more with different names"),
        ("flight.csv", ONE * 2, None, "one or more with different names"),
        ("flight.csv", None, None, "must be one Track or a list of them, not None"),
        ("flight.csv", ONE, "now", "start must be a datetime"),
        ("flight.kml", ONE, datetime.datetime.max, "end after the year 9999"),
        ("nowhere/flight.csv", ONE, None, "no directory"),
    ],
)
def test_what_cannot_be_saved_is_refused(name, tracks, start, text, tmp_path):
    with pytest.raises(ParameterError, match=re.escape(text)):
        save_tracks(tmp_path / name, tracks, start)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("package", "ending"), [("pandas", "csv"), ("plotly", "html")])
def test_a_missing_package_names_its_extra(package, ending, tmp_path, monkeypatch):
    for module in [m for m in sys.modules if m.partition(".")[0] == package]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError) as error:
        save_tracks(tmp_path / f"flight.{ending}", [climbing_turn()])
    assert error.value.extra == "tracks"


@pytest.mark.parametrize(
    ("start", "written"),
    [
        (None, "2024-03-20T12:00:00.000Z"),  # noon of an equinox
        (START.replace(tzinfo=None), "2025-06-01T09:30:00.000Z"),
    ],
)
def test_when_a_flight_starts(start, written, tmp_path):
    save_tracks(tmp_path / "flight.acmi", ONE, start)
    text = (tmp_path / "flight.acmi").read_text(encoding="utf-8-sig")
    assert f"ReferenceTime={written}" in text


COLUMNS = ("time", "lat", "lon", "h", "theta", "phi", "psi")


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"lat": [91.0, 0.0]}, r"lat must lie in \[-90, 90\] deg, not 91"),
        ({"lon": [0.0]}, r"lon has the shape \(1,\), time has \(2,\)"),
        ({"h": [0.0, np.nan]}, "h must be finite, not nan"),
        ({"time": [0.0, 0.0]}, "time must increase"),
        ({"every_step": 5}, "every_step must be True or False"),
        ({"psi": "north"}, "psi must be a real number"),
        ({"signals": {"a": [[0.0, 1.0]]}}, r"a has the shape \(1, 2\)"),
        ({key: [[0.0, 1.0]] for key in COLUMNS}, r"time has the shape \(1, 2\)"),
        ({key: [] for key in COLUMNS}, r"time has the shape \(0,\)"),
    ],
)
def test_a_track_checks_its_columns(change, text):
    columns = {key: [0.0, 1.0] for key in COLUMNS}
    with pytest.raises(ParameterError, match=text):
        Track("one", "c172p", **{**columns, **change})


def test_a_track_may_cross_a_pole_and_cannot_be_changed():
    columns = {key: [0.0, 1.0] for key in COLUMNS}
    track = Track("one", "c172p", **{**columns, "lat": [89.0, 90.0], "lon": [0.0, 180.0]})
    assert track.lat[1] == 90.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        track.name = "two"
