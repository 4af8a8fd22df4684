"""JSBSim's own search for a trim: the only one on the ground, and that of published numbers."""

from __future__ import annotations

import re

import jsbsim

from ..._core.aircraft_ports import property_of
from ..airframe import Airframe
from ..console import messages
from ..forked import Outcome, run_in_fork
from .condition import MODES, TrimCondition
from .failure import LIMITS, failure

_NEAR_GROUND = 200.0  # ft, more than the height of any aircraft above its wheels

# s of CPU time; a search that finds its trim takes less than half a second
_LONGEST_SEARCH = 10

# as `LIMITS`, in other modes
_LIMITS_OF_MODES = {
    "turn": {**LIMITS, "vdot": "sideslip"},
    "pull-up": {**LIMITS, "nlf": "alpha limit", "hmgt": "sideslip"},
    "ground": {"wdot": "height", "qdot": "pitch angle", "pdot": "bank"},
}

# what JSBSim's search moves in each mode (FGTrim::SetMode)
_LONGITUDINAL = ("alpha", "throttle", "pitch_trim")
MOVED = {
    "longitudinal": _LONGITUDINAL,
    "full": (*_LONGITUDINAL, "phi", "aileron", "rudder"),
    "ground": ("altitude", "theta", "phi"),
    "pull-up": (*_LONGITUDINAL, "beta", "phi", "aileron", "rudder"),
    "turn": (*_LONGITUDINAL, "beta", "aileron", "rudder"),
}


def find(airframe: Airframe, condition: TrimCondition) -> tuple[str, ...]:
    """Run JSBSim's search from an airframe's initial conditions; return its unknowns."""
    on_ground = condition.mode == "ground"
    low = airframe.fdm[property_of("h_agl")] < _NEAR_GROUND
    governors = airframe.of_engines("constant-speed-mode")
    why = ""
    if not on_ground and low:
        why = f"below {_NEAR_GROUND:g} ft above the ground JSBSim's search may end the process"
    elif not on_ground and any(airframe.fdm[name] for name in governors):
        why = "with constant-speed propellers JSBSim's search may never end"
    if why:
        why += "; use solver='newton' of TrimCondition"
        raise failure(airframe, condition, "no convergence", why)

    def search() -> bool:
        try:
            airframe.fdm["simulation/do_simple_trim"] = MODES[condition.mode]
        except jsbsim.TrimFailureError:
            return False
        return True

    # on the ground it may read invalid memory (f15, SGS, minisgs)
    outcome = run_in_fork(search, _LONGEST_SEARCH) if on_ground else Outcome.OK
    if outcome is not Outcome.OK:
        why = "JSBSim's search would crash"
        if outcome is Outcome.TIMEOUT:
            why = f"the search was stopped after {_LONGEST_SEARCH} s of computing"
        raise failure(airframe, condition, "no convergence", why)
    # hushed: the TrimError reports the failure
    success, records = messages(search, hushed=True)
    if not success:
        limits = _LIMITS_OF_MODES.get(condition.mode, LIMITS)
        text = " ".join(text for _, text in records)
        axis = re.search(r"Sorry, (\w+) doesn't appear to be trimmable", text)
        raise failure(airframe, condition, limits[axis[1]] if axis else "no convergence")
    return MOVED[condition.mode]
