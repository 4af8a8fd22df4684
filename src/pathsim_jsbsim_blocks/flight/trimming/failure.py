"""The error of a failed trim: the limit reached, and the residuals."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ...errors import TrimError
from ..airframe import Airframe
from .condition import TrimCondition
from .state import STATE

# the axis that JSBSim reports as not trimmable -> the control that ran out (FGTrim::SetMode)
LIMITS = {
    "udot": "thrust",
    "vdot": "bank",
    "wdot": "alpha limit",
    "pdot": "aileron",
    "qdot": "elevator",
    "rdot": "rudder",
}


def alpha_range(airframe: Airframe) -> tuple[float, float]:
    """Limits of the angle of attack in deg."""
    low, high = (math.degrees(airframe.fdm[f"aero/alpha-{end}-rad"]) for end in ("min", "max"))
    # JSBSim's range for models that give no limits (FGTrimAxis)
    return (low, high) if low < high else (-5.0, 20.0)


def failure(
    airframe: Airframe,
    condition: TrimCondition,
    reason: str,
    why: str = "",
    residuals: Mapping[str, float] | None = None,
    limit: float | None = None,
    **data: Any,
) -> TrimError:
    """The error, with further data of a `TrimError`."""
    fdm = airframe.fdm
    state_text = "without trim" if residuals is None else "at best"
    if residuals is None:
        residuals = {name: fdm[STATE[name]] for name in LIMITS}
    alpha_min, alpha_max = alpha_range(airframe)
    thrust = "the throttle is insufficient at the end of its range"
    if len(airframe.stopped) == airframe.engines:
        thrust = f"it has no {'running ' if airframe.stopped else ''}engine to hold the speed with "
        thrust += "(mode='glide' frees the path angle)"
    limits = {
        "thrust": thrust,
        "alpha limit": f"alpha reached the end of [{alpha_min:.4g}, {alpha_max:.4g}] deg",
        "elevator": "the pitch control is insufficient at the end of its range",
        "aileron": "the aileron is insufficient at the end of its range",
        "rudder": "the rudder is insufficient at the end of its range",
        "propeller": "a propeller does not settle at this condition",
        "no convergence": "the search did not converge, and no limit was shown to prevent it",
    }
    why = why or limits.get(reason, f"the {reason} reached the end of its range")
    if limit is not None:
        why += f", {limit + 0.0:.4g}"
    if zeros := airframe.created_as_zero():
        why += f" ({zeros})"
    text = ", ".join(f"{name}={value:.3g}" for name, value in residuals.items())
    return TrimError(
        f"aircraft {airframe.aircraft!r} does not trim at {condition}: {why}; {state_text} {text} "
        "(ft/s2, rad/s2)",
        aircraft=airframe.aircraft,
        condition=condition,
        reason=reason,
        residuals=residuals,
        limit=limit,
        **data,
    )
