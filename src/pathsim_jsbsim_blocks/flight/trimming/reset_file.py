"""The state in a JSBSim reset file as fields of a condition; JSBSim reads the file."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from typing import Any

from ..airframe import Airframe
from ..script import reset_file

# JSBSim's initial conditions, the place first
_INITIAL = (
    *("lat-geod-deg", "long-gc-deg", "terrain-elevation-ft", "h-sl-ft"),
    *("phi-rad", "theta-rad", "psi-true-rad", "u-fps", "v-fps", "w-fps"),
    *("p-rad_sec", "q-rad_sec", "r-rad_sec"),
)

_STEP = 1 / 120  # s
_STILL = 1e-6  # ft and ft/s, above JSBSim's rounding errors


def reset_fields(
    file: str | os.PathLike[str],
    aircraft: str,
    root: str | None,
    create: Mapping[str, float] | str | None,
    mode: str | None,
    trims: Mapping[str, int],
) -> dict[str, Any]:
    """Fields of a condition in a mode: in "none" the state itself, else the start of a trim.

    Without a mode it is the one of ``trims``, JSBSim's numbers, that the file asks for, or "none".
    """
    start = reset_file(file, aircraft, _STEP, root)
    airframe = Airframe(aircraft, _STEP, root=root, create=create, start=start)
    fdm, terrain = airframe.fdm, "terrain-elevation-ft"
    if mode is None:
        requested = int(fdm.get_ic().trim_requested())
        mode = next((name for name, trim in trims.items() if trim == requested), "none")
    airframe.run_ic()
    ic = {name: fdm[f"ic/{name}"] for name in _INITIAL}
    if abs(ic[terrain]) <= _STILL:
        del ic[terrain]
    fields: dict[str, Any] = {
        "mode": mode,
        "altitude": ic.get(terrain, 0.0) if mode == "ground" else ic["h-sl-ft"],
        "speed": fdm["ic/vc-kts"],
        "heading": math.degrees(ic["psi-true-rad"]),
    }
    wind, to = fdm["ic/vw-mag-fps"], math.radians(fdm["ic/vw-dir-deg"])
    if wind > _STILL:
        fields |= {"wind_north": wind * math.cos(to), "wind_east": wind * math.sin(to)}
    if mode in ("none", "ground"):
        # in flight a trim needs the engines
        fields["engines_off"] = [i for i, runs in airframe.marks().items() if not runs]
    if mode == "none":
        return {**fields, "setup": {f"ic/{name}": value for name, value in ic.items()}}
    fields |= {"latitude": ic["lat-geod-deg"], "longitude": ic["long-gc-deg"]}
    if mode == "turn":
        fields["bank"] = math.degrees(ic["phi-rad"])
    if mode != "ground":
        fields["gamma"] = fdm["ic/gamma-deg"]
        fields["setup"] = {f"ic/{terrain}": ic[terrain]} if terrain in ic else {}
    return fields
