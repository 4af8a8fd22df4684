"""Climbs at a rate or an airspeed, and the altitude they capture."""

from __future__ import annotations

import numpy as np
import pytest
from flights import POINTS, T, fly, start, step
from how_many import first

from pathsim_jsbsim_blocks import AltitudeHold, Autopilot, ParameterError

# rate of climb that the thrust sustains [ft/s], climb to capture [ft], largest load factor - 1 [g]
CLIMBS = {"c172p": (8.0, 200.0, 0.15), "737": (25.0, 1000.0, 0.35)}


def climbed(name, seconds, mode, more=None, **parameters):
    """A mode of the autopilot from 1 s on, with all sensors it needs."""
    ports = {"v_mode": step(mode, 1.0), **(more or {})}
    return fly(start(name), seconds, ports, unwired=(), **parameters)


@pytest.mark.parametrize(
    ("name", "sign"), first([("c172p", 1.0), ("c172p", -1.0), ("737", 1.0), ("737", -1.0)])
)
def test_a_rate_of_climb_is_held_until_the_altitude_is_captured(name, sign):
    rate, height, load = CLIMBS[name]
    rate, height, h0 = sign * rate, sign * height, POINTS[name]["altitude"]
    # the port asks for the altitude as the mode begins, not before
    more = {"hdot_ref": lambda t: rate, "h_ref": step(height, 1.0)}
    flight = climbed(name, 90.0, 1.0, more)
    capture = int(np.argmax(flight["captured"]))
    steady = slice(capture - 600, capture)
    assert flight["hdot"][steady] == pytest.approx(np.full(600, rate), abs=0.05 * abs(rate))
    assert abs(flight["h"][-1] - h0 - height) < 2.0
    assert np.max(sign * (flight["h"] - h0 - height)) < 0.05 * abs(height)
    assert np.max(np.abs(flight["nz"] - 1.0)) < load
    assert np.all(flight["captured"][capture:] == 1.0)
    assert flight["vc"][-1] == pytest.approx(flight["vc"][0], abs=1.5)


@pytest.mark.long
@pytest.mark.parametrize(
    ("throttle", "height"), [(1.0, 1.0), (-1.0, -1.0)], ids=["full throttle", "idle"]
)
@pytest.mark.parametrize("name", CLIMBS)
def test_the_airspeed_is_held_by_the_elevator_at_a_given_throttle(name, throttle, height):
    height *= 3.0 * CLIMBS[name][1]
    h0, speed = (POINTS[name][key] for key in ("altitude", "speed"))
    more = {"thr_ref": lambda t: throttle, "h_ref": step(height, 1.0)}
    flight = climbed(name, 150.0, 2.0, more, vc_ref=speed)
    capture = int(np.argmax(flight["captured"]))
    climbs = slice(120, capture)
    assert flight["throttle"][climbs] == pytest.approx(np.full(capture - 120, throttle), abs=1e-3)
    assert np.sign(height) * flight["hdot"][capture] > 5.0
    # the throttle moves at once; once the climb is steady hardly an error remains
    assert np.max(np.abs(flight["vc"][climbs] - speed)) < 9.0
    assert abs(flight["vc"][capture] - speed) < 1.5
    # the throttle's loop takes over what the aircraft has, so that its command does not jump
    # by more than what makes way for the rest of the descent
    taken = flight["throttle"] - flight["thr_sat"]
    assert abs(taken[capture + 2] - taken[capture]) < 0.1
    assert abs(flight["h"][-1] - h0 - height) < 5.0
    assert np.max(np.abs(flight["vc"][capture:] - speed)) < 11.0
    assert abs(flight["vc"][-1] - speed) < 4.0


def test_modes_change_without_a_bump():
    modes = np.repeat([0.0, 1.0, 2.0, 0.0, 2.0, 1.0, 0.0], 5)
    flight = fly(
        start("737"), 34.0, {"v_mode": lambda t: modes[int(t + T / 2)]}, unwired=(), theta_min=-5.0
    )
    for name, most in (("elevator", 1e-3), ("throttle", 2e-3)):
        assert np.max(np.abs(np.diff(flight[name]))) < most
    # each holds what it finds
    assert np.max(np.abs(flight["h"] - 10_000.0)) < 2.0
    assert np.max(np.abs(flight["vc"] - 280.0)) < 0.5
    assert not flight["captured"].any()


def test_without_an_altitude_a_climb_goes_on():
    flight = climbed("c172p", 20.0, 1.0, {"hdot_ref": lambda t: 5.0}, h_ref=None)
    assert not flight["captured"].any()
    assert flight["h"][-1] > 5060.0


def test_height_is_exchanged_for_airspeed():
    flight = climbed("737", 40.0, 2.0, vc_ref=270.0, thr_ref=0.0)
    h, vc, vt = (flight[name] for name in ("h", "vc", "vt"))
    slow = int(np.argmax(vc < 271.0))
    assert 8.0 < slow * T < 25.0  # the ramp is 1 kt/s
    # at constant energy, of which the drag of the climb takes some
    gained = (vt[0] ** 2 - vt[slow] ** 2) / 2 / 32.174
    assert 0.6 * gained < h[slow] - h[0] < gained


@pytest.mark.parametrize(
    ("make", "name"), [(AltitudeHold, "h_ref"), (Autopilot, "h_ref"), (Autopilot, "thr_ref")]
)
def test_references_beyond_any_flight_are_refused(make, name):
    with pytest.raises(ParameterError) as error:
        make(**{name: -1e9})
    assert (error.value.parameter, error.value.value) == (name, -1e9)
