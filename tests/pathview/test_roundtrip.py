"""Script to model to script, and model to script to model: nothing is lost on the way."""

import json
from importlib.util import find_spec
from pathlib import Path

import pytest
from how_many import EXPORTED, first
from oracle import assert_equal, first_run

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import convert_model, export_script
from pathsim_jsbsim_blocks.pathview.variables import plain

pytest.importorskip("pathview")

EXAMPLES = Path(find_spec("pathview").origin).parent / "static" / "examples"


def parts(graph, path=()):
    """Nodes with their parameters, events and wires of all levels, by name."""
    names = {n["id"]: plain(n["name"]) for n in graph["nodes"]}
    for n in graph["nodes"]:
        yield (
            *path,
            names[n["id"]],
            n["type"],
            tuple(sorted((k, v) for k, v in n["params"].items() if not k.startswith("_"))),
        )
        if "graph" in n:
            yield from parts(n["graph"], (*path, names[n["id"]]))
    for c in graph["connections"]:
        yield (
            *path,
            names[c["sourceNodeId"]],
            c["sourcePortIndex"],
            names[c["targetNodeId"]],
            c["targetPortIndex"],
        )
    for e in graph.get("events") or []:
        yield (*path, plain(e["name"]), e["type"], tuple(sorted(e["params"].items())))


@pytest.mark.filterwarnings("ignore:.*same for .* only")
@pytest.mark.parametrize("name", EXPORTED)
def test_model_to_script_to_model(name, tmp_path):
    model = find_diagram(name).with_suffix(".pvm")
    again = export_script(convert_model(model, tmp_path / f"{name}.py"), check=0.2)
    before, after = (json.loads(p.read_text(encoding="utf-8")) for p in (model, again))
    assert sorted(map(str, parts(after["graph"]))) == sorted(map(str, parts(before["graph"])))
    assert [(e["name"], e["params"]) for e in after["events"]] == [
        (e["name"], e["params"]) for e in before["events"]
    ]
    assert after["simulationSettings"] == before["simulationSettings"]
    assert after["codeContext"] == before["codeContext"]
    assert after.get("requiredToolboxes") == before.get("requiredToolboxes")


_SLOW = ("fmcw-radar", "vanderpol")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.long) if name in _SLOW else name
        for name in sorted(p.stem for p in EXAMPLES.glob("*.json") if p.stem != "manifest")
    ],
)
@pytest.mark.parametrize("part", first([0.2, 1.0]))
def test_pathviews_own_examples(name, part, tmp_path, monkeypatch):
    before = json.loads((EXAMPLES / f"{name}.json").read_text(encoding="utf-8"))
    settings = before["simulationSettings"]
    if settings["duration"] is not None:
        settings["duration"] = f"{part} * ({settings['duration']})"
    example = tmp_path / f"{name}.json"
    example.write_text(json.dumps(before), encoding="utf-8")
    script = convert_model(example, tmp_path / f"{name}.py")
    # a number that the code draws at random is in the model as drawn: let each run draw the same
    code = script.read_text(encoding="utf-8")
    if "np.random.rand()" in code:
        seed = "import numpy as np\nnp.random.seed(1)\n"
        script.write_text(code.replace("import numpy as np\n", seed, 1), encoding="utf-8")
    model = export_script(script)
    again = convert_model(model, tmp_path / "again.py")
    after = json.loads(model.read_text(encoding="utf-8"))
    assert _count(after["graph"]) == _count(before["graph"])
    assert len(after["events"]) == len(before["events"])
    assert_equal(first_run(script, monkeypatch), first_run(again, monkeypatch))


def _count(graph):
    inner = [_count(n["graph"]) for n in graph["nodes"] if "graph" in n]
    return (
        len(graph["nodes"]) + sum(n for n, _ in inner),
        len(graph["connections"]) + sum(w for _, w in inner),
    )
