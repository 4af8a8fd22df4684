"""Blocks changed after they are built: attributes, a switch, an operating point."""

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Integrator, Scope, SinusoidalSource, Switch

src, a, b, sw, x, sc = (
    SinusoidalSource(),
    Amplifier(1.0),
    Amplifier(-1.0),
    Switch(0),
    Integrator(),
    Scope(),
)
src.frequency, src.amplitude = 0.8, 2.0
for block, gain in ((a, 0.5), (b, -0.25)):
    block.gain = gain * np.pi
sw.select(1)
x.engine.set(0.75) if x.engine else None
sim = Simulation(
    [src, a, b, sw, x, sc],
    [
        Connection(src, a, b),
        Connection(a, sw[0]),
        Connection(b, sw[1]),
        Connection(sw, x, sc[1]),
        Connection(x, sc[0]),
    ],
    dt=0.01,
    log=False,
)
x.engine.set(0.25)
sim.dt = 0.02
if __name__ == "__main__":
    T = 3
    sim.run(T)
