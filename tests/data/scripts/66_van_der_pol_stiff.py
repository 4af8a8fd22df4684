import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import ODE, Scope
from pathsim.solvers import ESDIRK54

mu = 50.0
x0 = np.array([2.0, 0.0])


def rhs(x, u, t):
    return np.array([x[1], mu * (1 - x[0] ** 2) * x[1] - x[0]])


def jac(x, u, t):
    return np.array([[0, 1], [-2 * mu * x[0] * x[1] - 1, mu * (1 - x[0] ** 2)]])


vdp, sc = ODE(rhs, x0, jac), Scope(labels=["x"])
sim = Simulation(
    [vdp, sc],
    [Connection(vdp, sc)],
    Solver=ESDIRK54,
    dt=0.01,
    dt_max=1.0,
    tolerance_lte_rel=1e-3,
    tolerance_lte_abs=1e-5,
    tolerance_fpi=1e-9,
    log=False,
)
sim.run(20)
