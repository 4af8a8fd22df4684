# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, OneMinusCosineGust, YawDamper

plane = Aircraft("global5000", altitude=15000, speed=250, gear=0)
gust = OneMinusCosineGust(gradient=250.0, airspeed=500.0, altitude=15000.0, start=1.0)
damper, scope = YawDamper("global5000"), Scope()
sim = Simulation(
    [plane, gust, damper, scope],
    [
        Connection(gust, plane["wind_east"]),
        Connection(plane["r"], damper["r"], scope[0]),
        Connection(damper["rudder"], plane["rudder"]),
        Connection(plane["beta"], scope[1]),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(8)
time, (r, beta) = scope.read()
print(r.max(), r.min(), abs(beta).max())
