"""Subsystems from a function, in a subsystem, with functions that capture."""

import math
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Function, Integrator, Scope, Source


def lag(tau, nonlinear=None):
    port, err, rate, x = Interface(), Adder("+-"), Amplifier(1 / tau), Integrator()
    shape = Function(nonlinear or (lambda v: v))
    return Subsystem(
        [port, err, shape, rate, x],
        [
            Connection(port, err[0]),
            Connection(x, err[1], port),
            Connection(err, shape),
            Connection(shape, rate),
            Connection(rate, x),
        ],
    )


def cascade(taus):
    port, parts = Interface(), [lag(t, lambda v, t=t: math.tanh(v) * t / max(taus)) for t in taus]
    wires = [Connection(port, parts[0]), Connection(parts[-1], port)]
    wires += [Connection(a, b) for a, b in zip(parts, parts[1:])]
    return Subsystem([port, *parts], wires)


src, sys1, sys2, sc = (
    Source(lambda t: math.copysign(1, math.sin(t))),
    cascade([0.1, 0.3]),
    cascade((0.5, 0.2, 0.4)),
    Scope(),
)
sim = Simulation(
    [src, sys1, sys2, sc],
    [Connection(src, sys1, sys2), Connection(sys1, sc[0]), Connection(sys2, sc[1])],
    dt=0.02,
    log=False,
)
sim.run(6)
