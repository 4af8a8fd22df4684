"""What the editor does with this package's blocks: library, tooltips, editing between runs."""

import json
import random

import numpy as np
import pytest
from how_many import bounded

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import export_script, pvm
from pathsim_jsbsim_blocks.pathview.toolboxes import OURS

from .editor import Drawing

LOOP = """
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope
from pathsim_jsbsim_blocks import DiscretePID

reference = Constant(1.0)
controller = DiscretePID(Kp=0.5, low=-5.0, high=5.0, T=0.01)
plant = Integrator()
scope = Scope(labels=["y", "u"])
sim = Simulation(
    [reference, controller, plant, scope],
    [Connection(reference, controller["r"]), Connection(controller["u"], plant, scope[1]),
     Connection(plant, controller["y"], scope[0])], dt=0.01, log=False)
if __name__ == "__main__":
    sim.run(2.0)
"""


@pytest.fixture
def loop(tmp_path, models):
    (tmp_path / "loop.py").write_text(LOOP)
    model = export_script(tmp_path / "loop.py")
    models["loop.pvm"] = json.loads(model.read_text())
    namespace = {"__name__": "loop"}
    exec(LOOP, namespace)
    return namespace


@pytest.mark.long
def test_a_parameter_changed_between_run_and_continue_takes_effect(loop, editor):
    editor.open("loop.pvm")
    assert editor.run() == "Simulation completed successfully"
    editor.page.fill("#pinned-controller-Kp", "2.5")
    assert editor.run("Continue") == "Simulation continued successfully"
    assert not editor.complaints()

    sim, controller, scope = (loop[n] for n in ("sim", "controller", "scope"))
    sim.run(2.0)
    controller.Kp = 2.5
    sim.run(2.0)
    _, recorded = scope.read()
    streamed = [
        a + b for a, b in zip(editor.runs[0]["scope"][1], editor.runs[1]["scope"][1], strict=True)
    ]
    np.testing.assert_allclose(streamed, recorded, rtol=1e-12, atol=1e-12)
    # with the old gain y would be 1 - e^(-0.5 t)
    assert abs(recorded[0][-1] - (1.0 - np.exp(-2.0))) > 0.05

    # a bad one is reported, and the run goes on with the old value
    editor.page.fill("#pinned-controller-Kp", '"steep"')
    assert editor.run("Continue") == "Simulation continued successfully"
    assert any("Kp must be a number, not 'steep'" in m for m in editor.messages())


@pytest.mark.long
def test_the_properties_dialog_explains_a_block(editor, loop):
    editor.open("loop.pvm")
    editor.page.wait_for_timeout(1500)  # the diagram flies in
    node = editor.page.locator(".svelte-flow__node[data-id='controller']")
    node.dblclick(position={"x": node.bounding_box()["width"] / 2, "y": 8})
    dialog = editor.page.locator(".properties-dialog")
    fields = dialog.locator(".param-item")
    assert fields.count() == len(OURS.blocks()["DiscretePID"].info()["parameters"])
    assert fields.first.locator("input").input_value() == "0.5"
    fields.first.locator(".help-icon").hover()
    tooltip = editor.page.locator(".tooltip .text")
    tooltip.wait_for()
    assert "proportional gain" in tooltip.inner_text()
    dialog.locator(".docs-toggle").click()
    page = dialog.locator(".docs-content")
    page.get_by_text("Sampled PI-D controller").wait_for()


@pytest.mark.long
@pytest.mark.parametrize("kind", ["Aircraft", "Autopilot"])
def test_a_fresh_block_shows_its_ports_and_does_not_cover_the_note(kind, editor, models):
    models["isa.pvm"] = pvm.read(find_diagram("isa_profile").with_suffix(".pvm"))
    editor.open("isa.pvm")
    editor.page.wait_for_timeout(1500)  # the diagram flies in
    drawing = Drawing(editor.page)
    note = editor.page.locator(".annotation").bounding_box()
    drawing.panel("Blocks")
    drawing.place(kind, 1000, note["y"] + note["height"] / 2)
    block = drawing.block(kind)
    ports = OURS.blocks()[kind]
    names = [*ports.input_port_labels, *ports.output_port_labels]
    assert block.locator(".port-label").count() == len(names)
    editor.page.wait_for_timeout(500)
    top, left = block.bounding_box(), editor.page.locator(".annotation").bounding_box()
    assert top["y"] >= left["y"] + left["height"]
    frame = block.locator(".node").bounding_box()
    for label in block.locator(".port-label").all():
        box = label.bounding_box()
        assert frame["x"] < box["x"]
        assert box["x"] + box["width"] < frame["x"] + frame["width"]


FORMULAS = [name for name, block in OURS.blocks().items() if ".. math::" in block.__doc__]
SOME = random.Random(52).sample(FORMULAS, bounded(8, len(FORMULAS)))


@pytest.mark.long
def test_the_library_shows_whole_formulas(editor, models):
    models["isa.pvm"] = pvm.read(find_diagram("isa_profile").with_suffix(".pvm"))
    editor.open("isa.pvm")
    page = editor.page
    page.click("button[aria-label='Blocks']")
    for name in SOME:
        page.mouse.move(1500, 900)
        page.fill(".node-library .search-input", name)
        tile = page.locator(".node-library .node-tile")
        tile.filter(has=page.get_by_text(name, exact=True)).hover()
        panel = page.locator(".panel-right")
        panel.get_by_text(name.upper(), exact=False).first.wait_for()
        page.wait_for_timeout(800)  # formulas are set after the text
        right = panel.bounding_box()
        for part in panel.locator(".katex-html .base").all():
            box = part.bounding_box()
            assert box["x"] + box["width"] <= right["x"] + right["width"], name
        assert panel.locator(".katex-html .base").count()
