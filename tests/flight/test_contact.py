"""Contact with the ground: a landing goes on, a crash ends the flight.

The sink rate and the instant of the first contact are those of a plain JSBSim loop; the limit of
15 ft/s and the parts that may touch come from the issue, not from the code.
"""

import math

import pytest
from pathsim import Simulation

from pathsim_jsbsim_blocks import Aircraft, FlightError

T = 1 / 120
UNLIMITED = {"sink_max": math.inf, "scrape_max": math.inf}


def descending(gamma, **more):
    """A c172p on its approach, 30 ft above the ground."""
    condition = {"altitude": 30.0, "speed": 70.0, "gamma": gamma, "mode": "none"}
    return Aircraft("c172p", **condition, **more)


def flying(plane):
    return Simulation([plane], dt=plane.T, log=False)


def plain_contact(gamma):
    """Time and rate of climb in the last step before a wheel touches, in a plain loop."""
    fdm = descending(gamma, **UNLIMITED).fdm
    for step in range(1, 2000):
        before = fdm["velocities/h-dot-fps"]
        fdm.run()
        if any(fdm[f"gear/unit[{i}]/WOW"] for i in range(3)):
            return step * T, before
    raise AssertionError("it does not come down")


def test_sinking_too_fast_at_contact_ends_the_flight():
    time, hdot = plain_contact(-9.0)
    assert hdot < -15.0
    plane = descending(-9.0)
    with pytest.raises(FlightError) as error:
        flying(plane).run(20.0)
    assert error.value.name == "velocities/h-dot-fps"
    assert error.value.time == pytest.approx(time)
    assert error.value.value == pytest.approx(hdot, abs=0.5)


def test_the_limit_is_a_parameter():
    time, hdot = plain_contact(-5.0)
    assert -15.0 < hdot < -5.0
    flying(descending(-5.0)).run(time + 1.0)
    flying(descending(-5.0, sink_max=-hdot + 0.5)).run(time + 1.0)
    with pytest.raises(FlightError) as error:
        flying(descending(-5.0, sink_max=-hdot - 0.5)).run(time + 1.0)
    assert error.value.name == "velocities/h-dot-fps"


def test_a_touch_with_anything_but_wheels_ends_the_flight():
    # 10.3 g at the touch, less than the 50 g that end any flight
    start = {"altitude": 40.0, "speed": 250.0, "gamma": -1.0, "gear": 0.0, "mode": "none"}
    plane = Aircraft("f16", **start, sink_max=math.inf)
    with pytest.raises(FlightError) as error:
        flying(plane).run(10.0)
    assert error.value.name.startswith("contact/unit[")
    assert 0.0 < error.value.value < 1.0
    assert plane.fdm["gear/unit[0]/WOW"] == 0.0

    plane = Aircraft("f16", **start, **UNLIMITED)
    flying(plane).run(error.value.time + 1.0)
    assert plane.fdm["position/h-agl-ft"] < 10.0


def test_a_model_may_describe_its_wing_tips_as_wheels_are_described():
    # the A320's tail and engine pods are "bogeys" that slide with a coefficient of 0.2
    start = {"altitude": 60.0, "speed": 200.0, "gamma": -1.0, "gear": 0.0, "mode": "none"}
    plane = Aircraft("A320", **start, sink_max=math.inf)
    with pytest.raises(FlightError) as error:
        flying(plane).run(20.0)
    assert error.value.name == "gear/unit[4]/compression-ft"


@pytest.mark.parametrize("aircraft", ["c172p", "737", "J3Cub", "c310"])
def test_an_aircraft_stands_on_the_ground(aircraft):
    plane = Aircraft(aircraft, altitude=0.0, speed=0.0, mode="ground")
    flying(plane).run(2.0)
    assert plane.fdm["gear/wow"] == 1.0


def test_a_model_without_wheels_touches_as_it_likes():
    boat = Aircraft("Short_S23", altitude=30.0, speed=120.0, gamma=-20.0, mode="none")
    sim = flying(boat)
    while not any(boat.fdm[f"contact/unit[{i}]/WOW"] for i in range(4)):
        sim.run(T, reset=False)
    assert boat.fdm["velocities/h-dot-fps"] < -15.0
    sim.run(0.1, reset=False)


def test_the_height_above_the_ground_is_an_output():
    plane = Aircraft(
        "c172p",
        altitude=2000.0,
        speed=90.0,
        setup={"ic/terrain-elevation-ft": 500.0},
        output_properties=["h_agl"],
    )
    assert plane.outputs["h_agl"] == pytest.approx(1500.0, abs=0.01)
