"""The lowest level airspeed of a chart is that of the slowest flight that holds keep."""

from dataclasses import replace

import numpy as np
import pytest
from held_flight import held

from pathsim_jsbsim_blocks.studies.flight_tests import Plane
from pathsim_jsbsim_blocks.studies.performance import _levels

pytest.importorskip("pandas")

AIRCRAFT = ("737", "A4", "A320", "B747", "F4N", "MD11", "T37", "T38", "fokker100", "global5000")


def is_kept(plane, speed):
    """Whether holds keep level flight at an airspeed in KCAS for 30 s, slowing down to it."""
    start = 1.4 * speed
    duration = 2.0 * (start - speed) + 50.0
    flight = held(
        replace(plane.base, speed=start),
        plane,
        duration,
        vc_ref=lambda t: speed + max(start - speed - 0.5 * t, 0.0),
    )
    if flight is None:
        return False
    time, (vc, h, *_) = flight
    last = time > duration - 30.0
    return np.ptp(h[last]) < 20.0 and abs(vc[last] / speed - 1.0).max() < 0.015


@pytest.mark.long
@pytest.mark.parametrize("name", AIRCRAFT)
def test_the_lowest_level_airspeed_is_within_2_percent_of_what_holds_keep(name):
    task = {"aircraft": name, "root": None, "create": None, "altitude": 5000.0}
    task |= {"weight": None, "flaps": None}
    plane = Plane(task)
    _levels(plane)
    (lowest,) = (r["speed_kcas"] for r in plane.rows if r["quantity"] == "lowest level speed")
    assert is_kept(plane, 1.02 * lowest)
    assert not is_kept(plane, 0.98 * lowest)
