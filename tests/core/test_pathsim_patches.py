"""Why `_core/pathsim_internals.py` replaces methods of PathSim: what PathSim does without this package.

A failure here is good news: PathSim has cured the fault, and the patch named in the message can go
once the lowest supported version has the cure.
"""

import ast
import json
import subprocess
import sys

import pytest
from package_source import nodes

pytestmark = pytest.mark.matrix

UNPATCHED = r"""
import contextlib, json, tempfile, warnings
from pathlib import Path
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Integrator, SampleHold, Scope, Source
from pathsim.events import ScheduleList

with tempfile.TemporaryFile("w+") as console, contextlib.redirect_stderr(console):
    Simulation([Scope()], log=False)
    warnings.warn("seen")
    console.seek(0)
    warned = console.read()


def held(nested):
    source, hold, scope = Source(lambda t: t), SampleHold(T=1.0), Scope()
    block = hold
    if nested:
        inside = Interface()
        block = Subsystem([inside, hold], [Connection(inside, hold), Connection(hold, inside)])
    wires = [Connection(source, block), Connection(block, scope)]
    Simulation([source, block, scope], wires, dt=0.25, log=False).run(3.0)
    return scope.read()[1][0].tolist()


def backwards():
    sim = Simulation([Scope()], dt=-0.1, log=False)
    return [sim.time for _ in zip(range(50), sim._run_loop(1.0, False, False))]


def run_inside_a_run():
    sim = Simulation([Scope()], dt=0.1, log=False)
    sim.add_event(ScheduleList([0.25], func_act=lambda t: sim.run(0.5)))
    sim.run(1.0)
    return sim.time


def error_of(make):
    try:
        make()
    except Exception as error:
        return str(error)


def two_into_one():
    one, other, scope = Constant(), Constant(), Scope()
    Simulation([one, other, scope], [Connection(one, scope), Connection(other, scope)], log=False)


def from_a_damaged_checkpoint():
    with tempfile.TemporaryDirectory() as folder:
        source, integrator = Constant(1.0), Integrator()
        sim = Simulation([source, integrator], [Connection(source, integrator)], log=False)
        sim.save_checkpoint(folder + "/saved")
        file = Path(folder, "saved.json")
        data = json.loads(file.read_text())
        data["simulation"]["time"] = 7.0
        file.write_text(json.dumps(data))
        sim.load_checkpoint(folder + "/saved")
        return sim.time


print(json.dumps({
    "warned": warned,
    "held": [held(False), held(True)],
    "backwards": backwards(),
    "run inside a run": run_inside_a_run(),
    "no block in a wire": error_of(lambda: Connection(Constant(), 3)),
    "no block in a list": error_of(lambda: Simulation([3], log=False)),
    "no wire in a list": error_of(lambda: Simulation([Constant()], [3], log=False)),
    "ends differ": error_of(lambda: Connection(Constant()[0, 1], Scope())),
    "two into one": error_of(two_into_one),
    "damaged": from_a_damaged_checkpoint(),
}))
"""


@pytest.fixture(scope="module")
def unpatched():
    done = subprocess.run([sys.executable, "-c", UNPATCHED], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_warnings_are_not_seen_after_the_first_simulation(unpatched):
    assert unpatched["warned"] == "", "keep_warnings_visible can go"


def test_a_block_in_a_subsystem_samples_its_input_of_a_step_before(unpatched):
    alone, inside = unpatched["held"]
    assert alone[4::4] == [1.0, 2.0, 3.0]
    assert inside[4::4] == [0.75, 1.75, 2.75], "Settling and the property of Subsystem can go"


def test_a_run_backwards_never_ends(unpatched):
    assert len(unpatched["backwards"]) == 50, "the check of dt in _announce_runs can go"


def test_a_run_begins_inside_another(unpatched):
    assert unpatched["run inside a run"] == pytest.approx(1.0), "the refusal by Steps can go"


@pytest.mark.parametrize(
    ("mistake", "said"),
    [
        ("no block in a wire", "'int' object has no attribute"),
        ("no block in a list", "'int' object has no attribute"),
        ("no wire in a list", "'int' object has no attribute"),
        ("ends differ", "Source and target have different number of ports!"),
        ("two into one", "Connection conflict detected"),
    ],
)
def test_mistakes_in_the_wiring_are_not_named(unpatched, mistake, said):
    assert said in unpatched[mistake], "one of the checks of check_diagrams can go"


def test_a_damaged_checkpoint_is_loaded(unpatched):
    assert unpatched["damaged"] == 7.0, "checkpoint.py can go"


def test_no_other_module_replaces_what_is_pathsims():
    names = {"Simulation", "Subsystem", "Block", "Connection", "Graph", "Register", "LoggerManager"}
    found = {
        file
        for file, node in nodes()
        if isinstance(node, ast.Attribute)
        and isinstance(node.ctx, ast.Store)
        and isinstance(node.value, ast.Name)
        and node.value.id in names
    }
    assert found == {"_core/pathsim_internals.py"}
