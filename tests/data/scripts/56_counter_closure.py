from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, Source
from pathsim.events import Schedule


def pair(start):
    n, log = start, []

    def up(t):
        nonlocal n
        n += 1
        log.append(t)

    def value(t):
        return n + 0.01 * len(log)

    def reset():
        nonlocal n
        n = start

    return up, value, reset


up, value, reset = pair(5)
up(0.0)
up(0.1)
other_up, other_value, _ = pair(-1)
a, b, sc = Source(value), Source(other_value), Scope()
sim = Simulation(
    [a, b, sc],
    [Connection(a, sc[0]), Connection(b, sc[1])],
    [Schedule(t_period=0.3, func_act=up), Schedule(t_start=0.05, t_period=0.2, func_act=other_up)],
    dt=0.01,
    log=False,
)
sim.run(2)
