"""Script to model to script, and model to script to model: nothing is lost on the way."""

import json
import math
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from how_many import EXPORTED, first
from pathsim import Subsystem

from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import convert_model, export_script
from pathsim_jsbsim_blocks.pathview.first_run import FirstRun as Script
from pathsim_jsbsim_blocks.pathview.variables import plain

pytest.importorskip("pathview")

EXAMPLES = Path(find_spec("pathview").origin).parent / "static" / "examples"


def recorders(blocks):
    """Scopes and spectra, those in subsystems first, as PathView's scripts have them."""
    for block in blocks:
        if type(block) is Subsystem:
            yield from recorders(block.blocks)
    yield from (b for b in blocks if type(b).__name__ in ("Scope", "Spectrum"))


def traces(path, monkeypatch, longest=math.inf, part=1.0):
    """What a script records in a part of its duration, or in the longest of a test; its duration.

    Noise is the same in every call.
    """
    made = iter(range(1000))
    generator = np.random.default_rng
    with monkeypatch.context() as patched:
        patched.setattr(
            np.random,
            "default_rng",
            lambda seed=None: generator(next(made) if seed is None else seed),
        )
        np.random.seed(1)  # noqa: NPY002 (the models draw from the global one)
        script = Script(path)
        duration = eval(compile(_duration(script), "duration", "eval"), script.namespace)
        fly(script.simulation, min(part * duration, longest))
    return duration, [b.read() for b in recorders(script.simulation.blocks)]


def _duration(script):
    import ast

    call = script.run_call
    return ast.Expression(call.args[0] if call.args else call.keywords[0].value)


def assert_identical(one, other):
    (duration, a), (duration_b, b) = one, other
    assert duration == duration_b
    assert len(a) == len(b) > 0
    for (time, signals), (time_b, signals_b) in zip(a, b, strict=True):
        np.testing.assert_array_equal(time, time_b)
        np.testing.assert_array_equal(signals, signals_b)


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
    example = EXAMPLES / f"{name}.json"
    script = convert_model(example, tmp_path / f"{name}.py")
    # a number that the code draws at random is in the model as drawn: let each run draw the same
    code = script.read_text(encoding="utf-8")
    if "np.random.rand()" in code:
        seed = "import numpy as np\nnp.random.seed(1)\n"
        script.write_text(code.replace("import numpy as np\n", seed, 1), encoding="utf-8")
    model = export_script(script)
    again = convert_model(model, tmp_path / "again.py")
    before, after = (json.loads(p.read_text(encoding="utf-8")) for p in (example, model))
    assert _count(after["graph"]) == _count(before["graph"])
    assert len(after["events"]) == len(before["events"])
    assert_identical(*(traces(path, monkeypatch, part=part) for path in (script, again)))


def _count(graph):
    inner = [_count(n["graph"]) for n in graph["nodes"] if "graph" in n]
    return (
        len(graph["nodes"]) + sum(n for n, _ in inner),
        len(graph["connections"]) + sum(w for _, w in inner),
    )
