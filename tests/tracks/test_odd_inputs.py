"""Odd text, dates and numbers: a file that an independent reader takes, or a typed error."""

import csv
import datetime
import html
import json
import warnings

import fastkml
import numpy as np
import pandas
import pyacmi
import pytest
from lxml import etree

from pathsim_jsbsim_blocks import FlightRecorder
from pathsim_jsbsim_blocks.errors import BlocksError, FileError, ParameterError
from pathsim_jsbsim_blocks.tracks import Track, save_tracks

UTC = datetime.timezone.utc
SIX = ("lat", "lon", "h", "theta", "phi", "psi")

TEXTS = [
    *(chr(i) for i in (*range(33), 0x7F, 0x80, 0x85, 0x9F, 0xA0, 0xAD, 0x200B, 0x2028, 0x2029)),
    *("\ud800", "\udfff", "\ud83d\ude00", "\ufdd0", "\ufeff", "\ufffe", "\uffff", "\U0001f600"),
    *("a\0b", "a\rb", "a\r\nb", "a\nb", " a ", "a,b", "a;b", 'a"b', "a'b", "a=b", "a|b", "#1", "-1"),
    *("a\\", "a\\,b", "a\\nb", "\\", "<b>a</b>", "</script>", "]]>", "&amp;", "&#0;", "<!--DATA-->"),
    *("<!--PLOTLY-->", "=1+1", "@a", "nan", "", "[ft]", "a [ft", "a []", "$x$", "{}", "%s", "é" * 300),
    *("latitude [deg]", "time [s]", "aircraft", "elevator", "elevator [deg]", "index"),
]  # fmt: skip
NO_TEXTS = [None, 1, b"a", ("a",), float("nan"), object()]

DATES = [
    datetime.datetime.min,
    datetime.datetime.max,
    datetime.datetime.max.replace(tzinfo=UTC),
    datetime.datetime(9999, 12, 31, 23, 59, 59),
    datetime.datetime(9999, 12, 31, 23, 59, 58, tzinfo=datetime.timezone(-datetime.timedelta(hours=1))),
    datetime.datetime(1, 1, 1, tzinfo=datetime.timezone(datetime.timedelta(hours=1))),
    datetime.datetime(1, 1, 1, tzinfo=datetime.timezone(-datetime.timedelta(hours=1), "\ud800<b>")),
    datetime.datetime(999, 1, 1, 1, 1, 1, 1),
    pandas.Timestamp("2024-03-20 12:00:00.123456789"),
    pandas.Timestamp.max,
    pandas.NaT,
    datetime.date(2024, 3, 20),
    *("now", 0, 1e300, float("nan"), [], datetime.time(12), np.datetime64("2024-03-20")),
]  # fmt: skip

NUMBERS = [
    *(0.0, -0.0, 1e-320, 1e-7, 179.999999999, 180.0, -540.0, 1e5, 1e16, 1e39, 1e300, -1e308),
    *(float("nan"), float("inf"), -float("inf"), 10**400, True, None, "1", 1j),
]


def track(
    name="one", aircraft="c172p", label="elevator", about=None, values=(0.1, 0.2, 0.3), **columns
):
    """One of three samples."""
    columns = {name: [0.0, 1.0, 2.0] for name in ("time", *SIX)} | columns
    return Track(name, aircraft, **columns, signals={label: list(values)}, about=about or {})


def read_csv(path, tracks, start):
    with path.open(encoding="utf-8", newline="") as file:
        rows = list(csv.reader(file))
    assert {len(row) for row in rows} == {len(rows[0])}
    table = pandas.read_csv(path)
    assert len(table) == sum(len(one.time) for one in tracks)
    assert np.array_equal(table["time [s]"], np.concatenate([one.time for one in tracks]))
    for one in tracks:
        for label, column in one.columns.items():
            values = [float(row[rows[0].index(label)] or "nan") for row in rows[1:]]
            assert np.array_equal(values[: len(column)], column, equal_nan=True)


def read_parquet(path, tracks, start):
    table = pandas.read_parquet(path)
    if len(tracks) > 1:
        assert list(dict.fromkeys(table.index.get_level_values(0))) == [one.name for one in tracks]
    for label, column in tracks[0].columns.items():
        assert np.array_equal(table[label].iloc[: len(column)], column, equal_nan=True)


def read_acmi(path, tracks, start):
    read = pyacmi.Acmi()
    read.load_acmi(str(path))
    date = str(read.reference_time)
    assert start is None or date.startswith(f"{start:%m-%d %H:%M:%S}", 5), date
    assert sorted(read.objects) == [f"{n}" for n in range(1, len(tracks) + 1)]
    times = {float(t) for one in tracks for t in one.time}
    assert len(read.timeframes) == len(times)
    assert read.timeframes == pytest.approx(sorted(times), rel=1e-12, abs=1e-9)
    for identity, one in zip(read.objects, tracks, strict=True):
        name = read.objects[identity].get_value("CallSign").replace("\\,", ",")
        assert name == " ".join(one.name.split()).replace("\\", "/")


def read_kml(path, tracks, start):
    etree.parse(path)
    marks = fastkml.KML.parse(path).features[0].features
    for mark, one in zip(marks, tracks, strict=True):
        assert (mark.name or "") == one.name.strip()
        text = mark.description or ""
        assert html.unescape(text).startswith(one.aircraft.strip())
        assert "<" not in text.replace("<br>", "")
        whens = [when.dt for when in mark.kml_geometry.whens]
        assert len(whens) == len(one.time)
        if start is not None:
            assert whens[0] == start + datetime.timedelta(seconds=one.time[0])
    text = path.read_text(encoding="utf-8")
    for value in text.split("<gx:value>")[1:]:
        value = value.partition("</gx:value>")[0]
        assert value in ("NaN", "INF", "-INF") or np.isfinite(float(value))


def read_html(path, tracks, start):
    page = etree.HTML(path.read_text(encoding="utf-8"))
    head = "".join(page.xpath("//dl")[0].itertext())
    assert all(" ".join(one.aircraft.split()) in " ".join(head.split()) for one in tracks)
    assert page.xpath("//dl//*[not(self::dt or self::dd)]") == []
    assert len(page.xpath("//script")) == 3
    data = json.loads(page.xpath("//script[@id='data']")[0].text)
    assert [aircraft["name"] for aircraft in data["aircraft"]] == [one.name for one in tracks]


READERS = {
    "csv": read_csv,
    "parquet": read_parquet,
    "acmi": read_acmi,
    "kml": read_kml,
    "html": read_html,
}


def odd_inputs():
    """Functions that make tracks, and a date."""
    for text in [*TEXTS, *NO_TEXTS]:
        yield lambda text=text: [track(name=text)], None
        yield lambda text=text: [track(name=text), track(name="two")], None
        yield lambda text=text: [track(aircraft=text)], None
        yield lambda text=text: [track(label=text)], None
        yield lambda text=text: [track(about={text: "a", "b": text})], None
    for date in DATES:
        yield lambda: [track()], date
    for number in NUMBERS:
        yield lambda number=number: [track(values=[0.0, number, 0.0])], None
        for column in SIX:
            yield lambda number=number, column=column: [track(**{column: [0.0, number, 0.0]})], None
        if isinstance(number, float):
            time = [number, number + 1, number + 2]
            yield lambda time=time: [track(time=time)], None
            yield lambda number=number: [track(time=[-1.0, 0.0, number])], None


# all take a minute; the others are every kind of field, date and number by turns
@pytest.mark.parametrize("step", [13, pytest.param(1, marks=pytest.mark.long)])
@pytest.mark.parametrize("ending", READERS)
def test_odd_inputs_give_a_file_that_others_read_or_a_typed_error(
    ending, step, tmp_path, monkeypatch
):
    monkeypatch.setattr("plotly.offline.get_plotlyjs", lambda: "plotly")  # 4 MB in each file
    path = tmp_path / f"flight.{ending}"
    inputs = list(odd_inputs())[::step]
    written = 0
    for tracks, start in inputs:
        path.unlink(missing_ok=True)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                made = tracks()
                save_tracks(path, made, start)
        except BlocksError:
            assert list(tmp_path.iterdir()) == []
            continue
        written += 1
        if start is not None:
            start = datetime.datetime.combine(start.date(), start.timetz())  # no nanoseconds
            start = start.replace(tzinfo=start.tzinfo or UTC).astimezone(UTC)
        READERS[ending](path, made, start)
    assert len(inputs) / 2 < written < len(inputs)


def test_text_that_files_cannot_hold_is_named():
    for make in (track, FlightRecorder):
        with pytest.raises(ParameterError) as error:
            make(name="a\7")
        assert (error.value.parameter, error.value.value) == ("name", "a\x07")
    with pytest.raises(ParameterError) as error:
        FlightRecorder(signals=["\ud800 [ft]"])
    assert (error.value.parameter, error.value.value) == ("signals", "\ud800 [ft]")
    with pytest.raises(ParameterError) as error:
        track(label="latitude [deg]")
    assert (error.value.parameter, error.value.value) == ("signals", "latitude [deg]")


@pytest.mark.parametrize("ending", READERS)
def test_a_file_that_cannot_be_written_whole_leaves_the_one_before(ending, tmp_path):
    resource = pytest.importorskip("resource")
    path = tmp_path / f"flight.{ending}"
    save_tracks(path, track())
    before = path.read_bytes()
    time = np.arange(2000) / 10
    long = Track("long", "c172p", time, *[np.sin(time)] * 6)
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, hard))
    try:
        with pytest.raises(FileError, match="File too large"):
            save_tracks(path, long)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
