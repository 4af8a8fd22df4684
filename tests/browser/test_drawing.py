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

LABELS = ["pitch angle [deg]", "reference [deg]"]
SIZE = {"width": 1200, "height": 800}  # px: small enough for the text to be read on a page


class Drawing:
    """What a hand does in the editor."""

    def __init__(self, page):
        self.page = page
        # a browser's own file dialogs are out of reach; without them PathView downloads and uploads
        page.add_init_script("delete window.showSaveFilePicker; delete window.showOpenFilePicker")

    def place(self, kind, x, y):
        """Drag a block from the library to the canvas."""
        self.page.fill(".node-library .search-input", kind)
        name = self.page.get_by_text(kind, exact=True)
        tile = self.page.locator(".node-library .node-tile").filter(has=name)
        tile.drag_to(self.page.locator(".svelte-flow__pane"), target_position={"x": x, "y": y - 40})
        self.block(kind).wait_for()

    def block(self, kind):
        name = self.page.locator(".node-type").get_by_text(kind, exact=True)
        return self.page.locator(".svelte-flow__node").filter(has=name)

    def port(self, kind, direction, name):
        """A port by its name, which the canvas cuts to 8 characters."""
        block = {"Aircraft": Aircraft, "PitchHold": PitchHold}.get(kind)
        labels = getattr(block, f"{direction}_port_labels", None)
        index = labels[name] if labels else int(name)
        return self.block(kind).locator(f".handle-{direction}").nth(index)

    def wire(self, source, target):
        """Drag from an output to an input."""
        before = self.page.locator(".svelte-flow__edge").count()
        self.port(source[0], "output", source[1]).drag_to(self.port(target[0], "input", target[1]))
        self.page.wait_for_function(
            "count => document.querySelectorAll('.svelte-flow__edge').length === count",
            arg=before + 1,
        )

    def add_input(self, kind):
        self.block(kind).click()
        self.block(kind).get_by_title("Add input").click()
        self.page.locator(".svelte-flow__pane").click(position={"x": 1100, "y": 700})

    def open(self, kind):
        """Double-click a block: its dialog."""
        box = self.block(kind).bounding_box()
        self.block(kind).dblclick(position={"x": box["width"] / 2, "y": 8})
        return self.page.locator(".properties-dialog")

    def set(self, kind, **parameters):
        dialog = self.open(kind)
        for name, text in parameters.items():
            label = self.page.get_by_text(name, exact=True)
            dialog.locator(".param-item").filter(has=label).locator("input").fill(text)
        return dialog

    def close(self, dialog):
        dialog.locator("button[aria-label='Close']").click()
        dialog.wait_for(state="detached")

    def panel(self, name):
        self.page.click(f"button[aria-label='{name}']")
        self.page.wait_for_timeout(300)  # it slides


@pytest.fixture
def picture(request, editor):
    """Take a picture for the page, if the command line asks for it."""
    folder = request.config.getoption("--screenshots", None)

    def take(name):
        if folder:
            editor.page.mouse.move(600, 795)  # no tooltip
            editor.page.wait_for_timeout(600)  # what moves comes to rest
            editor.page.screenshot(path=f"{folder}/drawing_{name}.png")

    return take


@pytest.fixture
def editor(fresh_editor):
    """Nothing is left of other tests."""
    return fresh_editor


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


def test_a_diagram_drawn_from_nothing(editor, models, picture, tmp_path):
    page = editor.page
    drawing = Drawing(page)
    page.set_default_timeout(120_000)  # a busy machine is slow
    page.set_viewport_size(SIZE)
    page.goto(editor.url(""))
    page.wait_for_selector("button[aria-label='Run']:not([disabled])")

    drawing.panel("Blocks")
    drawing.place("Aircraft", 660, 400)
    drawing.place("Scope", 960, 240)
    drawing.place("PitchHold", 420, 620)
    picture("blocks")
    drawing.panel("Blocks")
    page.keyboard.press("l")  # the names of the ports

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
