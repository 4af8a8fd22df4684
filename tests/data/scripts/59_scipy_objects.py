import numpy as np
from scipy import signal
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
from pathsim import Connection, Simulation
from pathsim.blocks import Function, Scope, Source, StateSpace

b, a = signal.butter(3, 2.0, analog=True)
A, B, C, D = signal.tf2ss(b, a)
filt = StateSpace(A, B, C, D)
spline = CubicSpline([0, 1, 2, 3, 4], [0, 1, -1, 2, 0])
src, sat, sc = Source(spline), Function(lambda u: np.clip(u, -0.8, 0.8)), Scope()
phi = expm(np.array([[0, 1], [-1, 0]]) * 0.1)
other = Source(lambda t: float((phi @ np.array([np.cos(t), np.sin(t)]))[0]))
sim = Simulation(
    [src, filt, sat, other, sc],
    [
        Connection(src, filt),
        Connection(filt, sat, sc[0]),
        Connection(sat, sc[1]),
        Connection(other, sc[2]),
    ],
    dt=0.01,
    log=False,
)
sim.run(4)
