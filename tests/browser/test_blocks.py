"""An `Aircraft` with further ports and a `FlightRecorder` in PathView: wired, flown, plotted, saved."""

import json

import numpy as np
import pytest

from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.pathview import export_script
from pathsim_jsbsim_blocks.tracks.track import POSITION

SCRIPT = """
from pathsim import Connection, Simulation
from pathsim.blocks import StepSource
from pathsim_jsbsim_blocks import Aircraft, FlightRecorder

DURATION = 2.0
plane = Aircraft("737", altitude=10000.0, speed=250.0, gear=0.0,
                 input_properties=["flaps", "throttle[1]"],
                 output_properties=["flaps", "propulsion/engine[1]/thrust-lbs"])
flaps = StepSource(0.4, 0.5)
cut = StepSource(-0.2, 0.5)
recorder = FlightRecorder(signals=["flaps [-]", "thrust [lbf]"])
sim = Simulation(
    [plane, flaps, cut, recorder],
    [Connection(flaps, plane["flaps"]), Connection(cut, plane["throttle[1]"]),
     Connection(plane["flaps"], recorder["flaps"]),
     Connection(plane["propulsion/engine[1]/thrust-lbs"], recorder["thrust"]),
     *[Connection(plane[port], recorder[port]) for port in ("lat", "lon", "h", "phi", "theta", "psi")]],
    dt=1 / 120, log=False)
if __name__ == "__main__":
    sim.run(DURATION)
"""


@pytest.mark.long
def test_further_ports_fly_and_a_recorder_is_plotted_and_writes_a_track(
    tmp_path, models, fresh_editor, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    script, editor = tmp_path / "further.py", fresh_editor
    script.write_text(SCRIPT)
    models["further.pvm"] = json.loads(export_script(script).read_text())
    editor.open("further.pvm")
    (_, shown, ports) = next(b for b in editor.blocks() if b[0] == "plane")
    assert ports == 9 + 24
    names = shown.splitlines()[-33:]
    assert (names[7:9], names[-2:]) == (["flaps", "throttle[1]"], ["flaps", "thrust-lbs"])
    assert editor.run() == "Simulation completed successfully"
    assert editor.complaints() == []
    diagram = load_diagram(str(script))
    diagram.sim.run(diagram.DURATION)
    expected = diagram.recorder.read()[1]
    streamed = editor.runs[-1]["recorder"][1]
    np.testing.assert_allclose(streamed, expected, rtol=1e-12, atol=1e-12)
    assert np.ptp(expected, axis=1).all()
    editor.page.wait_for_function(
        "count => document.querySelectorAll('.js-plotly-plot .trace').length === count",
        arg=len(POSITION) + 2,
    )
    assert "Connection(plane[23], recorder[7])" in editor.python()

    model, track = tmp_path / "saved.pvm", tmp_path / "flight.csv"
    model.write_text(json.dumps(editor.saved()))
    assert main(["run", str(model), "--trust", "--track", str(track)]) == 0
    written = np.genfromtxt(track, delimiter=",", skip_header=1, usecols=range(1, 7)).T
    np.testing.assert_allclose(written, expected[:6], rtol=1e-9, atol=1e-9)
    assert not editor.errors
