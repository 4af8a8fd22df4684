# written for version 0.2.0
from pathsim_jsbsim_blocks.axes import geodetic_to_ned, great_circle, ned_to_body, wind_to_body
from pathsim_jsbsim_blocks.units import conversion

print(*geodetic_to_ned(47.01, 8.02, 5000.0, 47.0, 8.0, 4000.0))
print(*great_circle((47.0, 8.0), (48.0, 9.0))[2])
print(*ned_to_body(100.0, 20.0, 5.0, 10.0, 5.0, 30.0), *wind_to_body(100.0, 0.0, 0.0, 4.0, 2.0))
print(*conversion("kt", "m/s"), *conversion("degF", "K"))
