"""`FlightRecorder` against a scope at the same wires."""

import numpy as np
import pandas
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, FlightRecorder, ParameterError
from pathsim_jsbsim_blocks.plots import signal, time_histories
from pathsim_jsbsim_blocks.tracks import to_frame

SIX = ("lat", "lon", "h", "theta", "phi", "psi")


def diagram(**keywords):
    plane, kick = Aircraft("c172p", speed=90), DoubletSource(0.2, start=0.1, width=0.2)
    recorder = FlightRecorder(
        "c172p", signals=["calibrated airspeed [kt]", "q [deg/s]"], **keywords
    )
    scope = Scope()
    sim = Simulation(
        [plane, kick, recorder, scope],
        [
            Connection(kick, plane["aileron"]),
            *(Connection(plane[n], recorder[n], scope[i]) for i, n in enumerate(SIX)),
            Connection(plane["vc"], recorder["calibrated airspeed"], scope[6]),
            Connection(plane["q"], recorder[7], scope[7]),
        ],
        dt=1 / 120,
        log=False,
    )
    return sim, recorder, scope


def test_it_records_what_a_scope_records():
    sim, recorder, scope = diagram()
    sim.run(1.0)
    time, data = scope.read()
    track = recorder.to_track()
    assert np.array_equal(track.time, time)
    for name, values in zip(SIX, data, strict=False):
        assert np.array_equal(getattr(track, name), values)
    assert np.array_equal(track.signals["calibrated airspeed [kt]"], data[6])
    table = recorder.to_frame()
    assert table.index.name == "time [s]"
    assert table["q [deg/s]"].iloc[-1] == data[7, -1]
    # a scope for the figures too
    assert np.array_equal(signal(recorder, "heading")[1], data[5])
    assert time_histories(recorder).axes
    sim.reset()
    with pytest.raises(ParameterError) as error:
        recorder.to_track()
    assert error.value.parameter == "scope"
    sim.run(0.5)
    assert np.array_equal(recorder.to_track().h, data[2, :61])


def test_a_sampling_period_and_a_waiting_time():
    sim, recorder, _ = diagram(sampling_period=0.25, t_wait=0.5)
    sim.run(1.0)
    assert recorder.to_track().time == pytest.approx([0.5, 0.75, 1.0])


def test_it_saves_by_the_ending(tmp_path):
    # Google Earth gets every sample of a sampling period that is given
    for period, points in ((None, 4), (0.05, 11), (1 / 120, 61)):
        sim, recorder, _ = diagram(sampling_period=period, name="the one")
        sim.run(0.5)
        recorder.save(tmp_path / "flight.kml")
        assert (tmp_path / "flight.kml").read_text(encoding="utf-8").count("<when>") == points
    recorder.save(tmp_path / "flight.csv")
    table = pandas.read_csv(tmp_path / "flight.csv", index_col=0)
    pandas.testing.assert_frame_equal(table, recorder.to_frame())
    recorder.save(str(tmp_path / "flight.acmi"))
    assert "Name=c172p,CallSign=the one" in (tmp_path / "flight.acmi").read_text(encoding="utf-8")


def test_a_scope_as_a_table():
    _, recorder, _ = diagram()
    with pytest.raises(ParameterError) as error:
        to_frame(recorder)
    assert error.value.parameter == "scope"
    scope = Scope(labels=["height [ft]"])
    kick = DoubletSource(2.0, start=0.1, width=0.1)
    Simulation([kick, scope], [Connection(kick, scope[0], scope[1])], dt=0.1, log=False).run(0.5)
    table = to_frame(scope)
    assert list(table.columns) == ["height [ft]", "port 1"]
    assert table.loc[table.index[-2], "port 1"] == scope.read()[1][1, -2]


@pytest.mark.parametrize(
    ("keywords", "text"),
    [
        ({"signals": "speed [kt]"}, "must be a list of labels"),
        ({"signals": [1]}, "must be a list of labels"),
        ({"signals": ["h [m]"]}, "has 'h' twice, or it is a port of every recorder"),
        ({"aircraft": 172}, "aircraft must be text"),
        ({"sampling_period": 0}, "sampling_period must be greater than 0"),
        ({"t_wait": -1}, "t_wait must be at least 0"),
    ],
)
def test_bad_parameters_are_refused(keywords, text):
    with pytest.raises(ParameterError, match=text):
        FlightRecorder(**keywords)


def test_its_ports_are_those_of_its_signals():
    recorder = FlightRecorder(signals=["a [ft]"])
    assert recorder["a"].ports == ["a"]
    with pytest.raises(ParameterError) as error:
        recorder["as"]
    assert (error.value.parameter, error.value.value) == ("port", "as")
    assert "'a'" in str(error.value)
    with pytest.raises(ParameterError) as error:
        recorder.signals = ["a [ft]", "b"]
    assert (error.value.parameter, error.value.value) == ("signals", ["a [ft]", "b"])
    assert recorder.labels[6:] == ["a [ft]"]
