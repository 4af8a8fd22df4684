# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, PitchHold

plane = Aircraft("737", altitude=10000, speed=280, gear=0, T=1 / 60, substeps=2)
hold = PitchHold("737", T=1 / 60)
step = StepSource(3.0, 1.0)
scope = Scope()
sim = Simulation(
    [plane, hold, step, scope],
    [
        Connection(step, hold["theta_ref"]),
        Connection(plane["theta"], hold["theta"], scope),
        Connection(plane["q"], hold["q"]),
        Connection(plane["elev_sat"], hold["elev_sat"]),
        Connection(hold["elevator"], plane["elevator"]),
    ],
    dt=1 / 60,
    log=False,
)
sim.run(20)
time, (theta,) = scope.read()
print(theta[0], theta.max(), theta[-1])
