"""Cost of diagrams without an aircraft: with this package imported, and without.

    python benchmarks/host.py

Two processes in turn build PathSim's own blocks 1,000 times into a diagram and run each for ten
steps. The package replaces nothing of PathSim, so the ratio is 1.
"""

import subprocess
import sys

from report import HEADER, row

REPETITIONS = 7
CODE = """
import time
IMPORT
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope, Source

def short_run():
    source, error, gain = Source(lambda t: 1.0), Adder("+-"), Amplifier(2.0)
    state, scope = Integrator(), Scope()
    wires = [
        Connection(source, error[0]),
        Connection(state, error[1], scope),
        Connection(error, gain),
        Connection(gain, state),
    ]
    Simulation([source, error, gain, state, scope], wires, dt=0.01, log=False).run(0.1)

short_run()
began = time.process_time()
for _ in range(1000):
    short_run()
print(time.process_time() - began)
"""


def seconds(imported):
    code = CODE.replace("IMPORT", imported)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(done.stdout)


def rows():
    ours, plain = [], []
    for _ in range(REPETITIONS):
        ours.append(seconds("from pathsim_jsbsim_blocks import *"))
        plain.append(seconds(""))
    what, peer = "1,000 short runs without an aircraft", "without the package"
    row(what, peer, ours, plain, "s", 1.05, "pathsim")


if __name__ == "__main__":
    print(HEADER)
    rows()
