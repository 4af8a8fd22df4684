import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import *
from pathsim.events import *

rates = {"fast": 0.2, "slow": 1.1}
delays = {name: Delay(tau) for name, tau in rates.items()}
pulse, rect = PulseSource(amplitude=2.0, T=3.0, duty=0.4), SquareWaveSource(frequency=0.4)
mul, mod, sc = Multiplier(), Mod(0.7), Scope(labels=[*rates, "product", "mod"])
blocks = [pulse, rect, *delays.values(), mul, mod, sc]
fast, slow = delays.values()
connections = [
    Connection(pulse, fast, mul[0]),
    Connection(rect, slow, mul[1]),
    Connection(fast, sc[0]),
    Connection(slow, sc[1]),
    Connection(mul, mod, sc[2]),
    Connection(mod, sc[3]),
]
sim = Simulation(blocks, connections, dt=0.02, log=False)
sim.run(6)
