"""One table for several blocks and functions; one of them changes it."""

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import LUT1D, Function, Scope, Source
from pathsim.events import ScheduleList

grid = np.linspace(0.0, 2.0, 21) ** 2
drag = np.array([0.02, 0.021, 0.025, 0.04, 0.09])
mach = np.arange(5) * 0.25
cd = LUT1D(mach, drag)
also = Function(lambda m: float(np.interp(m, mach, drag)))
m = Source(lambda t: grid[min(int(t * 10), 20)] / 4)


def icing(t):
    drag[:] = drag * 1.5


sc = Scope(labels=["table", "function", "mach"])
sim = Simulation(
    [m, cd, also, sc],
    [Connection(m, cd, also, sc[2]), Connection(cd, sc[0]), Connection(also, sc[1])],
    [ScheduleList([1.0], icing)],
    dt=0.05,
    log=False,
)
sim.run(2)
