"""Every diagram of the catalogue in PathView, against its own script."""

from concurrent.futures import ThreadPoolExecutor

import pytest
from pathsim import Subsystem

from pathsim_jsbsim_blocks.catalogue import find_diagram, load_diagram
from pathsim_jsbsim_blocks.pathview import pvm

from .editor import assert_same


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


def recorded(simulation, duration, named):
    """What scopes hold after a run."""
    simulation.run(duration)
    return {name: scope.read() for name, scope in named.items()}


def joined(first, second):
    """Streams of a run and of its continuation, in one."""
    return {
        node: [
            time + second[node][0],
            [a + b for a, b in zip(signals, second[node][1], strict=True)],
        ]
        for node, (time, signals) in first.items()
    }


# that a model is its script, bit for bit, is tested for all without a browser. Here is one of each:
# an aircraft under a hold; continuous states; turbulence; Python functions and an event that ends
# the run; DAVE-ML; subsystems are in test_scripts
NAMES = (
    "pitch_hold",
    "van_der_pol",
    "autopilot_mission",
    "scheduled_climb",
    "check_case_13_3",
)
SHORTER = {"autopilot_mission": 30.0}  # s


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_a_diagram_runs_in_pathview_as_its_script_does(name, fresh_editor, models):
    editor = fresh_editor  # no name is left of another diagram
    model = models[f"{name}.pvm"] = pvm.read(find_diagram(name).with_suffix(".pvm"))
    script = load_diagram(name)
    duration = SHORTER.get(name, script.DURATION)
    model["simulationSettings"]["duration"] = repr(duration)
    own = scopes(script.sim.blocks, model["graph"]["nodes"])
    # PathView simulates in a process of its own: run the script meanwhile
    with ThreadPoolExecutor(max_workers=1) as meanwhile:
        expected = meanwhile.submit(recorded, script.sim, duration, own)
        editor.open(f"{name}.pvm")
        for node in model["graph"]["nodes"]:
            editor.page.wait_for_selector(f".svelte-flow__node[data-id='{node['id']}']")
        shown = editor.blocks()
        assert not [text for _, text, _ in shown if "(missing)" in text]
        assert editor.run() == "Simulation completed successfully"
        assert_same(editor.runs[0], expected.result())
        end = script.sim.time

        assert editor.run() == "Simulation completed successfully"
        assert editor.runs[1] == editor.runs[0]

        if end > duration * (1 - 1e-6):  # a flight that did not end itself
            longer = meanwhile.submit(recorded, script.sim, duration, own)
            assert editor.run("Continue") == "Simulation continued successfully"
            assert_same(joined(editor.runs[1], editor.runs[2]), longer.result())
    assert not editor.errors
    assert not editor.complaints()
    assert not editor.elsewhere
