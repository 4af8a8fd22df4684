"""``pathsim-jsbsim view`` in a fresh browser profile, and how a diagram appears."""

import numpy as np
import pytest
from how_many import first
from served_pathview import Served

from pathsim_jsbsim_blocks.catalogue import diagram_folder
from pathsim_jsbsim_blocks.pathview import pvm

from .editor import Editor


@pytest.fixture
def served(tmp_path):
    served = Served(tmp_path, "elevator_doublet", "--no-browser", "--port", "0")
    yield served
    if served.process.poll() is None:
        served.process.kill()


def test_the_command_is_all_that_run_needs(browser, served):
    with Editor(browser, served.address) as editor:
        editor.page.goto(served.url)
        editor.ready()
        shown = {name: text for name, text, _ in editor.blocks()}
        assert "Aircraft" in shown["aircraft"]
        assert not [text for text in shown.values() if "(missing)" in text]
        assert editor.run() == "Simulation completed successfully"
        alpha = editor.runs[-1]["scope"][1][1]
        assert max(alpha) - min(alpha) > 3.0  # deg: the aircraft flies, the block is not left out
        assert not editor.errors
        workers = served.children()
        assert workers
        status, errors = served.end()
    assert (status, errors) == (0, "")
    assert served.left_behind(workers) == []


DRAWN = """() => [...document.querySelectorAll(
    '.svelte-flow__node, .port-label, .svelte-flow__edge-path')].map(e => e.getBoundingClientRect())
    .map(r => [r.left, r.top, r.right, r.bottom])"""
COLOURS = """() => ['.svelte-flow__background', '.port-label'].map(
    kind => getComputedStyle(document.querySelector(kind)).backgroundColor)"""


@pytest.mark.parametrize(("width", "height"), first([(1600, 1000), (1280, 720)]))
def test_a_diagram_opens_whole_and_its_ports_can_be_read(width, height, editor, models):
    models["pitch_hold.pvm"] = pvm.read(diagram_folder() / "pitch_hold.pvm")
    editor.page.set_viewport_size({"width": width, "height": height})
    editor.open("pitch_hold.pvm")
    # wires are drawn after blocks; those below the blocks need more room
    for _ in range(40):
        editor.page.wait_for_timeout(500)
        left, top, right, bottom = np.transpose(editor.page.evaluate(DRAWN))
        if left.min() >= 0 and top.min() >= 40 and right.max() <= width and bottom.max() <= height:
            break
    else:
        pytest.fail(f"{left.min()} to {right.max()}, {top.min()} to {bottom.max()} px")
    # a wire behind a name does not strike it through
    canvas, label = editor.page.evaluate(COLOURS)
    assert canvas == label
    editor.page.locator(".port-label").get_by_text("wind_N", exact=True).wait_for()
    assert not editor.errors
