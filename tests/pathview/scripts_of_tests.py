"""Small scripts, and what tests look at in their models."""

HEAD = """
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import *
from pathsim.solvers import *
"""

LOOP = """
i = Integrator(1.0)
a = Amplifier(-1.0)
s = Scope()
sim = Simulation([i, a, s], [Connection(i, a, s), Connection(a, i)], dt=0.01, log=False)
"""

OSCILLATOR = '''
"""Oscillator: a mass on a spring.

Second paragraph with ``code``.
"""
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope
from pathsim.solvers import RKCK54

# initial position
x0 = 2.0  # m
k, d = 0.8, 0.2

velocity = Integrator()
position = Integrator(x0)
spring = Amplifier(gain=-k)
damper = Amplifier(-d)
force = Adder()
scope = Scope(labels=["v",
                      "x"])  # two signals
sim = Simulation(
    [velocity, position, spring, damper, force, scope],
    [
        Connection(velocity, position, damper, scope[0]),
        Connection(position, spring, scope[1]),
        Connection(spring, force[0]),
        Connection(damper, force[1]),
        Connection(force, velocity),
    ],
    Solver=RKCK54, dt=1 / 100, tolerance_lte_rel=1e-6, log=False)

if __name__ == "__main__":
    sim.run(10 * np.pi)
'''


def script(blocks, wires="", before="", names=None, after="", events="[]"):
    """A script that builds the blocks given as statements."""
    names = names or ", ".join(
        line.split(" = ")[0]
        for line in blocks.splitlines()
        if " = " in line and not line.startswith(" ")
    )
    return f"""{HEAD}{before}
{blocks}
sim = Simulation([{names}], [{wires}], {events}, log=False)
{after}
"""


def node(model, name):
    return next(n for n in model["graph"]["nodes"] if n["name"] == name)


def kinds(graph):
    """Names and types of the nodes of all levels."""
    for node in graph["nodes"]:
        yield node["name"], node["type"]
        yield from kinds(node.get("graph") or {"nodes": []})


def names(model):
    return [n["name"] for n in model["graph"]["nodes"]]


def code(model):
    return model["codeContext"]["code"]


def wires(model):
    return {
        (c["sourceNodeId"], c["sourcePortIndex"], c["targetNodeId"], c["targetPortIndex"])
        for c in model["graph"]["connections"]
    }
