from collections import deque
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import FIR, Scope, Source, SampleHold, Wrapper

taps = np.hamming(8) / np.hamming(8).sum()


class Median:
    """Median of the last samples, kept in a deque."""

    size = 5

    def __init__(self):
        self.window = deque([0.0] * self.size, maxlen=self.size)

    def step(self, u):
        self.window.append(float(u))
        return sorted(self.window)[self.size // 2]


Median.size = 3
src = Source(lambda t: np.sin(t) + (0.5 if int(t * 10) % 7 == 0 else 0.0))
hold, fir, med, sc = (
    SampleHold(T=0.1),
    FIR(coeffs=taps, T=0.1),
    Wrapper(Median().step, T=0.1),
    Scope(),
)
sim = Simulation(
    [src, hold, fir, med, sc],
    [
        Connection(src, hold, fir, med),
        Connection(hold, sc[0]),
        Connection(fir, sc[1]),
        Connection(med, sc[2]),
    ],
    dt=0.05,
    log=False,
)
sim.run(10)
