"""PathSim is left as it is: nothing of it is replaced, and other people's diagrams run as without."""

import json
import subprocess
import sys

import pytest
from how_many import first

pytestmark = pytest.mark.matrix

COMPARED = """
import importlib, io, json, pkgutil, sys
from contextlib import redirect_stdout
import pathsim
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope, Source
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

said = io.StringIO()  # PathSim's logger keeps the stream of its first diagram

def flown():
    said.seek(0)
    said.truncate()
    with redirect_stdout(said):
        source, scope, state = Source(lambda t: t), Scope(), Integrator()
        wires = [Connection(source, state), Connection(state, scope)]
        sim = Simulation([source, scope, state], wires, dt=None, log=True)
        stream = sim.run_streaming(0.1, tickrate=1e9)
        next(stream)
        sim.run(0.1)
        rest = list(stream)
    return ["FINISHED -> TRANSIENT" in said.getvalue(), sim.time, sim.dt, scope.read()[1].tolist()]

without, before = flown(), attributes()
from pathsim_jsbsim_blocks import *
import pathsim_jsbsim_blocks
if "every" in sys.argv:
    for found in pkgutil.walk_packages(pathsim_jsbsim_blocks.__path__, "pathsim_jsbsim_blocks."):
        if found.name.rpartition(".")[2] != "__main__":
            importlib.import_module(found.name)
loaded = sum(name.startswith("pathsim_jsbsim_blocks.") for name in sys.modules)
after = attributes()
changed = [name for name in before if after.get(name, None) is not before[name]]
added = sorted(after.keys() - before.keys())
print(json.dumps([changed, added, len(before), loaded, without, flown()]))
"""


@pytest.mark.parametrize(("modules", "count"), first([("public", 50), ("every", 100)]))
def test_the_import_replaces_nothing_of_pathsim_and_changes_no_run(modules, count):
    command = [sys.executable, "-c", COMPARED, modules]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    changed, added, attributes, loaded, without, flown = json.loads(done.stdout.splitlines()[-1])
    # ABCs and enumerations count their subclasses
    assert [x for x in changed if not x.endswith(("__abc_impl", "_abc_impl"))] == []
    assert [x for x in added if not x.endswith("__abstractmethods__")] == []
    assert attributes > 3000
    assert loaded > count
    assert flown == without
    assert without[0]
