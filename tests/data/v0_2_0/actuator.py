# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope
from pathsim.solvers import RK4

from pathsim_jsbsim_blocks import Actuator, Aircraft, DiscretePID, Sensor

plane = Aircraft("c172p", altitude=3000, speed=80)
sensor, surface = Sensor(bias=0.1, noise=0.05, seed=3), Actuator(frequency=20.0, max_rate=2.0)
pid = DiscretePID(Kp=0.06, Ki=0.06, low=-0.5, high=0.5)
total, scope = Integrator(), Scope()
sim = Simulation(
    [plane, sensor, pid, surface, total, scope],
    [
        Connection(plane["phi"], sensor, total, scope[0]),
        Connection(sensor, pid["y"]),
        Connection(pid["u"], surface["u"]),
        Connection(surface["y"], plane["aileron"]),
        Connection(total, scope[1]),
    ],
    dt=1 / 120,
    Solver=RK4,
    log=False,
)
sim.run(10)
time, (phi, integral) = scope.read()
print(phi.max(), phi[-1], integral[-1])
