# written for version 0.2.0
from pathsim_jsbsim_blocks import Autopilot

print(Autopilot("c172p").to_jsbsim_xml(engines=1))
