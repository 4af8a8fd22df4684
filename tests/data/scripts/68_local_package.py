"""Everything in one function, with a module beside the script as an object."""

import plantlib
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source


def main(duration=4.0):
    src = Source(lambda t: plantlib.KP * (t > 1))
    plant, gain, sc = plantlib.plant(1.5), plantlib.make_gain(0.5), Scope(labels=["y", "u"])
    sim = Simulation(
        [src, plant, gain, sc],
        [Connection(src, plant, sc[1]), Connection(plant, gain), Connection(gain, sc[0])],
        dt=0.02,
        log=False,
    )
    sim.run(duration)
    return sc.read()


if __name__ == "__main__":
    main(3.0)
