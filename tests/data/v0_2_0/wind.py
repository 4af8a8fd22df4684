# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import Aircraft, DrydenTurbulence, WindShear

plane = Aircraft("c172p", altitude=1000, speed=85, output_properties=["h_agl"])
turbulence = DrydenTurbulence(severity="light", span=35.8, seed=3)
shear, low, scope = WindShear(wind_20ft=15.0, direction=270.0), Constant(100.0), Scope()
sim = Simulation(
    [plane, turbulence, shear, low, scope],
    [
        Connection(plane["h_agl"], turbulence["h"]),
        Connection(plane["vt"], turbulence["vt"]),
        Connection(plane["psi"], turbulence["psi"]),
        Connection(low, shear["h"]),
        Connection(shear["east"], scope[0]),
        Connection(turbulence["north"], plane["wind_north"]),
        Connection(turbulence["down"], plane["wind_down"], scope[1]),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(10)
time, (east, down) = scope.read()
print(east[-1], down.max(), down.min())
