from collections import defaultdict, namedtuple
from functools import lru_cache, partial
from types import SimpleNamespace
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

Wave = namedtuple("Wave", "amplitude frequency")
waves = [Wave(1.0, 0.5), Wave(0.3, 2.0)]
calls = defaultdict(int)


@lru_cache(maxsize=None)
def factor(n):
    return 1.0 if n < 2 else n * factor(n - 1)


def tone(wave, shift, t):
    calls[wave.frequency] += 1
    return wave.amplitude * np.sin(2 * np.pi * wave.frequency * t + shift) / factor(3)


cfg = SimpleNamespace(scale=2.0, taps=[0.5, 0.25])
first, second = (Source(partial(tone, w, 0.1 * i)) for i, w in enumerate(waves))
total = Source(
    lambda t: cfg.scale * sum(k * tone(waves[1], 0.0, t - i) for i, k in enumerate(cfg.taps))
)
sc = Scope()
sim = Simulation(
    [first, second, total, sc],
    [Connection(first, sc[0]), Connection(second, sc[1]), Connection(total, sc[2])],
    dt=0.02,
    log=False,
)
sim.run(2)
