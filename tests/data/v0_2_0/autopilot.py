# written for version 0.2.0
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, Autopilot, fly

plane = Aircraft("c172p", altitude=5000, speed=90, heading=350)
pilot = Autopilot("c172p", psi_ref=30.0, h_ref=5200.0)
scope = Scope(labels=["psi", "h", "vc", "phi"])
names = ["theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "alpha", "beta"]
wires = [Connection(plane[n], pilot[n]) for n in names]
wires += [Connection(plane[n], pilot[n]) for n in ("elev_sat", "ail_sat", "thr_sat")]
wires += [Connection(pilot[n], plane[n]) for n in ("elevator", "aileron", "rudder", "throttle")]
wires += [Connection(plane[n], scope[i]) for i, n in enumerate(("psi", "h", "vc", "phi"))]
sim = Simulation([plane, pilot, scope], wires, dt=1 / 120, log=False)
fly(sim, 60)
time, (psi, h, vc, phi) = scope.read()
print(psi[-1], h[-1], vc[-1], phi.max())
