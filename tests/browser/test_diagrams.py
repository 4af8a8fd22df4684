"""Every diagram of the catalogue in PathView, against its own script."""

import numpy as np
import pytest
from pathsim import Subsystem

from pathsim_jsbsim_blocks.catalogue import diagram_folder, diagram_names, load_diagram
from pathsim_jsbsim_blocks.pathview import pvm


def scopes(blocks, nodes):
    """The scopes of a live diagram by the names of a model's nodes."""
    found = {}
    for block, node in zip(blocks, nodes, strict=True):
        assert type(block).__name__ == node["type"]
        if type(block) is Subsystem:
            found |= scopes([block.interface, *block.blocks], node["graph"]["nodes"])
        elif node["type"] == "Scope":
            found[node["id"]] = block
    return found


def assert_same(streamed, recorded):
    assert streamed.keys() == recorded.keys()
    for name, (time, signals) in recorded.items():
        np.testing.assert_allclose(streamed[name][0], time, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(streamed[name][1], signals, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", diagram_names())
def test_a_diagram_runs_in_pathview_as_its_script_does(name, editor, models):
    model = models[f"{name}.pvm"] = pvm.read(diagram_folder() / f"{name}.pvm")
    script = load_diagram(name)
    own = scopes(script.sim.blocks, model["graph"]["nodes"])
    script.sim.run(script.DURATION)
    recorded = {k: s.read() for k, s in own.items()}

    editor.open(f"{name}.pvm")
    shown = editor.blocks()
    assert {n["id"] for n in model["graph"]["nodes"]} <= {block for block, _, _ in shown}
    assert not [text for _, text, _ in shown if "(missing)" in text]
    assert editor.run() == "Simulation completed successfully"
    assert_same(editor.runs[-1], recorded)
    assert editor.run() == "Simulation completed successfully"
    assert editor.runs[1] == editor.runs[0]

    if script.sim.time > script.DURATION * (1 - 1e-6):  # did not end itself
        script.sim.run(script.DURATION)
        assert editor.run("Continue") == "Simulation continued successfully"
        # the editor keeps what the first run streamed, and receives the rest
        for node, (time, signals) in editor.runs[-1].items():
            editor.runs[-1][node] = [editor.runs[1][node][0] + time,
                                     [a + b for a, b in zip(editor.runs[1][node][1], signals,
                                                            strict=True)]]
        assert_same(editor.runs[-1], {k: s.read() for k, s in own.items()})

    exported = {"__name__": "exported"}
    exec(editor.python(), exported)
    exported["sim"].run(script.DURATION)
    # PathView's script lists the blocks by category: find the scopes by their labels
    of_export = {tuple(b.labels): b.read() for b in flat(exported["sim"].blocks)}
    assert_same(of_export, {tuple(own[k].labels): v for k, v in recorded.items()})
    assert not editor.errors
    assert not editor.complaints()


def flat(blocks):
    for block in blocks:
        if type(block) is Subsystem:
            yield from flat(block.blocks)
        elif type(block).__name__ == "Scope":
            yield block
