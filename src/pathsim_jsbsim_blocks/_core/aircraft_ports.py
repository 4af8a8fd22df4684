"""The ports of an aircraft, and the JSBSim properties behind them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

DEG = 180.0 / math.pi

# deg; JSBSim returns north with a rounding error as nearly 360: headings above this count as 0
ALMOST_NORTH = 360.0 - 1e-9


class Port(NamedTuple):
    """Source of a port: a property (None for a command's excess over its limit), factor, unit."""

    property: str | None
    factor: float = 1.0
    unit: str = ""


EXCESS = Port(None, unit="norm")

# models store the port numbers, so new ports are appended
OUTPUTS: dict[str, Port] = {
    "theta": Port("attitude/theta-deg", unit="deg"),
    "phi": Port("attitude/phi-deg", unit="deg"),
    "psi": Port("attitude/psi-deg", unit="deg"),
    "p": Port("velocities/p-rad_sec", DEG, "deg/s"),
    "q": Port("velocities/q-rad_sec", DEG, "deg/s"),
    "r": Port("velocities/r-rad_sec", DEG, "deg/s"),
    "alpha": Port("aero/alpha-deg", unit="deg"),
    "beta": Port("aero/beta-deg", unit="deg"),
    "gamma": Port("flight-path/gamma-deg", unit="deg"),
    "h": Port("position/h-sl-ft", unit="ft"),
    "hdot": Port("velocities/h-dot-fps", unit="ft/s"),
    "vc": Port("velocities/vc-kts", unit="kt"),
    "vt": Port("velocities/vt-fps", unit="ft/s"),
    "mach": Port("velocities/mach"),
    "nx": Port("accelerations/Nx"),
    "nz": Port("accelerations/Nz"),
    "lat": Port("position/lat-geod-deg", unit="deg"),
    "lon": Port("position/long-gc-deg", unit="deg"),
    **dict.fromkeys(("elev_sat", "ail_sat", "rud_sat", "thr_sat"), EXCESS),
}

SURFACES = {name: f"fcs/{name}-cmd-norm" for name in ("elevator", "aileron", "rudder")}
WIND = {f"wind_{axis}": f"atmosphere/gust-{axis}-fps" for axis in ("north", "east", "down")}


def throttles(engines: int) -> list[str]:
    """The commands that port ``throttle`` writes."""
    return [f"fcs/throttle-cmd-norm[{i}]" for i in range(engines)]


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


def property_of(port: str) -> Any:
    """The property of an output; the name of a property is returned as it is."""
    return SHORT_OUTPUTS[port][0] if port in SHORT_OUTPUTS else OUTPUTS.get(port, Port(port))[0]


# other names of ports and parameters, in lower case
SYNONYMS = {
    "theta": "pitch pitch_angle",
    "phi": "roll bank roll_angle bank_angle",
    "psi": "heading yaw",
    "p": "roll_rate",
    "q": "pitch_rate",
    "r": "yaw_rate",
    "alpha": "aoa angle_of_attack",
    "beta": "sideslip",
    "gamma": "fpa path_angle flight_path_angle",
    "h": "altitude alt height",
    "altitude": "height h",
    "hdot": "climb climb_rate rate_of_climb vertical_speed vs",
    "vc": "airspeed speed cas kcas ias",
    "vt": "airspeed speed tas v",
    "mach": "m",
    "nz": "load_factor g",
    "density": "rho",
    "temperature": "t",
    "speed_of_sound": "a",
    "viscosity": "mu",
    "step": "width",  # of a pulse, in s, as the other sources call it
}
