# written for version 0.2.0
from pathsim_jsbsim_blocks import TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, level_flight, trim

fast = trim(Airframe("737"), TrimCondition(altitude=20000, mach=0.6, gear=0))
print(fast.alpha, *fast.throttle)
descent = trim(Airframe("c172p"), TrimCondition(altitude=2000, speed=80, gamma=-3))
print(descent.alpha, *descent.throttle)
level = level_flight("c172p")
print(level.condition.altitude, level.condition.speed)
