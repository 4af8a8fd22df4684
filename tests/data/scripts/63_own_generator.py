import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Function, Scope, SinusoidalSource, Wrapper

rng = np.random.default_rng(2024)
bias, noise = rng.normal(0, 0.2), rng.normal(size=50)


class Sensor:
    def __init__(self, sigma, rng):
        self.sigma, self.rng, self.last = sigma, rng, None

    def measure(self, u):
        self.last = u + self.sigma * self.rng.normal()
        return self.last


sensor = Sensor(0.1, rng)
src, meas = SinusoidalSource(0.3, 1.0), Wrapper(sensor.measure, T=0.1)
drift, sc = Function(lambda u: u + bias + noise[int(abs(u) * 10) % 50]), Scope()
sim = Simulation(
    [src, meas, drift, sc],
    [Connection(src, meas, drift), Connection(meas, sc[0]), Connection(drift, sc[1])],
    dt=0.02,
    log=False,
)
sim.run(5)
