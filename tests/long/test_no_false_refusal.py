"""A trim that is refused cannot be flown: holds do not keep it at part throttle.

Level flight and turns at airspeeds from near the stall to beyond the fastest.
"""

import math
import random
from dataclasses import replace

import numpy as np
import pytest
from held_flight import held
from how_many import bounded

from pathsim_jsbsim_blocks import TrimError
from pathsim_jsbsim_blocks.flight import trim
from pathsim_jsbsim_blocks.studies.flight_tests import Plane, last

pytest.importorskip("pandas")

# model: altitude in ft; trims of the first three at these were refused that could be flown
FLIGHTS = {
    **{"c182": 700, "T37": 300, "c310": 5000, "737": 15000, "c172p": 5000, "A4": 10000},
    **{"T38": 5000, "J3Cub": 1000, "F4N": 10000, "B747": 10000, "OV10": 5000, "L17": 2000},
    **{"A320": 10000, "F80C": 10000, "MD11": 10000, "c172r": 3000, "fokker100": 10000},
    **{"global5000": 15000, "t6texan2": 5000, "f15": 15000},
}
BANKS = 0.0, 30.0, 45.0

SPEEDS = 10  # for each bank, from 1.05 of the slowest to 1.1 of the fastest
FLOWN = bounded(2, 3 * SPEEDS)  # refused points of each model that are tried by flying
RATE = 1.0  # kt/s, at which the holds get there
SETTLING, KEPT = 60.0, 30.0  # s


def is_kept(plane, start, speed, bank):
    """Whether holds keep an airspeed in KCAS and a bank in deg, from a trim in level flight."""
    arrival = abs(speed - start.speed) / RATE
    change = np.sign(speed - start.speed)
    duration = arrival + SETTLING + KEPT
    flight = held(
        start,
        plane,
        duration,
        vc_ref=lambda t: start.speed + change * RATE * min(t, arrival),
        phi_ref=lambda t: min(max(t - arrival, 0.0) * 3.0, bank),
    )
    if flight is None:
        return False
    time, (vc, h, phi, saturated) = flight
    then = time > duration - KEPT
    return (
        abs(vc[then] - speed).max() < 1.0
        and np.ptp(h[then]) < 20.0
        and abs(phi[then] - bank).max() < 1.0
        and not saturated[then].any()
    )


def trims(plane, speed, bank=0.0):
    """The condition of level flight or a turn, and whether it trims."""
    turn = {"mode": "turn", "bank": bank} if bank else {}
    condition = replace(plane.base, speed=speed, **turn)
    try:
        trim(plane.airframe, condition, hint=False)
    except TrimError:
        return condition, False
    return condition, True


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:the trim of .* does not hold:RuntimeWarning")
@pytest.mark.parametrize("name", [*FLIGHTS][: bounded(8, len(FLIGHTS))])
def test_what_is_refused_is_not_flown_by_holds(name):
    task = {
        "aircraft": name,
        "root": None,
        "create": None,
        "altitude": FLIGHTS[name],
        "weight": None,
        "flaps": None,
    }
    plane = Plane(task)
    plane._deadline = math.inf
    slowest = plane.slowest().speed
    start = plane.first(plane.level)
    fastest = last(plane.level, start, 1.07).speed
    speeds = np.geomspace(1.05 * slowest, 1.1 * fastest, SPEEDS).tolist()
    found = {(bank, speed): trims(plane, speed, bank) for bank in BANKS for speed in speeds}
    level = [condition for (bank, _), (condition, ok) in found.items() if ok and not bank]
    # the holds do keep what trims
    middle = len(level) // 2
    assert is_kept(plane, level[middle - 1], level[middle].speed, 0.0)
    refused = [key for key, (_, ok) in found.items() if not ok]
    assert refused
    tried = random.Random(48).sample(refused, min(FLOWN, len(refused)))
    flown = [
        (bank, speed)
        for bank, speed in tried
        if is_kept(plane, min(level, key=lambda c: abs(c.speed - speed)), speed, bank)
    ]
    assert flown == []
