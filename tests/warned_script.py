"""A script that gives three of this package's warnings, and its user's own one."""

import os
import signal
import warnings

from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import DiscretePID

OWN = "the user's own"


def deadly(x):
    """A case that its worker does not survive."""
    if x == 2:
        os.kill(os.getpid(), signal.SIGKILL)
    return {"y": x}


reference = Constant(1.0)
controller = DiscretePID(Kp=0.5, T=0.01)
scope = Scope()
sim = Simulation(
    [reference, controller, scope],
    [Connection(reference, controller["r"]), Connection(controller["u"], scope)],
    dt=0.003,
    log=False,
)

if __name__ == "__main__":
    from pathsim_jsbsim_blocks.studies import run_batch

    sim.run(0.1)
    run_batch(deadly, {"x": [1, 2, 3]}, jobs=2, progress=False)
    warnings.warn(OWN, stacklevel=1)
    sim.run(0.1)
