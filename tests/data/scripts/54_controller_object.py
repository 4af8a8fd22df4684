"""A controller with memory as a method, two objects of one class."""

from pathsim import Connection, Simulation
from pathsim.blocks import PT1, Adder, Scope, SinusoidalSource, StepSource, Wrapper


class PI:
    def __init__(self, kp, ki, T, limits=(-2.0, 2.0)):
        self.kp, self.ki, self.T, self.limits = kp, ki, T, list(limits)
        self.integral = 0.0
        self.history = []

    def __call__(self, e):
        self.integral += self.ki * e * self.T
        u = min(max(self.kp * e + self.integral, self.limits[0]), self.limits[1])
        self.history.append(u)
        return u


fast, slow = PI(2.0, 1.0, 0.05), PI(kp=0.5, ki=0.1, T=0.2, limits=(0, 1))
a, b = Wrapper(fast, T=0.05), Wrapper(func=slow, T=0.2, tau=0.1)
r, s, e1, e2 = StepSource(), SinusoidalSource(0.2, 1.0), Adder("+-"), Adder("+-")
p, q, sc = PT1(1.0, 0.7), PT1(2.0, 1.5), Scope(labels=["p", "q", "u", "w"])
sim = Simulation(
    [r, s, e1, e2, a, b, p, q, sc],
    [
        Connection(r, e1[0]),
        Connection(p, e1[1], sc[0]),
        Connection(e1, a),
        Connection(a, p, sc[2]),
        Connection(s, e2[0]),
        Connection(q, e2[1], sc[1]),
        Connection(e2, b),
        Connection(b, q, sc[3]),
    ],
    dt=0.01,
    log=False,
)
sim.run(8)
