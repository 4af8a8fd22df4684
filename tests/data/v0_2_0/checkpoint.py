# written for version 0.2.0
from pathsim import Simulation

from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft("c172p", altitude=5000, speed=90, record_inputs=True)
sim = Simulation([plane], dt=1 / 120, log=False)
sim.run(1)
sim.save_checkpoint("half")
