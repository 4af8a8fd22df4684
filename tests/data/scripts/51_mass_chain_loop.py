"""A chain of masses, blocks and wires built in loops."""

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope

n, k, c = 4, 20.0, 0.3
v = [Integrator(0.0) for _ in range(n)]
x = [Integrator(0.1 * i) for i in range(n)]
force, wires = [], []
for i in range(n):
    left, right = Amplifier(k), Amplifier(k)
    f = Adder("++---" if i else "+---")
    damp = Amplifier(c)
    own = Amplifier(2 * k)
    force += [left, right, f, damp, own]
    wires += [
        Connection(x[i - 1], left),
        Connection(x[(i + 1) % n], right),
        Connection(x[i], own),
        Connection(v[i], damp),
    ]
    wires += [
        Connection(left, f[0]),
        Connection(right, f[1]),
        Connection(own, f[2]),
        Connection(damp, f[3]),
    ]
    wires += [Connection(f, v[i]), Connection(v[i], x[i])]
sc = Scope(labels=[f"x{i}" for i in range(n)])
sim = Simulation(
    [*v, *x, *force, sc], wires + [Connection(x[i], sc[i]) for i in range(n)], dt=0.005, log=False
)
sim.run(2)
