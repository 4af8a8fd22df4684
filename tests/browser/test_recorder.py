"""A `FlightRecorder` in PathView: drawn, wired, plotted; the saved model writes a file."""

import numpy as np
import pytest
from pathsim import Connection, Simulation

from pathsim_jsbsim_blocks import Aircraft, FlightRecorder
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.tracks.track import POSITION

from .editor import Drawing


@pytest.fixture
def editor(fresh_editor):
    """Nothing is left of other tests."""
    return fresh_editor


def by_hand():
    """The same diagram as a script, flown."""
    plane, recorder = Aircraft(), FlightRecorder()
    wires = [Connection(plane[port], recorder[port]) for port in POSITION]
    Simulation([plane, recorder], wires, dt=1 / 120, log=False).run(2.0)
    return recorder.read()


# test_drawing draws by hand in each run of the tests
@pytest.mark.long
def test_a_recorder_is_plotted_and_its_model_writes_a_track(editor, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "agg")
    page = editor.page
    drawing = Drawing(page)
    editor.open_empty()
    drawing.panel("Blocks")
    drawing.place("Aircraft", 520, 450)
    drawing.place("FlightRecorder", 900, 450)
    drawing.panel("Blocks")
    for port in POSITION:
        drawing.wire(("Aircraft", port), ("FlightRecorder", port))
    drawing.panel("Simulation")
    page.fill("#duration", "2.0")
    page.fill("#dt", "1/120")
    drawing.panel("Simulation")

    assert editor.run() == "Simulation completed successfully"
    assert not editor.complaints()
    page.locator(".js-plotly-plot .trace path").first.wait_for(state="attached")
    assert page.locator(".js-plotly-plot .trace").count() == len(POSITION)
    [(time, signals)] = editor.runs[-1].values()
    expected_time, expected = by_hand()
    np.testing.assert_allclose(time, expected_time, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(signals, expected, rtol=1e-12, atol=1e-12)
    assert np.ptp(expected, axis=1)[:3].any()

    with page.expect_download() as download:
        page.click("button[aria-label='Save']")
    model, track = tmp_path / "drawn.pvm", tmp_path / "flight.csv"
    download.value.save_as(model)
    assert main(["run", str(model), "--trust", "--track", str(track)]) == 0
    assert f"track saved: {track}" in capsys.readouterr().out
    written = np.genfromtxt(track, delimiter=",", skip_header=1, usecols=range(7)).T
    np.testing.assert_allclose(written[1:], expected, rtol=1e-9, atol=1e-9)
    assert not editor.errors
