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


class ResetState:
    """What a reset file says about an aircraft.

    Attributes
    ----------
    trim : int
        JSBSim's number of the trim that the file asks for
    """

    def __init__(
        self,
        file: str | os.PathLike[str],
        aircraft: str,
        root: str | None,
        create: Mapping[str, float] | str | None,
    ):
        start = reset_file(file, aircraft, _STEP, root)
        airframe = Airframe(aircraft, _STEP, root=root, create=create, start=start)
        fdm = airframe.fdm
        self.trim = int(fdm.get_ic().trim_requested())
        airframe.run_ic()
        self._initial = {name: fdm[f"ic/{name}"] for name in _INITIAL}
        wind, to = fdm["ic/vw-mag-fps"], math.radians(fdm["ic/vw-dir-deg"])
        self._wind = {}
        if wind > _STILL:
            self._wind = {"wind_north": wind * math.cos(to), "wind_east": wind * math.sin(to)}
        self._speed, self._gamma = fdm["ic/vc-kts"], fdm["ic/gamma-deg"]
        self._stopped = [i for i, runs in airframe.marks().items() if not runs]
        if abs(self._initial["terrain-elevation-ft"]) <= _STILL:
            del self._initial["terrain-elevation-ft"]

    def fields(self, mode: str) -> dict[str, Any]:
        """Fields of a condition in a mode: in "none" the state itself, else the start of a trim."""
        ic, terrain = self._initial, "terrain-elevation-ft"
        fields: dict[str, Any] = {
            "mode": mode,
            "altitude": ic.get(terrain, 0.0) if mode == "ground" else ic["h-sl-ft"],
            "speed": self._speed,
            "heading": math.degrees(ic["psi-true-rad"]),
            **self._wind,
        }
        if mode in ("none", "ground"):
            # in flight a trim needs the engines
            fields["engines_off"] = self._stopped
        if mode == "none":
            return {**fields, "setup": {f"ic/{name}": value for name, value in ic.items()}}
        fields |= {"latitude": ic["lat-geod-deg"], "longitude": ic["long-gc-deg"]}
        if mode == "turn":
            fields["bank"] = math.degrees(ic["phi-rad"])
        if mode != "ground":
            fields["gamma"] = self._gamma
            fields["setup"] = {f"ic/{terrain}": ic[terrain]} if terrain in ic else {}
        return fields
