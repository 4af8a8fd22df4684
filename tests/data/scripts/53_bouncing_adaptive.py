import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope
from pathsim.events import ZeroCrossing
from pathsim.solvers import RKBS32

g, e, h0 = 9.81, 0.85, 1.5
Iv, Ix, C, Sc = Integrator(0.0), Integrator(h0), Constant(-g), Scope(labels=["x", "v"])


def func_evt(t):
    *_, x = Ix()
    return x


def func_act(t):
    *_, x = Ix()
    *_, v = Iv()
    Ix.engine.set(abs(x))
    Iv.engine.set(-e * v)


E1 = ZeroCrossing(func_evt=func_evt, func_act=func_act, tolerance=1e-4)
Sim = Simulation(
    [Iv, Ix, C, Sc],
    [Connection(C, Iv), Connection(Iv, Ix, Sc[1]), Connection(Ix, Sc[0])],
    [E1],
    dt=0.1,
    Solver=RKBS32,
    tolerance_lte_rel=1e-5,
    tolerance_lte_abs=1e-7,
    log=False,
)
Sim.run(3.0)
