"""Whatever stands at a place of a model, a script made of it says what the model says, and no more.

It may hold the expressions and the code of its model, each in its own place. Else the model is refused
by a typed error. None of it runs while it is converted.
"""

import ast
import copy
import functools
import itertools
import json
import re
import sys
import warnings

import pytest
from pathview_models import block, event, model, subsystem, wire

from pathsim_jsbsim_blocks.errors import BlocksError
from pathsim_jsbsim_blocks.pathview import convert_model
from pathsim_jsbsim_blocks.pathview.toolboxes import FLIGHT, OURS, core_registry, with_toolboxes

pytest.importorskip("pathview")

INNER = subsystem(
    "inner",
    block("inner.io", "Interface", 1, 1),
    block("k", "Amplifier", 1, gain="max(1, 2)"),
    inputs=1,
    outputs=1,
    connections=[wire("inner.io", "k"), wire("k", "inner.io")],
)
PLANT = subsystem(
    "plant",
    block("io", "Interface", 1, 1),
    INNER,
    inputs=1,
    outputs=1,
    connections=[wire("io", "inner"), wire("inner", "io")],
    events=[event("inside", t_period="0.5", func_act="tick")],
)
MODEL = {
    **model(
        block("step", "StepSource", amplitude="A", tau="0.5"),
        block("scope", "Scope", 1, 0),
        PLANT,
        connections=[wire("step", "plant"), wire("plant", "scope")],
        events=[event("tick tock", t_period="0.5", func_act="tick")],
        code="A = 2.0\n\ndef tick(t):\n    return A * t\n",
    ),
    "simulationSettings": {"duration": "3", "dt": "0.1", "solver": "SSPRK22", "rtol": ""},
    "requiredToolboxes": [OURS.requirement(), FLIGHT.requirement()],
}
EVIL = "open('executed', 'w').close()"
VALUES = [
    f"sub\n{EVIL}\n",
    f"\u2028{EVIL}\u2028",
    "\rimport antigravity",
    f'"""\n{EVIL}\n"""',
    f"\\\n{EVIL}",
    f"1); {EVIL} #",
    f"1, {EVIL}",
    f"x={EVIL}",
    EVIL,
    "1 # comment",
    "x for x in y",
    "\ud800",
    "\0",
    "(" * 300,
    *("", "?", "np", "sim", "Simulation", "class", "antigravity", "unittest.__main__", "os"),
    *(None, True, -1, 10**40, float("nan"), [], {}, [[]], {"a": EVIL}, [EVIL]),
]


def places(value, path=()):
    """Paths to all values in a model."""
    for key in value if isinstance(value, dict) else range(len(value)):
        yield (*path, key)
        if isinstance(value[key], (dict, list)):
            yield from places(value[key], (*path, key))


# one of each kind: the same keys, whatever the numbers in lists
PLACES = {re.sub(r"\d+", "i", str(place)): place for place in places(MODEL)}


def changed(place, value):
    content = copy.deepcopy(MODEL)
    *path, key = place
    functools.reduce(lambda at, step: at[step], path, content)[key] = value
    return content


CLASSES = {"Simulation", "Subsystem", "Interface"} | {
    entry[f"{kind}Class"]
    for kind in ("block", "event")
    for entry in with_toolboxes(core_registry(), [FLIGHT, OURS])[f"{kind}s"].values()
}


def is_import(node):
    return isinstance(node, (ast.Import, ast.ImportFrom))


def assert_says_what_the_model_says(code, content):
    """Beside the model's own code, imports and assignments of its blocks stand in a script alone."""
    own = ast.parse(((content.get("codeContext") or {}).get("code") or "").strip()).body
    docstring, *statements, main = ast.parse(code).body
    assert isinstance(docstring.value.value, str)
    assert isinstance(main, ast.If)
    leading = [*itertools.takewhile(is_import, statements)]
    start = len(leading) - len([*itertools.takewhile(is_import, own)])
    imported = {
        n.name for node in leading[:start] if isinstance(node, ast.Import) for n in node.names
    }
    assert imported <= {"numpy", "matplotlib.pyplot"}
    end = start + len(own)
    assert [*map(ast.dump, statements[start:end])] == [*map(ast.dump, own)]
    for node in statements[end:]:
        assert isinstance(node, ast.Assign)
        assert isinstance(node.value, ast.List) or node.value.func.id in CLASSES


# a text at each of the usual places: test_convert
@pytest.mark.long
@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_a_value_anywhere_in_a_model_is_refused_or_stays_in_its_place(place, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "model.pvm"
    for value in VALUES:
        content = changed(place, value)
        path.write_text(json.dumps(content), encoding="utf-8")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                script = convert_model(path, tmp_path / "out.py")
            except BlocksError:
                continue
        assert_says_what_the_model_says(script.read_text(encoding="utf-8"), content)
    assert not (tmp_path / "executed").exists()
    assert "antigravity" not in sys.modules
