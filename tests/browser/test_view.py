"""``pathsim-jsbsim view`` in a fresh browser profile, and how a diagram appears."""

import random
from pathlib import Path

import numpy as np
import pytest
from how_many import bounded
from served_pathview import Served

from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
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


@pytest.mark.long
@pytest.mark.parametrize(("width", "height"), [(1600, 1000), (1280, 720)])
def test_a_diagram_opens_whole_and_its_ports_can_be_read(width, height, editor, models):
    models["pitch_hold.pvm"] = pvm.read(find_diagram("pitch_hold").with_suffix(".pvm"))
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
    editor.page.locator(".port-label").get_by_text("wind_N", exact=True).wait_for()
    assert not editor.errors


# of all names on the canvas: those that are cut, and those that a wire or another name crosses
NAMES = (Path(__file__).parents[1] / "data" / "crossed_names.js").read_text(encoding="utf-8")
PATHS = (
    "() => [...document.querySelectorAll('.svelte-flow__edge-path')].map(e => e.getAttribute('d'))"
)
DIAGRAMS = diagram_names()
SOME = random.Random(52).sample(DIAGRAMS, bounded(10, len(DIAGRAMS)))
WIRES = "() => document.querySelectorAll('.svelte-flow__edge-path').length"


@pytest.mark.long
@pytest.mark.parametrize("names", [["aileron_turn"], SOME], ids=len)
def test_names_are_whole_and_no_wire_crosses_them(names, editor, models):
    crossed = {}
    for name in names:
        model = models[f"{name}.pvm"] = pvm.read(find_diagram(name).with_suffix(".pvm"))
        editor.page.goto(editor.url(f"{name}.pvm"))
        editor.page.wait_for_function(
            f"count => ({WIRES})() === count", arg=len(model["graph"]["connections"])
        )
        drawn, before, wrong = [], None, True
        for _ in range(20):  # wires are led around the blocks after these are there
            if drawn == before and not wrong:
                break
            editor.page.wait_for_timeout(500)
            drawn, before = editor.page.evaluate(PATHS), drawn
            wrong = editor.page.evaluate(NAMES)
        crossed |= {name: wrong} if wrong else {}
        labels = editor.page.locator(".port-label").all_inner_texts()
        nodes = model["graph"]["nodes"]
        for node in nodes:
            for side in ("Input", "Output"):
                if node["params"].get(f"_show{side}Labels"):
                    assert {port["name"] for port in node[f"{side.lower()}s"]} <= {*labels}
        columns = [node["position"]["x"] for node in nodes]
        assert max(columns) - min(columns) <= 1000, name  # px: it can be read on a page
    assert crossed == {}
