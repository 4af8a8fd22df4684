"""The planet that an aircraft flies over: its shape, rotation and gravity."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .._core.checks import must_be, number, one_of, positive, refuse

# names and units of JSBSim's <planet>; NIMA TR8350.2, third edition, in ft. These are the planet
# that JSBSim has for models without one
_WGS84 = {
    "semimajor_axis": 20925646.32546,
    "semiminor_axis": 20855486.5951,
    "rotation_rate": 7.292115e-5,
    "GM": 14.0764417572e15,
    "J2": 1.08262982e-3,
}
_UNITS = {
    "semimajor_axis": "FT",
    "semiminor_axis": "FT",
    "rotation_rate": "RAD/SEC",
    "GM": "FT3/SEC2",
    "J2": "",
}

# ft: the radius of NASA's check cases, 6371007.1809 m, of a sphere with the area of WGS-84
_ROUND = {"semimajor_axis": 20902254.5305, "semiminor_axis": 20902254.5305, "J2": 0.0}

PLANETS: Mapping[str, Mapping[str, float]] = {
    "WGS-84": _WGS84,
    "round": {**_WGS84, **_ROUND},
    "round, fixed": {**_WGS84, **_ROUND, "rotation_rate": 0.0},
}

# JSBSim's numbers for simulation/gravity-model
GRAVITY: Mapping[str, int] = {"point mass": 0, "J2": 1}


def planet_xml(planet: Any) -> str:
    """JSBSim's XML of a planet: a name of `PLANETS`, or a dict of differences from WGS-84."""
    if isinstance(planet, str):
        differences: Mapping[Any, Any] = PLANETS[one_of("planet", planet, PLANETS)]
    elif isinstance(planet, Mapping):
        differences = planet
    else:
        names = ", ".join(map(repr, PLANETS))
        must_be("planet", planet, f"one of {names} or a dict of differences from WGS-84")
    values = dict(_WGS84)
    for name, value in differences.items():
        one_of("planet key", name, _WGS84)
        values[name] = (number if name in ("rotation_rate", "J2") else positive)(
            f"planet[{name!r}]", value
        )
    if values["semiminor_axis"] > values["semimajor_axis"]:
        why = "the semiminor axis of a planet must not exceed its semimajor axis, "
        why += f"{values['semimajor_axis']:.10g} ft, not {values['semiminor_axis']:.10g} ft"
        refuse("planet", planet, why)
    elements = (
        f"<{name}" + (f' unit="{_UNITS[name]}"' if _UNITS[name] else "") + f">{value!r}</{name}>"
        for name, value in values.items()
    )
    return f'<planet name="planet">{"".join(elements)}</planet>'


def gravity_properties(gravity: Any) -> dict[str, int]:
    """JSBSim's property for a gravity model, with its value."""
    return {"simulation/gravity-model": GRAVITY[one_of("gravity", gravity, GRAVITY)]}
