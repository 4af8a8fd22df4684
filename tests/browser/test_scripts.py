"""A script of one's own, with all that PathView handles in its own way, runs there as it is."""

import json

import pytest

from pathsim_jsbsim_blocks.pathview import export_script

from .editor import assert_same

SCRIPT = '''
"""Everything at once."""
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import Schedule, ZeroCrossing
from pathsim.solvers import RKDP54
import math  # pathsim.blocks has another
from pathsim_flight import ISAtmosphere

k, T = 1.5, 2.0
NOTE = """three
lines
of text"""

@Source
def Wave(t):
    return math.sin(k * t) + len(NOTE)

def bounce(t):
    """A doc
    string."""
    Ball.engine.set(abs(Ball.engine.state))
    Speed.engine.set(-0.8 * Speed.engine.state)

# the ball, with its event inside
port = Interface()
Speed = Integrator(0.0)
Ball = Integrator(1.0)
hit = ZeroCrossing(lambda t: Ball.engine.state, bounce)
K = Subsystem([port, Speed, Ball, inner := Scope(labels=["inside"])],
              [Connection(port, Speed), Connection(Speed, Ball), Connection(Ball, port, inner)],
              [hit])
Int = Integrator(0.0)
air = ISAtmosphere()
scope = Scope(labels=["wave", "ball",  # two,
                      "integral", 'air'])
count = Constant(0.0)
tick = Schedule(t_period=0.5, func_act=lambda t: setattr(count, "value", count.value + 1))
steps = Scope()
Sim = Simulation(
    [Wave, gravity := Constant(-9.81), K, Int, air, scope, count, steps],
    [Connection(Wave[0], scope[0], Int), Connection(gravity, K), Connection(K[0], scope[1]),
     Connection(Int, scope[2], air[0]), Connection(air["pressure"], scope[3]),
     Connection(count, steps)],
    [tick], Solver=RKDP54, dt=0.01, dt_max=0.02, log=False)

if __name__ == "__main__":
    Sim.run(duration=T)
    Sim.plot()
'''


@pytest.mark.long
def test_a_script_with_everything(tmp_path, models, fresh_editor):
    editor = fresh_editor  # no name is left of another script
    (tmp_path / "everything.py").write_text(SCRIPT)
    models["everything.pvm"] = json.loads(export_script(tmp_path / "everything.py").read_text())
    namespace = {"__name__": "everything"}
    exec(SCRIPT, namespace)
    namespace["Sim"].run(2.0)

    editor.open("everything.pvm")
    assert not [text for _, text, _ in editor.blocks() if "(missing)" in text]
    assert editor.run() == "Simulation completed successfully"
    assert not editor.errors
    assert not editor.complaints()
    names = {"scope": "scope", "steps": "steps", "k_block.inner": "inner"}
    assert_same(editor.runs[0], {node: namespace[name].read() for node, name in names.items()})
    assert max(namespace["inner"].read()[1][0]) <= 1.0
