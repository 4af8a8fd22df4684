# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import Aircraft, AltitudeHold, RollHold, YawDamper

plane = Aircraft("c172p", altitude=3000, speed=90)
height, bank, damper = AltitudeHold("c172p"), RollHold("c172p"), YawDamper("c172p")
turn, scope = Constant(20.0), Scope()
sim = Simulation(
    [plane, height, bank, damper, turn, scope],
    [
        Connection(plane["h"], height["h"], scope[0]),
        Connection(plane["hdot"], height["hdot"]),
        Connection(plane["vc"], height["vc"]),
        Connection(plane["theta"], height["theta"]),
        Connection(plane["q"], height["q"]),
        Connection(plane["phi"], bank["phi"], scope[1]),
        Connection(plane["p"], bank["p"]),
        Connection(plane["r"], damper["r"]),
        Connection(turn, bank["phi_ref"]),
        Connection(height["elevator"], plane["elevator"]),
        Connection(bank["aileron"], plane["aileron"]),
        Connection(damper["rudder"], plane["rudder"]),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(30)
time, (h, phi) = scope.read()
print(h.min(), h.max(), phi[-1])
