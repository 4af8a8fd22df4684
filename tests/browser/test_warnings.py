"""PathView's console shows what Python warns of.

A batch is no part of a diagram: PathView runs a model's code twice for each run and gives it 30 s.
So "a worker died" has no place here; it is a warning of Python, as the model's own one below.
"""

import json

import pytest

from pathsim_jsbsim_blocks.pathview import export_script

SCRIPT = """
import warnings

from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Function, Scope
from pathsim_jsbsim_blocks import DiscretePID, ISAtmosphere

OWN = "the model's own"

def check(u):
    warnings.warn(OWN)
    return u

height = Constant(90_000.0)
air = ISAtmosphere(out_of_range="extrapolate")
reference = Constant(1.0)
controller = DiscretePID(Kp=0.5, T=0.01)
through = Function(check)
scope = Scope()
sim = Simulation(
    [height, air, reference, controller, through, scope],
    [Connection(height, air[0]), Connection(reference, controller["r"]),
     Connection(controller["u"], through), Connection(through, scope)], dt=0.003, log=False)
if __name__ == "__main__":
    sim.run(0.1)
"""
SAID = [
    "jumps over a sample instant",
    "DiscretePID measures 0 at unconnected inputs: y",
    "outside of the standard atmosphere's range",
    "UserWarning: the model's own",
]


@pytest.fixture
def editor(fresh_editor):
    """Python shows a warning once in a process."""
    return fresh_editor


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")  # those of the script, which an export runs
def test_each_warning_is_in_the_console_once(tmp_path, models, editor):
    (tmp_path / "warned.py").write_text(SCRIPT)
    models["warned.pvm"] = json.loads(export_script(tmp_path / "warned.py").read_text())
    editor.open("warned.pvm")
    assert editor.run() == "Simulation completed successfully"
    said = "\n".join(editor.messages())
    assert [said.count(text) for text in SAID] == [1] * len(SAID)
    assert not editor.errors
