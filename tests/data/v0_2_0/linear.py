# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, LinearAircraft, TrimCondition
from pathsim_jsbsim_blocks.flight import linear_model

flown = Aircraft("737", altitude=10000, speed=280, gear=0)
linear = LinearAircraft("737", altitude=10000, speed=280, gear=0)
doublet, scope = DoubletSource(amplitude=0.05, start=1.0, width=1.0), Scope()
sim = Simulation(
    [flown, linear, doublet, scope],
    [
        Connection(doublet, flown["elevator"], linear["elevator"]),
        Connection(flown["alpha"], scope[0]),
        Connection(linear["alpha"], scope[1]),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(5)
time, (alpha, of_model) = scope.read()
print(alpha.max(), alpha.min(), of_model.max())
model = linear_model("737", TrimCondition(altitude=10000, speed=280, gear=0))
short = next(m for m in model.modes() if m.name == "short period")
print(short.frequency, short.damping)
