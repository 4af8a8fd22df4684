# written for version 0.2.0
from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft("c172p", altitude=5000, speed=90, systems=["autopilot.xml"])
