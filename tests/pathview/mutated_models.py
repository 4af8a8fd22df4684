"""Models with random faults and hostile text, and what the scripts made of them must not do.

A converted script may hold the expressions and the code of its model, each in its own place, and
nothing else that the model says; and none of it runs while it is converted.
"""

import ast
import copy
import json
import random
import re
import sys
import warnings
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

from models import wire

from pathsim_jsbsim_blocks.catalogue import diagram_folder
from pathsim_jsbsim_blocks.errors import BlocksError
from pathsim_jsbsim_blocks.pathview import convert_model
from pathsim_jsbsim_blocks.pathview.toolboxes import FLIGHT, OURS, core_registry, with_toolboxes

EVIL = "__import__('os').system('echo executed')"
SEPARATORS = ["\n", "\r", "\r\n", "\x0b", "\x0c", "\x1c", "\x1e", "\x85", "\u2028", "\u2029"]
TEXTS = [
    *(f"sub{s}{EVIL}{s}" for s in SEPARATORS),
    *(f"{s}import antigravity" for s in SEPARATORS),
    '"',
    f'"""\n{EVIL}\n"""',
    f'"""; {EVIL} #',
    f"''' + {EVIL} + '''",
    f"\\\n{EVIL}",
    f"1); {EVIL} #",
    f"1, {EVIL}",
    f"*{EVIL}",
    f"x={EVIL}",
    EVIL,
    "1 # comment",
    "1, 2",
    "(1\n)",
    "lambda t: max(t, 1)",
    "x for x in y",
    "(x := 3)",
    "'\ud800'",
    "\ud800",
    "\0",
    "\u202e",
    "\ufeff",
    "",
    "?",
    "1",
    "名前",
    "np",
    "sim",
    "blocks",
    "Simulation",
    "Interface",
    "max",
    "class",
    "lambda",
    "this",
    "unittest.__main__",
    "antigravity",
    "pathsim_flight",
    "os",
    "-" * 3000 + "1",
    "(" * 300,
    "+".join("1" * 5000),
    "9" * 5000,
    "StepSource",
    "Subsystem",
    "Scope",
    "BusCreator",
    "BusSelector",
    "pathsim.events.Schedule",
    "pathsim.blocks.Scope",
]
VALUES = [
    *TEXTS,
    *(None, True, False, 0, 1, -1, 2, 10**40, 1.5, float("nan"), float("inf")),
    *([], {}, [[]], {"a": EVIL}, [EVIL], {"x": EVIL, "y": 0}),
]


def _deep(levels):
    value = []
    for _ in range(levels):
        value = [value]
    return value


def block(name, kind, inputs=0, outputs=1, **params):
    ports = {
        side: [{"name": f"{i}"} for i in range(n)]
        for side, n in (("inputs", inputs), ("outputs", outputs))
    }
    return {"id": name, "type": kind, "name": name, "params": params, **ports}


def _subsystem(name, *nodes, wires=(), events=()):
    return {
        **block(name, "Subsystem", 1, 1),
        "graph": {
            "nodes": [block(f"{name}.io", "Interface", 1, 1), *nodes],
            "connections": list(wires),
            "events": list(events),
        },
    }


def _schedule(name):
    return {
        "type": "pathsim.events.Schedule",
        "name": name,
        "params": {"t_period": "0.5", "func_act": "tick"},
    }


NESTED = {
    "version": "1.0.0",
    "graph": {
        "nodes": [
            block("step", "StepSource", amplitude="A", tau="0.5"),
            block("scope", "Scope", 2, 0),
            _subsystem(
                "plant",
                block("gain", "Amplifier", 1, 1, gain="2 * A"),
                _subsystem(
                    "inner",
                    block("k", "Amplifier", 1, 1, gain="max(1, 2)"),
                    wires=[wire("inner.io", "k"), wire("k", "inner.io")],
                ),
                wires=[
                    wire("plant.io", "gain"),
                    wire("gain", "inner"),
                    wire("inner", "plant.io"),
                ],
                events=[_schedule("inside")],
            ),
        ],
        "connections": [
            wire("step", "plant"),
            wire("plant", "scope"),
            {**wire("step", "scope", 0, 1), "id": "other"},
        ],
    },
    "events": [_schedule("tick tock")],
    "codeContext": {"code": "A = 2.0\n\ndef tick(t):\n    return A * t\n"},
    "simulationSettings": {"duration": "3", "dt": "0.1", "solver": "SSPRK22", "rtol": ""},
    "requiredToolboxes": [OURS.requirement(), FLIGHT.requirement()],
}


def originals():
    """Models to begin with: of subsystems, events, code and buses, of ours and of PathView's."""
    examples = Path(find_spec("pathview").origin).parent / "static" / "examples"
    paths = [
        *sorted(diagram_folder().glob("*/*.pvm")),
        *sorted(p for p in examples.glob("*.json") if p.stem != "manifest"),
    ]
    small = [p for p in paths if p.stat().st_size < 20_000]
    return [NESTED] * len(small) + [json.loads(p.read_text(encoding="utf-8")) for p in small]


REACH_CODE = (
    *("id", "name", "type", "label", "code", "importPath", "pkg", "displayName", "content"),
    *("sourceNodeId", "targetNodeId", "solver", "dt", "duration"),
)


def mutated(model, rng):
    """A copy of a model with one to three random changes, most of them where text reaches code."""
    model = copy.deepcopy(model)
    for _ in range(rng.randint(1, 3)):
        places = list(_places(model))
        likely = [place for place in places if place[1] in REACH_CODE] or places
        holder, key = rng.choice(likely if rng.random() < 0.5 else places)
        _change(holder, key, rng, model)
    return model


def _places(value):
    for key in list(value) if isinstance(value, dict) else range(len(value)):
        yield value, key
        if isinstance(value[key], (dict, list)):
            yield from _places(value[key])


def _change(holder, key, rng, model):
    old = holder[key]
    kind = rng.randrange(9)
    if kind <= 2:
        holder[key] = rng.choice(VALUES)
    elif kind == 3 and isinstance(old, str):
        at = rng.randint(0, len(old))
        holder[key] = old[:at] + rng.choice(TEXTS) + old[at:]
    elif kind == 4:  # what another place of the model says
        other, name = rng.choice([p for p in _places(model) if p[1] == key])
        holder[key] = copy.deepcopy(other[name])
    elif kind == 5 and isinstance(holder, dict):
        holder[rng.choice(TEXTS)] = holder.pop(key)
    elif kind == 6 and isinstance(holder, list):
        holder.insert(rng.randint(0, len(holder)), copy.deepcopy(old))
    elif kind == 7:
        del holder[key]
    elif isinstance(old, dict):
        old[rng.choice(TEXTS)] = rng.choice(VALUES)
    else:
        holder[key] = _deep(rng.choice([3, 90, 150]))


EXECUTED = (
    *("exec", "import", "os.system", "os.fork", "os.exec", "os.posix_spawn"),
    *("subprocess.Popen", "socket.connect", "webbrowser.open"),
)


class Watch:
    """What is executed or imported while it is on, by Python's own audit."""

    def __init__(self):
        self.on, self.seen = False, []
        sys.addaudithook(self._hook)

    def _hook(self, event, args):
        if self.on and event in EXECUTED:
            self.seen.append((event, repr(args)[:200]))

    def __enter__(self):
        self.seen.clear()
        self.on = True

    def __exit__(self, *_):
        self.on = False


_watch = None


def convert_mutants(count, seed, folder):
    """Convert mutants; returns how many became scripts, and how many were refused for what."""
    global _watch
    _watch = _watch or Watch()
    models, rng = originals(), random.Random(seed)
    registry = with_toolboxes(core_registry(), [FLIGHT, OURS])
    outcomes = Counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for model in models:  # all that a conversion imports
            _converted(model, folder / "warm.pvm")
        for i in range(count):
            model = mutated(rng.choice(models), rng)
            path = folder / _file_name(rng)
            try:
                with _watch:
                    code = _converted(model, path)
            except BlocksError as error:
                outcomes[type(error).__name__] += 1
            except BaseException as error:
                raise AssertionError(f"seed {seed}, mutant {i}: {error!r}\n{model}") from error
            else:
                outcomes["script"] += 1
                try:
                    assert_says_what_the_model_says(code, model, registry)
                except Exception as error:
                    raise AssertionError(
                        f"seed {seed}, mutant {i}: {error}\n{code}\n{model}"
                    ) from error
            assert not _watch.seen, f"seed {seed}, mutant {i} executed {_watch.seen}\n{model}"
    print(f"seed {seed}: {count} mutants, {dict(outcomes)}")
    return outcomes


def _converted(model, path):
    path.write_text(json.dumps(model), encoding="utf-8")
    out = path.parent / "out.py"
    try:
        return convert_model(path, out).read_text(encoding="utf-8")
    finally:
        path.unlink()


def _file_name(rng):
    if rng.random() < 0.8:
        return "model.pvm"
    name = re.sub("[/\0\ud800-\udfff]", "", rng.choice(TEXTS))[:60]
    return f"{name}.pvm"


def assert_says_what_the_model_says(code, model, registry):
    """Beside the model's own code, imports and assignments of its blocks stand in a script alone."""
    own = ast.parse(((model.get("codeContext") or {}).get("code") or "").strip()).body
    docstring, *statements, main = ast.parse(code).body
    assert isinstance(docstring.value.value, str)
    assert isinstance(main, ast.If)
    texts = [*map(ast.dump, own)]
    start = next(
        i
        for i in range(len(statements))
        if [*map(ast.dump, statements[i : i + len(own)])] == texts
        and not isinstance(statements[i + len(own)], (ast.Import, ast.ImportFrom))
    )
    assert all(isinstance(node, (ast.Import, ast.ImportFrom)) for node in statements[:start])
    classes = {"Simulation", "Subsystem", "Interface"} | {
        entry[f"{kind}Class"]
        for kind in ("block", "event")
        for entry in registry[f"{kind}s"].values()
    }
    for node in statements[start + len(own) :]:
        assert isinstance(node, ast.Assign)
        assert isinstance(node.value, ast.List) or node.value.func.id in classes
