"""Receivers, localizer, glide slope from far below and from above, flare and go-around.

Positions are compared with pymap3d's geodesy. The limits of landings are those of the issue: 6 ft/s
and 5 deg at the touchdown, 30 ft beside the centre line.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from flights import T
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, StepSource
from pymap3d import geodetic2aer, geodetic2ned
from test_navigation import NMI, flown

from pathsim_jsbsim_blocks import (
    Aircraft,
    AirspeedHold,
    FlareHold,
    Glideslope,
    GlideslopeHold,
    Localizer,
    LocalizerHold,
    ParameterError,
    TrimCondition,
    YawDamper,
    fly,
)
from pathsim_jsbsim_blocks.axes.earth import _ellipsoid
from pathsim_jsbsim_blocks.catalogue import load_diagram

STATION = (47.0, 11.0)


def seen(receiver, *u, samples=1):
    """Outputs of a receiver at one place, a row for each sample."""
    state, rows = receiver.initial_state(), []
    for _ in range(samples):
        y, state = receiver.law(list(u), state)
        rows.append(y)
    return np.array(rows)


@pytest.mark.parametrize("course", [0.0, 140.0, 265.0])
@pytest.mark.parametrize("place", [(46.93, 10.9), (47.05, 11.02), (46.99, 11.1)])
def test_a_localizer_measures_from_its_course_line(course, place):
    north, east, _ = geodetic2ned(*place, 0.0, *STATION, 0.0, _ellipsoid())
    chi = math.radians(course)
    right = east * math.cos(chi) - north * math.sin(chi)
    before = -north * math.cos(chi) - east * math.sin(chi)
    degrees, ft, dist = seen(Localizer(station=STATION, course=course), *place)[0]
    # the Earth's curvature within 8 nmi
    assert ft == pytest.approx(right, abs=2.0)
    assert dist == pytest.approx(before, abs=2.0)
    assert degrees == pytest.approx(math.degrees(math.atan2(right, abs(before))), abs=0.01)


@pytest.mark.parametrize("height", [300.0, 1500.0, 4000.0])
def test_a_glide_slope_is_a_straight_line_to_its_station(height):
    lat, lon = STATION[0] - 4.0 * NMI, STATION[1]
    receiver = Glideslope(station=STATION, elevation=500.0, angle=3.2)
    degrees, ft, dist = seen(receiver, lat, lon, 500.0 + height)[0]
    _, elevation, slant = geodetic2aer(lat, lon, 500.0 + height, *STATION, 500.0, _ellipsoid())
    assert degrees == pytest.approx(elevation - 3.2, abs=0.005)
    level = slant * math.cos(math.radians(elevation))
    assert dist == pytest.approx(level, rel=1e-3)
    rise = math.tan(math.radians(elevation)) - math.tan(math.radians(3.2))
    assert ft == pytest.approx(level * rise, abs=1.0)


def test_a_beam_has_a_width_and_repeatable_noise():
    place = (STATION[0] - 0.1, STATION[1] + 0.02)
    wide, narrow = (Localizer(station=STATION, width=w) for w in (math.inf, 2.5))
    (degrees, ft, dist), (edge, near, _) = seen(wide, *place)[0], seen(narrow, *place)[0]
    assert degrees > 7.0
    assert ft == pytest.approx(dist * math.tan(math.radians(degrees)), rel=1e-6)
    assert edge == pytest.approx(2.5)
    assert near == pytest.approx(dist * math.tan(math.radians(2.5)), rel=1e-3)

    noisy = [
        seen(Localizer(station=STATION, noise=0.1, seed=seed), *place, samples=12_000)[:, 0]
        for seed in (1, 1, 2)
    ]
    assert np.array_equal(noisy[0], noisy[1])
    assert not np.array_equal(noisy[0], noisy[2])
    error = noisy[0] - degrees
    # 100 s of noise with a correlation time of 0.5 s
    assert np.std(error) == pytest.approx(0.1, rel=0.2)
    assert np.corrcoef(error[:-60], error[60:])[0, 1] == pytest.approx(math.exp(-1.0), abs=0.15)


@pytest.mark.parametrize(
    ("name", "start", "below", "seconds"),
    [
        # V tan(3 deg) is 8 ft/s and 27 ft/s, hdot_max 1.6 ft/s and 25 ft/s
        ("pa28", {"altitude": 2000.0, "speed": 95.0, "solver": "newton"}, 1156.0, 260.0),
        ("737", {"altitude": 6000.0, "speed": 280.0, "gear": 0.0}, 2430.0, 200.0),
    ],
)
def test_the_altitude_is_held_until_the_glide_path_is_met(name, start, below, seconds):
    altitude = start["altitude"]
    away = (altitude + below) / math.tan(math.radians(3.0))
    threshold = (away / 362_760.0, 0.0)
    plane = Aircraft(name, condition=TrimCondition(**start))
    flight = flown(plane, seconds, GlideslopeHold(name, threshold=threshold, crossing_height=0.0))
    assert flight["gs_ft"][0] == pytest.approx(-below, abs=40.0)
    capture = np.flatnonzero(flight["captured"])[0]
    assert np.max(np.abs(flight["h"][:capture] - altitude)) < 20.0
    assert -300.0 < flight["gs_ft"][capture] < 0.0
    assert np.max(flight["h"]) < altitude + 20.0
    assert np.max(np.abs(flight["gs_ft"][-600:])) < 25.0
    assert flight["h"][-1] < altitude - 300.0


def test_on_request_the_glide_path_is_captured_from_above():
    away = 1500.0 / math.tan(math.radians(3.0))
    threshold = ((away - 6000.0) / 362_760.0, 0.0)
    hold = GlideslopeHold("c172p", threshold=threshold, crossing_height=0.0, from_above=True)
    flight = flown(Aircraft("c172p", altitude=1500.0, speed=80.0), 90.0, hold)
    assert flight["gs_ft"][0] > 290.0
    assert flight["captured"][-1] == 1.0
    assert np.max(np.abs(flight["gs_ft"][-600:])) < 25.0
    assert flight["gs_ft"].min() > -25.0


def test_the_glide_slope_hold_follows_a_receiver():
    away = 1500.0 / math.tan(math.radians(3.0)) + 3000.0
    station = (away / 362_760.0, 0.0)
    plane = Aircraft("c172p", altitude=1500.0, speed=80.0)
    receiver, hold = Glideslope(station=station), GlideslopeHold("c172p")
    airspeed, scope = AirspeedHold("c172p"), Scope()
    own = ("h", "hdot", "theta", "q")
    wires = [
        Connection(plane["lat", "lon", "h"], receiver["lat", "lon", "h"]),
        Connection(receiver["deg", "ft", "dist"], hold["gs_deg", "gs_ft", "gs_dist"]),
        Connection(plane[own], hold[own]),
        Connection(hold["elevator"], plane["elevator"]),
        Connection(plane["vc", "hdot"], airspeed["vc", "hdot"]),
        Connection(airspeed["throttle"], plane["throttle"]),
        Connection(hold["gs_ft"], scope[0]),
        Connection(plane["h"], scope[1]),
    ]
    # no warning of lat and lon, which the receiver replaces: it would be an error here
    fly(Simulation([plane, receiver, hold, airspeed, scope], wires, dt=T, log=False), 90.0)
    _, (above, h) = scope.read()
    assert h[-1] < 1100.0
    assert np.max(np.abs(above[-600:])) < 5.0
