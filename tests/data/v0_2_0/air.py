# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import CAStoTAS, ISAtmosphere, RampSource, TAStoMach, UnitConversion
from pathsim_jsbsim_blocks.air import isa, pressure_altitude

height = RampSource(final=11000.0, start=0.0, rise_time=10.0)
atmosphere, to_tas, to_mach = ISAtmosphere(), CAStoTAS(), TAStoMach()
knots = UnitConversion("m/s", "kt")
speed = RampSource(final=150.0, start=0.0, rise_time=1e-3)
scope = Scope()
sim = Simulation(
    [height, speed, atmosphere, to_tas, to_mach, knots, scope],
    [
        Connection(height, atmosphere["altitude"], to_tas["altitude"], to_mach["altitude"]),
        Connection(speed, to_tas["cas"]),
        Connection(to_tas["tas"], to_mach["tas"]),
        Connection(to_mach["mach"], scope[3]),
        Connection(atmosphere["pressure"], scope[0]),
        Connection(to_tas[0], knots, scope[1]),
        Connection(knots, scope[2]),
    ],
    dt=0.1,
    log=False,
)
sim.run(10)
time, (pressure, tas, kt, mach) = scope.read()
print(mach[-1], pressure[-1], tas[-1], kt[-1], isa(5000.0).pressure, pressure_altitude(54020.0))
