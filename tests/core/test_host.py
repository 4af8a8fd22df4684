"""PathSim is left as it is: nothing of it is replaced, and other people's diagrams run as without."""

import json
import subprocess
import sys

import pytest

pytestmark = pytest.mark.matrix

COMPARED = """
import importlib, json, pkgutil, sys, types
import pathsim
for found in pkgutil.walk_packages(pathsim.__path__, "pathsim."):
    importlib.import_module(found.name)

def attributes():
    seen = {}
    for name, module in [*sys.modules.items()]:
        if name.partition(".")[0] != "pathsim":
            continue
        for key, value in [*vars(module).items()]:
            if key == "__builtins__":
                continue
            seen[name + "." + key] = value
            if isinstance(value, type) and value.__module__.partition(".")[0] == "pathsim":
                for attribute, part in [*vars(value).items()]:
                    seen[f"{name}.{key}.{attribute}"] = part
    return seen

before = attributes()
from pathsim_jsbsim_blocks import *
import pathsim_jsbsim_blocks
loaded = []
for found in pkgutil.walk_packages(pathsim_jsbsim_blocks.__path__, "pathsim_jsbsim_blocks."):
    if found.name.rpartition(".")[2] != "__main__":
        importlib.import_module(found.name)
        loaded.append(found.name)
after = attributes()
changed = [name for name in before if after.get(name, None) is not before[name]]
print(json.dumps([changed, sorted(after.keys() - before.keys()), len(before), len(loaded)]))
"""


def fresh(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout.splitlines()[-1])


def test_the_import_replaces_nothing_of_pathsim():
    changed, added, attributes, loaded = fresh(COMPARED)
    # ABCs and enumerations count their subclasses
    assert [x for x in changed if not x.endswith(("__abc_impl", "_abc_impl"))] == []
    assert [x for x in added if not x.endswith("__abstractmethods__")] == []
    assert attributes > 3000
    assert loaded > 100


LOGGED = """
import io, json, sys, warnings
from contextlib import redirect_stdout
IMPORT
from pathsim import Simulation, Connection
from pathsim.blocks import Source, Scope, Integrator
with redirect_stdout(io.StringIO()) as said:
    source, scope, state = Source(lambda t: t), Scope(), Integrator()
    wires = [Connection(source, state), Connection(state, scope)]
    sim = Simulation([source, scope, state], wires, dt=None, log=True)
    stream = sim.run_streaming(0.1, tickrate=1e9)
    next(stream)
    sim.run(0.1)
    rest = list(stream)
print(json.dumps(["FINISHED -> TRANSIENT" in said.getvalue(), sim.time, sim.dt, scope.read()[1].tolist()]))
"""


def test_a_diagram_without_our_blocks_runs_as_without_the_package():
    plain = fresh(LOGGED.replace("IMPORT", ""))
    ours = fresh(LOGGED.replace("IMPORT", "from pathsim_jsbsim_blocks import *"))
    assert ours == plain
    assert plain[0]
