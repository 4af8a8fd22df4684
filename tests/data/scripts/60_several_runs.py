"""Gains swept in a loop of runs, results collected."""

from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope, StepSource
from pathsim.solvers import SSPRK33

ref, err, ctl, plant, sc = StepSource(1.0, 0.2), Adder("+-"), Amplifier(1.0), Integrator(), Scope()
sim = Simulation(
    [ref, err, ctl, plant, sc],
    [
        Connection(ref, err[0]),
        Connection(err, ctl),
        Connection(ctl, plant),
        Connection(plant, err[1], sc),
    ],
    Solver=SSPRK33,
    dt=0.02,
    log=False,
)
results = {}
for gain in (0.5, 1.0, 4.0):
    ctl.gain = gain
    sim.run(3, reset=True)
    results[gain] = sc.read()[1][0][-1]
print(results)
