import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import ODE, Adder, Function, Scope, Source


class Pendulum(ODE):
    """ODE with parameters of its own."""

    def __init__(self, length=1.0, damping=0.2, theta0=0.5):
        super().__init__(
            lambda x, u, t: np.array([x[1], u[0] - damping * x[1] - 9.81 / length * np.sin(x[0])]),
            np.array([theta0, 0.0]),
        )


class Loop(Subsystem):
    def __init__(self, pendulum, kp, kd):
        port, law, add = Interface(), Function(lambda th, w: -kp * th - kd * w), Adder()
        super().__init__(
            [port, pendulum, law, add],
            [
                Connection(pendulum[:2], law[:2], port[:2]),
                Connection(law, add[0]),
                Connection(port, add[1]),
                Connection(add, pendulum),
            ],
        )


push = Source(lambda t: 2.0 * (1 < t < 1.3))
one, two, sc = Loop(Pendulum(), 1.0, 0.5), Loop(Pendulum(0.4, theta0=-0.3), kp=3.0, kd=1.0), Scope()
sim = Simulation(
    [push, one, two, sc],
    [Connection(push, one, two), Connection(one[0], sc[0]), Connection(two[:2], sc[1:3])],
    dt=0.005,
    log=False,
)
sim.run(3)
