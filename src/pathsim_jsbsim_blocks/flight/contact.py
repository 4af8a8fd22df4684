"""Contact of an aircraft with the ground: which part touches, and how fast the aircraft sinks."""

from __future__ import annotations

import math

from .._core.aircraft_ports import property_of
from .airframe import Airframe

# friction coefficients that tell wheels from other "bogey" contacts: skids, wing tips and floats
# have a sliding friction of 0.2, or a rolling friction above half the sliding friction
_TYRE_SLIDES, _TYRE_ROLLS = 0.3, 0.5

# ft; the centre of gravity moves as fuel burns
_MARGIN = 10.0

# ft/s, of any descent
_FASTEST = 1000.0

_SINK = property_of("hdot")


# rate of climb in ft/s, whether each part touches, and whether it has touched from the start
Near = tuple[float, list[float], list[bool]]


class GroundContact:
    """Ground contact of a trimmed aircraft; parts that touch initially are exempt.

    ``period`` is the time between two looks, s; ``sink_max`` the maximum sink rate at contact,
    ft/s; ``scrape_max`` the maximum depth to which a part that is not a wheel may press into the
    ground, ft; ``reach`` the height of the centre of gravity above the ground, ft, above which no
    part can touch within a period, -inf if not monitored.
    """

    def __init__(self, airframe: Airframe, period: float, sink_max: float, scrape_max: float):
        read = airframe.fdm.get_property_value
        count = range(int(read("gear/num-units")))
        units = [f"{kind}/unit[{i}]" for i in count for kind in ("gear", "contact")]
        units = [unit for unit in units if airframe.has(f"{unit}/WOW")]
        wheels = [unit for unit in units if _is_wheel(airframe, unit)]
        structure = [unit for unit in units if unit not in wheels]
        self.reach = -math.inf
        if not wheels or sink_max == scrape_max == math.inf:
            return
        farthest = max(_distance(airframe, unit) for unit in units)
        self.reach = _MARGIN + _FASTEST * period + farthest
        self._sink_max, self._scrape_max = sink_max, scrape_max
        self._on = [f"{unit}/WOW" for unit in wheels + structure]
        self._depth = [f"{unit}/compression-ft" for unit in structure]
        self._wheels = len(wheels)
        self._read = airframe.reader_of([_SINK, *self._on, *self._depth])

    def look(self, before: Near | None) -> Near:
        """What touches, ``before`` of one period earlier; None if that was out of reach."""
        hdot, *values = self._read()
        touches = values[: len(self._on)]
        exempt = before[2] if before else [True] * len(touches)
        return hdot, touches, [bool(a and b) for a, b in zip(exempt, touches, strict=True)]

    def broken(self, before: Near) -> tuple[str, str, float] | None:
        """Text of the violation in a period, its property and the value; None if there is none."""
        hdot, *values = self._read()
        n = len(self._on)
        touches, depths = values[:n], values[n:]
        sink, was, exempt = before
        if touches == was and not any(depths):
            return None
        if any(on and not touched_then for on, touched_then in zip(touches, was, strict=True)):
            # the sink rate before the contact: the ground has reduced it since
            fastest = min(sink, hdot)
            if -fastest > self._sink_max:
                what = f"touched the ground faster than {self._sink_max:g} ft/s, rate of climb"
                return what, _SINK, fastest
        for name, depth, depth_0 in zip(self._depth, depths, exempt[self._wheels :], strict=True):
            if depth > self._scrape_max and not depth_0:
                return f"touched the ground with a part that is not a wheel, {name}", name, depth
        return None


def _is_wheel(airframe: Airframe, unit: str) -> bool:
    if not unit.startswith("gear/"):
        return False
    slides = airframe.fdm[f"{unit}/static_friction_coeff"]
    rolls = airframe.fdm[f"{unit}/rolling_friction_coeff"]
    return slides > _TYRE_SLIDES and rolls < _TYRE_ROLLS * slides


def _distance(airframe: Airframe, unit: str) -> float:
    """Distance of a contact point from the centre of gravity, ft."""
    point = [airframe.fdm[f"{unit}/{axis}-position"] for axis in "xyz"]
    return math.dist(point, [airframe.fdm[f"inertia/cg-{axis}-in"] for axis in "xyz"]) / 12.0
