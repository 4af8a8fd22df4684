"""What `recorded_flights` keeps of a flight, against a scope, and the command that writes it."""

import math
import os

import numpy as np
import pandas
import pytest
from pathsim import Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Integrator
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, TrimCondition, fly
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.tracks.recording import recorded_flights, tracks

PORTS = {
    "lat": "latitude [deg]",
    "lon": "longitude [deg]",
    "h": "altitude [ft]",
    "theta": "pitch angle [deg]",
    "phi": "roll angle [deg]",
    "psi": "heading [deg]",
    "vc": "calibrated airspeed [kt]",
    "q": "pitch rate [deg/s]",
    "nz": "vertical load factor [g]",
}


def kicked(*more, **keywords):
    plane = Aircraft("c172p", speed=90, **keywords)
    kick = DoubletSource(0.2, start=0.1, width=0.2)
    return diagram(plane, PORTS, {"elevator": kick}, others=more, dt=1 / 120)


def same(track, scope):
    time, data = scope.read()
    at = np.searchsorted(time, track.time - 1e-9)
    assert track.time == pytest.approx(time[at], abs=1e-9)
    for label, values in zip(PORTS.values(), data, strict=True):
        assert np.array_equal(track.columns[label], values[at]), label


@pytest.mark.parametrize("run", [Simulation.run, fly])
@pytest.mark.parametrize("more", [[], [Integrator()]], ids=["one pass", "with stages"])
def test_a_recording_is_what_a_scope_sees(run, more):
    with recorded_flights() as recordings:
        sim, scope = kicked(*[type(b)() for b in more])
    run(sim, 0.5)
    run(sim, 0.25)
    [track] = tracks(recordings)
    assert len(track.time) == 91
    same(track, scope)
    sim.reset()
    assert tracks(recordings) == []  # nothing flown yet
    run(sim, 0.3)
    [track] = tracks(recordings)
    assert len(track.time) == 37
    same(track, scope)


def test_other_rates():
    with recorded_flights() as recordings:
        sim, scope = kicked(T=1 / 30, substeps=4)
        sim.run(0.5)
        other, again = kicked(T=1 / 30, substeps=4)
        other.run(1.0)
    first, second = tracks(recordings)
    assert (first.name, second.name) == ("c172p 1", "c172p 2")
    assert first.time == pytest.approx(np.arange(16) / 30)
    same(first, scope)
    same(second, again)
    assert np.array_equal(second.h[:16], first.h)
    assert second.about["JSBSim steps per s"] == "120"


def test_an_interrupt_leaves_no_gap_and_no_row_too_many():
    with recorded_flights() as recordings:
        sim, scope = kicked()
    plane, calls = sim.blocks[0], []
    run, *others = plane._bound

    def interrupted():
        calls.append(0)
        if len(calls) == 20:
            raise KeyboardInterrupt
        run()

    plane._bound = (interrupted, *others)
    with pytest.raises(KeyboardInterrupt):
        sim.run(0.5)
    assert tracks(recordings)[0].time[-1] == pytest.approx(19 / 120)
    sim.run(0.25)
    assert np.diff(tracks(recordings)[0].time) == pytest.approx(1 / 120)
    same(tracks(recordings)[0], scope)


# label: the property and its factor, from the label's unit
RECORDED = {
    "height above ground [ft]": ("position/h-agl-ft", 1.0),
    "rate of climb [ft/s]": ("velocities/h-dot-fps", 1.0),
    "true airspeed [kt]": ("velocities/vt-fps", 3600 * 0.3048 / 1852),
    "Mach number": ("velocities/mach", 1.0),
    "angle of attack [deg]": ("aero/alpha-rad", 180 / math.pi),
    "sideslip angle [deg]": ("aero/beta-rad", 180 / math.pi),
    "flight path angle [deg]": ("flight-path/gamma-rad", 180 / math.pi),
    "roll rate [deg/s]": ("velocities/p-rad_sec", 180 / math.pi),
    "yaw rate [deg/s]": ("velocities/r-rad_sec", 180 / math.pi),
    "longitudinal load factor [g]": ("accelerations/Nx", 1.0),
    "elevator": ("fcs/elevator-pos-norm", 1.0),
    "left aileron": ("fcs/left-aileron-pos-norm", 1.0),
    "right aileron": ("fcs/right-aileron-pos-norm", 1.0),
    "rudder": ("fcs/rudder-pos-norm", 1.0),
    "flaps": ("fcs/flap-pos-norm", 1.0),
    "throttle": ("fcs/throttle-cmd-norm", 1.0),
    "thrust of engine 1 [lbf]": ("propulsion/engine/thrust-lbs", 1.0),
    "fuel [lb]": ("propulsion/total-fuel-lbs", 1.0),
    "weight [lb]": ("inertia/weight-lbs", 1.0),
}


def test_every_signal_is_what_its_label_says():
    inputs = {"elevator": 0.05, "aileron": 0.1, "rudder": 0.2, "throttle": -0.1}
    moved = {port: Constant(value) for port, value in inputs.items()}
    with recorded_flights() as recordings:
        plane = Aircraft("c172p", condition=TrimCondition(speed=90, flaps=0.3))
    diagram(plane, sources=moved)[0].run(1.0)
    [track] = tracks(recordings)
    assert {*RECORDED, *PORTS.values()} >= {*track.columns} - {"speed brake", "gear"}
    for label, (name, factor) in RECORDED.items():
        value = plane.fdm[name] * factor
        assert value != 0.0, label
        assert track.columns[label][-1] == pytest.approx(value, rel=1e-6), label


def test_several_aircraft_and_what_a_model_lacks():
    with recorded_flights() as recordings:
        fdm = JSBSimFDM(aircraft_model="c172p", trim_airspeed=90, trim_altitude=5000)
        ball = JSBSimFDM(aircraft_model="ball", trim_mode="none")
        Simulation([Subsystem([Interface(), fdm]), ball], dt=1 / 120, log=False).run(0.5)
        Aircraft("c172p", speed=90)  # does not fly
    first, second = tracks(recordings)
    assert (first.name, second.name) == ("c172p", "ball")
    assert "elevator" in first.signals
    assert "left aileron" not in second.signals or np.ptp(second.signals["left aileron"]) == 0
    # no lift and no thrust
    assert second.h[-1] < second.h[0] - 3


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="a device of Linux")
def test_the_command_writes_every_track_that_is_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "full.csv").symlink_to("/dev/full")
    files = ("one.csv", "full.csv", "two.acmi", "three.kml")
    options = [option for file in files for option in ("--track", file)]
    assert main(["run", "hello_jsbsim", "--duration", "1", *options]) == 1
    said = capsys.readouterr()
    assert said.out.index("one.csv") < said.out.index("two.acmi")
    assert "No space left" in said.err
    assert (tmp_path / "two.acmi").exists()
    table = pandas.read_csv(tmp_path / "one.csv", index_col=0)
    assert np.diff(table.index) == pytest.approx(1 / 120)
    assert table["calibrated airspeed [kt]"].iloc[0] == pytest.approx(80)
    # 5 points per second for Google Earth
    assert (tmp_path / "three.kml").read_text(encoding="utf-8").count("<when>") == 6


CRASH = """
from pathsim import Connection, Simulation
from pathsim.blocks import Source
from pathsim_jsbsim_blocks import Aircraft

one, two = Aircraft("c172p", speed=90), Aircraft("A4", 1e4, 300, gear=0)
fault = Source(lambda t: float("nan") if t > 0.3 else 0.0)
wires = [Connection(fault, one["elevator"])]
Simulation([one, two, fault], wires, dt=1 / 120, log=False).run(60)
"""


def test_the_command_writes_the_track_of_a_flight_that_ends_early(tmp_path, capsys):
    (tmp_path / "script.py").write_text(CRASH)
    path = tmp_path / "two.csv"
    assert main(["run", str(tmp_path / "script.py"), "--track", str(path)]) == 1
    assert "'elevator' is nan" in capsys.readouterr().err
    table = pandas.read_csv(path, index_col=["aircraft", "time [s]"])
    assert set(table.index.get_level_values(0)) == {"c172p", "A4"}
    assert table.loc["c172p"].index[-1] == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["step_response", "--track", "a.csv"], "the script flies no aircraft"),
        (["hello_jsbsim", "--track", "a.kmz"], "did you mean 'a.kml'"),
        (["hello_jsbsim", "--flightgear", "127.0.0.1:"], "must be HOST:PORT"),
    ],
)
def test_the_command_refuses_what_has_no_track(arguments, text, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("DISPLAY", raising=False)
    assert main(["run", *arguments]) == 1
    assert text in capsys.readouterr().err


WRAPPER = """
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
from pathsim_flight import JSBSimWrapper
from pathsim_jsbsim_blocks import Aircraft

plane = JSBSimWrapper(T=1 / 60, input_properties=["fcs/elevator-cmd-norm"],
                      output_properties=["attitude/theta-deg"])
zero = Constant(0.0)
{aircraft}
sim = Simulation([zero, plane, *others], [Connection(zero, plane)], dt=1 / 60, log=False)
sim.run(0.1)
"""
OTHER = "others = [Aircraft('c172p', altitude=5000, speed=90, T=1 / 60)]"


@pytest.mark.parametrize(("more", "status"), [("others = []", 1), (OTHER, 0)])
def test_a_wrapper_that_leaves_no_track_is_named_before_the_run(more, status, tmp_path, capsys):
    script, path = tmp_path / "script.py", tmp_path / "a.csv"
    script.write_text(WRAPPER.format(aircraft=more))
    assert main(["run", str(script), "--track", str(path)]) == status
    printed = capsys.readouterr()
    assert printed.err.startswith("pathsim-jsbsim: JSBSimWrapper of pathsim-flight leaves no track")
    assert path.exists() == (status == 0)


TWO = """
import sys
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope
from pathsim_jsbsim_blocks import Aircraft

Simulation([Constant(1.0)], dt=0.1, log=False).run(0.2)


def main():
    plane, scope = Aircraft("c172p", altitude=5000, speed=90), Scope()
    sim = Simulation([plane, scope], [Connection(plane, scope)], dt=1 / 120, log=False)
    sim.run(0.1)


{end}
"""


@pytest.mark.parametrize(
    ("end", "status"), [("main()", 0), ("sys.exit(main())", 0), ("main()\n1 / 0", 1)]
)
def test_a_second_run_within_a_function_leaves_a_track_and_its_signals(
    end, status, tmp_path, capsys
):
    script, track, signals = tmp_path / "script.py", tmp_path / "a.csv", tmp_path / "b.csv"
    script.write_text(TWO.format(end=end))
    command = ["run", str(script), "--track", str(track), "--csv", str(signals)]
    if "exit" in end:
        with pytest.raises(SystemExit):
            main(command)
    else:
        assert main(command) == status
    assert len(track.read_text().splitlines()) > 10
    assert len(signals.read_text().splitlines()) > 10
    assert "no JSBSim aircraft flies in this run" in capsys.readouterr().err


def test_no_package_is_missed_after_a_flight(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    assert main(["run", "hello_jsbsim", "--track", str(tmp_path / "a.csv")]) == 1
    said = capsys.readouterr()
    assert "pip install" in said.err
    assert said.out == ""
