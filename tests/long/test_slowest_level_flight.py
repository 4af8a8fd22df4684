"""The lowest level airspeed of a chart is that of the slowest flight that holds keep."""

from dataclasses import replace

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, AltitudeHold, FlightError, RollHold, fly
from pathsim_jsbsim_blocks.studies.flight_tests import Plane
from pathsim_jsbsim_blocks.studies.performance import _levels

pytest.importorskip("pandas")

AIRCRAFT = ("737", "A4", "A320", "B747", "F4N", "MD11", "T37", "T38", "fokker100", "global5000")


def is_kept(plane, speed):
    """Whether holds keep level flight at an airspeed in KCAS for 30 s, slowing down to it."""
    start, name = 1.4 * speed, plane.airframe.aircraft
    aircraft = Aircraft(name, condition=replace(plane.base, speed=start), create=plane.create)
    level, throttle = AltitudeHold(gains=name), AirspeedHold(gains=name, reference="absolute")
    wings, scope = RollHold(gains=name, phi_ref=0.0), Scope()
    reference = Source(lambda t: speed + max(start - speed - 0.5 * t, 0.0))
    # no alpha: protection would not let it slow down so far
    read = {
        level: ("h", "hdot", "theta", "q", "elev_sat", "vc"),
        throttle: ("vc", "hdot", "thr_sat"),
        wings: ("phi", "p", "ail_sat"),
    }
    wires = [Connection(aircraft[n], hold[n]) for hold, names in read.items() for n in names]
    wires += [
        Connection(reference, throttle["vc_ref"]),
        Connection(level["elevator"], aircraft["elevator"]),
        Connection(throttle["throttle"], aircraft["throttle"]),
        Connection(wings["aileron"], aircraft["aileron"]),
        Connection(aircraft["vc"], scope[0]),
        Connection(aircraft["h"], scope[1]),
    ]
    blocks = [aircraft, level, throttle, wings, reference, scope]
    sim = Simulation(blocks, wires, dt=aircraft.T, log=False)
    duration = 2.0 * (start - speed) + 50.0
    try:
        fly(sim, duration, progress=False)
    except FlightError:
        return False
    time, (vc, h) = scope.read()
    last = time > duration - 30.0
    return np.ptp(h[last]) < 20.0 and abs(vc[last] / speed - 1.0).max() < 0.015


@pytest.mark.long
@pytest.mark.parametrize("name", AIRCRAFT)
def test_the_lowest_level_airspeed_is_within_2_percent_of_what_holds_keep(name):
    task = {"aircraft": name, "root": None, "altitude": 5000.0, "weight": None, "flaps": None}
    plane = Plane(task)
    _levels(plane)
    (lowest,) = (r["speed_kcas"] for r in plane.rows if r["quantity"] == "lowest level speed")
    assert is_kept(plane, 1.02 * lowest)
    assert not is_kept(plane, 0.98 * lowest)
