"""docs/drawing.md, step by step: a diagram is drawn in an empty editor, set, run, saved and exported.

``pytest tests/browser/test_drawing.py --screenshots docs/pictures`` takes the page's pictures.
"""

import json
import runpy

import matplotlib.pyplot as plt
import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, PitchHold
from pathsim_jsbsim_blocks.pathview import convert_model

from .editor import Drawing

LABELS = ["pitch angle [deg]", "reference [deg]"]


@pytest.fixture
def picture(request, fresh_editor):
    """Take a picture for the page, if the command line asks for it."""
    folder = request.config.getoption("--screenshots", None)

    def take(name):
        if folder:
            fresh_editor.page.mouse.move(600, 795)  # no tooltip
            fresh_editor.page.wait_for_timeout(600)  # what moves comes to rest
            fresh_editor.page.screenshot(path=f"{folder}/drawing_{name}.png")

    return take


def by_hand():
    """The same diagram as a script, flown."""
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0)
    hold = PitchHold(gains="c172p", theta_ref=3.0)
    scope = Scope(labels=LABELS)
    sim = Simulation(
        [plane, hold, scope],
        [
            Connection(plane["theta"], hold["theta"], scope[0]),
            Connection(plane["q"], hold["q"]),
            Connection(hold["elevator"], plane["elevator"]),
            Connection(hold["theta_cmd"], scope[1]),
        ],
        dt=1 / 120,
        log=False,
    )
    sim.run(20.0)
    return scope.read()


@pytest.mark.long
def test_a_diagram_drawn_from_nothing(fresh_editor, models, picture, tmp_path):
    editor = fresh_editor  # nothing is left of other tests
    page = editor.page
    drawing = Drawing(page)
    editor.open_empty()

    drawing.panel("Blocks")
    drawing.place("Aircraft", 660, 400)
    drawing.place("Scope", 960, 240)
    drawing.place("PitchHold", 420, 620)
    picture("blocks")
    drawing.panel("Blocks")

    drawing.add_input("Scope")
    drawing.close(drawing.set("Aircraft", altitude="5000.0", speed="90.0"))
    drawing.close(drawing.set("Scope", labels=json.dumps(LABELS)))
    dialog = drawing.set("PitchHold", theta_ref="3.0")
    picture("parameters")
    drawing.close(dialog)

    drawing.wire(("Aircraft", "theta"), ("PitchHold", "theta"))
    drawing.wire(("Aircraft", "q"), ("PitchHold", "q"))
    drawing.wire(("PitchHold", "elevator"), ("Aircraft", "elevator"))
    drawing.wire(("Aircraft", "theta"), ("Scope", 0))
    drawing.wire(("PitchHold", "theta_cmd"), ("Scope", 1))
    picture("wires")

    drawing.panel("Simulation")
    page.fill("#duration", "20.0")
    page.fill("#dt", "1/120")
    picture("simulation")
    drawing.panel("Simulation")

    assert editor.run() == "Simulation completed successfully"
    assert not editor.complaints()
    page.locator(".js-plotly-plot .trace path").first.wait_for(state="attached")
    picture("results")
    [(time, signals)] = editor.runs[-1].values()
    expected_time, expected = by_hand()
    np.testing.assert_allclose(time, expected_time, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(signals, expected, rtol=1e-12, atol=1e-12)
    assert abs(signals[0][-1] - 3.0) < 0.05

    with page.expect_download() as download:
        page.click("button[aria-label='Save']")
    assert download.value.suggested_filename == "pathview_graph.pvm"
    model = tmp_path / "pathview_graph.pvm"
    download.value.save_as(model)

    page.click("button[aria-label='View Python Code']")
    page.wait_for_selector(".export-dialog .cm-content")
    # past the imports, to the blocks
    page.locator(".export-dialog .cm-scroller").evaluate("e => { e.scrollTop = 470 }")
    picture("python")
    with page.expect_download() as download:
        page.click(".export-dialog button[aria-label='Download Python file']")
    page.click(".export-dialog button[aria-label='Close']")
    script = tmp_path / "pathview_graph.py"
    download.value.save_as(script)

    plt.switch_backend("agg")
    for written in (script, convert_model(model, tmp_path / "converted.py")):
        built = runpy.run_path(str(written), run_name="__main__")
        np.testing.assert_array_equal(built["scope"].read()[1], expected)

    # the saved model opens again
    models["drawn.pvm"] = json.loads(model.read_text(encoding="utf-8"))
    editor.open("drawn.pvm")
    assert editor.run() == "Simulation completed successfully"
    assert editor.runs[-1] == editor.runs[0]
    assert not editor.errors
