# written for version 0.2.0
from pathsim_jsbsim_blocks.daveml import write_aircraft

write_aircraft("glider", aero="aero.dml", inertia="inertia.dml", folder="here")
