"""Short names of an aircraft's ports, and the JSBSim properties behind them."""

from __future__ import annotations

import math
from collections.abc import Mapping

DEG = 180.0 / math.pi

# deg; a heading above this is north with a rounding error, which JSBSim shows as up to 360
ALMOST_NORTH = 360.0 - 1e-9

EXCESS = (None, 1.0)

# port: (property, or None for a command's excess over its limit; factor to the port's unit).
# Models store the port numbers, so new ports are appended
OUTPUTS: dict[str, tuple[str | None, float]] = {
    "theta": ("attitude/theta-deg", 1.0),
    "phi": ("attitude/phi-deg", 1.0),
    "psi": ("attitude/psi-deg", 1.0),
    "p": ("velocities/p-rad_sec", DEG),
    "q": ("velocities/q-rad_sec", DEG),
    "r": ("velocities/r-rad_sec", DEG),
    "alpha": ("aero/alpha-deg", 1.0),
    "beta": ("aero/beta-deg", 1.0),
    "gamma": ("flight-path/gamma-deg", 1.0),
    "h": ("position/h-sl-ft", 1.0),
    "hdot": ("velocities/h-dot-fps", 1.0),
    "vc": ("velocities/vc-kts", 1.0),
    "vt": ("velocities/vt-fps", 1.0),
    "mach": ("velocities/mach", 1.0),
    "nx": ("accelerations/Nx", 1.0),
    "nz": ("accelerations/Nz", 1.0),
    "lat": ("position/lat-geod-deg", 1.0),
    "lon": ("position/long-gc-deg", 1.0),
    "elev_sat": EXCESS,
    "ail_sat": EXCESS,
    "rud_sat": EXCESS,
    "thr_sat": EXCESS,
}

# port: property
SURFACES = {
    "elevator": "fcs/elevator-cmd-norm",
    "aileron": "fcs/aileron-cmd-norm",
    "rudder": "fcs/rudder-cmd-norm",
}

# names that stand for properties, as inputs and as outputs; [i] is the number of an engine
SHORT_INPUTS: Mapping[str, tuple[str, ...]] = {
    "flaps": ("fcs/flap-cmd-norm",),
    "gear": ("gear/gear-cmd-norm",),
    "speedbrake": ("fcs/speedbrake-cmd-norm",),
    "spoilers": ("fcs/spoiler-cmd-norm",),
    "brakes": ("fcs/left-brake-cmd-norm", "fcs/right-brake-cmd-norm", "fcs/center-brake-cmd-norm"),
    "left_brake": ("fcs/left-brake-cmd-norm",),
    "right_brake": ("fcs/right-brake-cmd-norm",),
    "steering": ("fcs/steer-cmd-norm",),
    "throttle[i]": ("fcs/throttle-cmd-norm[i]",),
}
SHORT_OUTPUTS: Mapping[str, tuple[str, ...]] = {
    "flaps": ("fcs/flap-pos-norm",),
    "gear": ("gear/gear-pos-norm",),
    "speedbrake": ("fcs/speedbrake-pos-norm",),
    "spoilers": ("fcs/spoiler-pos-norm",),
    "throttle[i]": ("fcs/throttle-pos-norm[i]",),
    "thrust[i]": ("propulsion/engine[i]/thrust-lbs",),
    "h_agl": ("position/h-agl-ft",),
}
