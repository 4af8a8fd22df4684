"""Vector signals through matrices, and a function of several outputs."""

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import ODE, Amplifier, Function, Integrator, Scope, Source

R = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
G = {"kp": np.diag([2.0, 3.0]), "kd": 0.4 * np.eye(2)}
pos, vel = Integrator(np.array([1.0, -1.0])), Integrator(np.zeros(2))
law = Function(lambda x, y, u, v: tuple(R @ (-G["kp"] @ np.array([x, y]) - G["kd"] @ [u, v])))
wind = Source(lambda t: 0.1 * np.sin(3 * t))
lorenz = ODE(
    lambda x, u, t, s=10.0, r=28.0, b=8 / 3: np.array(
        [s * (x[1] - x[0]), x[0] * (r - x[2]) - x[1], x[0] * x[1] - b * x[2]]
    ),
    np.array([1.0, 1.0, 1.0]),
)
half, sc = Amplifier(0.5), Scope()
sim = Simulation(
    [pos, vel, law, wind, lorenz, half, sc],
    [
        Connection(pos[:2], law[:2], sc[:2]),
        Connection(vel[:2], law[2:4], pos[:2]),
        Connection(law[:2], vel[:2]),
        Connection(lorenz[0], half, sc[2]),
        Connection(half, sc[3]),
        Connection(wind, sc[4]),
    ],
    dt=0.01,
    log=False,
)
sim.run(2)
