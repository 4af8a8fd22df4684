"""JSBSim's own search for a trim, kept from crashing and from going on for minutes."""

from __future__ import annotations

import math
import re

import jsbsim

from ..airframe import Airframe
from ..console import messages
from ..forked import Outcome, rehearse
from .condition import MODES, TrimCondition
from .failure import LIMITS, failure
from .state import STATE

_NEAR_GROUND = 200.0  # ft, more than any wheel lies below its aircraft

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


def refuse_hopeless(airframe: Airframe, condition: TrimCondition) -> None:
    """Raise TrimError for conditions that crash JSBSim's search or make it long and futile."""
    fdm = airframe.fdm
    mach = fdm[STATE["mach"]]
    if mach >= 1.0 and airframe.of_engines("propeller-rpm"):
        why = f"Mach {mach:.3g}: propellers give thrust below Mach 1 only"
        raise failure(airframe, condition, "mach", why)
    # the search may still make other fields, such as thrust, finite
    if broken := [name for name in LIMITS if not math.isfinite(fdm[STATE[name]])]:
        why = f"{', '.join(broken)} not finite at this condition"
        raise failure(airframe, condition, "no convergence", why)


def find(airframe: Airframe, condition: TrimCondition) -> None:
    """Let JSBSim search from an airframe's initial conditions."""

    def search() -> bool:
        try:
            airframe.fdm["simulation/do_simple_trim"] = MODES[condition.mode]
        except jsbsim.TrimFailureError:
            return False
        return True

    # with wheels near the ground JSBSim's search may read invalid memory; with constant-speed
    # propellers it may wait minutes for engines that never settle
    near_ground = condition.mode == "ground" or airframe.fdm["position/h-agl-ft"] < _NEAR_GROUND
    if near_ground or any(
        airframe.fdm[name] for name in airframe.of_engines("constant-speed-mode")
    ):
        outcome = rehearse(search, _LONGEST_SEARCH)
        if outcome is not Outcome.ENDS:
            why = "JSBSim's search would crash there"
            if outcome is Outcome.GOES_ON:
                why = f"the search was given up after {_LONGEST_SEARCH} s of computing"
            raise failure(airframe, condition, "no convergence", why)
    # hushed: the TrimError reports the failure
    found, said = messages(search, hushed=True)
    if not found:
        limits = _LIMITS_OF_MODES.get(condition.mode, LIMITS)
        axis = re.search(r"Sorry, (\w+) doesn't appear to be trimmable", " ".join(said))
        powered = airframe.engines or condition.mode == "ground"
        reason = limits[axis[1]] if axis else "no convergence" if powered else "thrust"
        raise failure(airframe, condition, reason)
