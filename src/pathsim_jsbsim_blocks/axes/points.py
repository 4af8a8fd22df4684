"""Named points of an aircraft model, in structural axes."""

from __future__ import annotations

import contextlib

from ..errors import AircraftError
from ..flight.airframe import Airframe
from ..flight.model_files import empty_weight_cg

Point = tuple[float, float, float]

# {} is the axis, * the index
_PROPERTIES = {
    "centre of gravity": "inertia/cg-{}-in",
    "aerodynamic reference point": "metrics/aero-rp-{}-in",
    "eye point": "metrics/eyepoint-{}-in",
    "visual reference point": "metrics/visualrefpoint-{}-in",
    "wheels": "gear/unit*/{}-position",
    "other contact points": "contact/unit*/{}-position",
    "tanks": "propulsion/tank*/{}-position",
    "point masses": "inertia/pointmass-location-{}-inches*",
}


def aircraft_points(airframe: Airframe) -> dict[str, list[Point]]:
    """Points that a model defines: CG, aerodynamic reference point, wheels, tanks, point masses.

    The airframe must be initialised (`Airframe.run_ic`). Returns lists of (x, y, z) by the kind of
    point, in inches, structural axes: x aft, y right, z up; wheels are those of the unloaded gear.
    """
    points: dict[str, list[Point]] = {}
    with contextlib.suppress(AircraftError):
        points["empty-weight CG"] = [empty_weight_cg(airframe.aircraft, airframe.root)]
    for kind, template in _PROPERTIES.items():
        axes = "XYZ" if "inches" in template else "xyz"
        before, _, after = template.format(axes[0]).partition("*")
        indices = [""]
        if "*" in template:
            names = [n for n in airframe.property_names(before) if n.startswith(before)]
            indices = sorted(
                n[len(before) : -len(after) or None] for n in names if n.endswith(after)
            )
        for index in indices:
            axis_names = (template.format(axis).replace("*", index) for axis in axes)
            x, y, z = (airframe.reader(name)() for name in axis_names)
            points.setdefault(kind, []).append((x, y, z))
    return points
