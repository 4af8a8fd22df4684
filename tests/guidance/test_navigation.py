"""Course, waypoints and glide slope, flown in wind, against pymap3d's geodesy.

The limits are about twice what is measured (docs/navigation.md).
"""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from flights import POINTS, WGS84, Record, T, samples, wrap
from how_many import first
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, Source
from pymap3d import geodetic2aer, geodetic2ned
from pymap3d.vincenty import vdist, vreckon

from pathsim_jsbsim_blocks import (
    Aircraft,
    AirspeedHold,
    AltitudeHold,
    BlocksError,
    CourseHold,
    Glideslope,
    GlideslopeHold,
    Localizer,
    LocalizerHold,
    ParameterError,
    fly,
)

NMI = 1.0 / 60.0  # deg of latitude, nearly
APPROACH = {
    "c172p": {"altitude": 1500.0, "speed": 80.0},
    "737": {"altitude": 1500.0, "speed": 160.0, "gear": 1.0, "flaps": 0.5},
}


def flown(plane, seconds, *holds, wind=(0.0, 0.0), ports=None):
    """Fly with some holds and an autothrottle; the signals of aircraft and holds by port name."""
    holds = [*holds, AirspeedHold(gains=plane.aircraft)]
    air = [Constant(speed) for speed in wind]
    scopes = {block: Scope() for block in (plane, *holds)}
    blocks = [*scopes, *scopes.values(), *air]
    wires = [
        Connection(source, plane[port])
        for source, port in zip(air, ("wind_north", "wind_east"), strict=True)
    ]
    for block, scope in scopes.items():
        n = len(block.output_port_labels)
        wires.append(Connection(block[:n], scope[:n]))
    for hold in holds:
        for port in hold.input_port_labels:
            if port in plane.output_port_labels and port not in (ports or {}):
                wires.append(Connection(plane[port], hold[port]))
            elif ports and port in ports and isinstance(hold, (CourseHold, GlideslopeHold)):
                blocks.append(Source(ports[port]))
                wires.append(Connection(blocks[-1], hold[port]))
        command = next(p for p in hold.output_port_labels if p in plane.input_port_labels)
        wires.append(Connection(hold[command], plane[command]))
    fly(Simulation(blocks, wires, dt=T, log=False), seconds)
    record = Record()
    for block, scope in reversed(scopes.items()):
        t, y = scope.read()
        record.update(zip(block.output_port_labels, y, strict=True))
    record["t"] = t
    return record


def level(seconds, hold, lat=0.0, lon=0.0, heading=0.0, **options):
    """A c172p at 90 KCAS and 5000 ft, with a hold of its course."""
    place = {"ic/lat-geod-deg": lat, "ic/long-gc-deg": lon}
    plane = Aircraft("c172p", **{**POINTS["c172p"], "heading": heading}, setup=place)
    return flown(plane, seconds, hold, AltitudeHold("c172p"), **options)


def ground_course(flight):
    """Course and speed over the ground from the positions, deg and ft/s."""
    lat, lon = flight["lat"], flight["lon"]
    north, east, _ = geodetic2ned(lat[1:], lon[1:], 0.0, lat[:-1], lon[:-1], 0.0, WGS84)
    return np.degrees(np.arctan2(east, north)) % 360.0, np.hypot(north, east) / T


def beside(flight, start, end):
    """Cross-track error in ft by the geodesic from the start, for a leg of a few miles."""
    _, course = vdist(*start, *end, WGS84)
    out, bearing = vdist(*start, flight["lat"], flight["lon"], WGS84)
    return out * np.sin(np.radians(bearing - course))


@pytest.mark.parametrize(
    ("name", "wind", "drift"),
    first([("c172p", (-10.0, 30.0), 10.0), ("737", (20.0, 60.0), 5.0)]),
)
def test_the_course_over_the_ground_is_held_in_wind(name, wind, drift):
    plane = Aircraft(name, **{**POINTS[name], "heading": 0.0})
    ports = {"chi_ref": lambda t: 20.0 * (t > 40.0)}
    flight = flown(
        plane, 80.0, CourseHold(name, chi_ref=350.0), AltitudeHold(name), wind=wind, ports=ports
    )
    course, _ = ground_course(flight)
    # the drift angle is smoothed over 2 s, so that in steady flight it is that of the positions
    for end, reference in ((40.0, 350.0), (80.0, 10.0)):
        late = (flight["t"][1:] > end - 4.0) & (flight["t"][1:] < end)
        assert np.max(np.abs(wrap(course[late] - reference))) < 0.5
        assert np.max(np.abs(wrap(flight["chi"][1:][late] - course[late]))) < 0.1
    assert abs(wrap(flight["psi"][-1] - 10.0)) > drift
    assert flight["chi_cmd"][-1] == pytest.approx(10.0)
    for nothing in ("across", "to_go", "leg"):
        assert not flight[nothing].any()


def test_by_default_the_course_found_is_held():
    # trimmed in a crosswind: the course is not the heading
    flight = level(20.0, CourseHold("c172p"), heading=30.0, wind=(0.0, 30.0))
    course, _ = ground_course(flight)
    found = flight["chi_cmd"][1]
    assert found == pytest.approx(course[0], abs=1e-3)
    assert flight["chi"][0] == flight["psi"][0]
    assert wrap(course[-1] - found) == pytest.approx(0.0, abs=0.3)


# 25 deg of bank are a circle of 1900 and 20,000 ft
ROUTES = {
    "c172p": (0.6, 140.0, (-10.0, 15.0), 250.0, 40.0),
    "737": (8.0, 400.0, (30.0, -40.0), 400.0, 110.0),
}


@pytest.mark.long
@pytest.mark.parametrize("name", ROUTES)
def test_waypoints_in_wind(name):
    size, seconds, wind, overshoot, time = ROUTES[name]
    lat, lon = 47.0, 11.0
    east = size * NMI / math.cos(math.radians(lat))
    route = [
        (lat + size * NMI, lon),
        (lat + size * NMI, lon + 2 * east),
        (lat - 2 * size * NMI, lon + 4 * east),
    ]
    plane = Aircraft(
        name,
        **{**POINTS[name], "heading": 0.0},
        setup={"ic/lat-geod-deg": lat, "ic/long-gc-deg": lon},
    )
    flight = flown(plane, seconds, CourseHold(name, waypoints=route), AltitudeHold(name), wind=wind)
    assert list(np.unique(flight["leg"])) == [0.0, 1.0, 2.0]
    assert np.all(np.diff(flight["leg"]) >= 0.0)
    starts = [(lat, lon), *route]
    for leg in range(3):
        here = Record({key: y[flight["leg"] == leg] for key, y in flight.items()})
        # the block's cross-track error and distance to go are those of the geodesics
        across = beside(here, starts[leg], starts[leg + 1])
        assert np.max(np.abs(across - here["across"])) < 3.0
        away, _ = vdist(here["lat"][-1], here["lon"][-1], *starts[leg + 1], WGS84)
        assert math.hypot(here["to_go"][-1], here["across"][-1]) == pytest.approx(away, rel=1e-4)
        if not leg:
            continue
        # from the inside of the turn onto the leg
        assert abs(here["across"][0]) > 100.0
        side = np.sign(here["across"][0])
        assert np.min(side * here["across"]) > -overshoot
        settled = here["t"] > here["t"][0] + time
        assert np.max(np.abs(here["across"][settled])) < 60.0
        assert np.max(np.abs(here["phi"])) < 26.0


@pytest.mark.long
def test_a_leg_is_captured_from_the_side_at_the_intercept_angle():
    # 6000 ft left of a line to the east
    hold = CourseHold("c172p", waypoints=[(47.0, 11.0), (47.0, 11.5)], leg=1, intercept=30.0)
    flight = level(110.0, hold, lat=47.0 + 6000.0 / 364_800.0, lon=11.0, heading=90.0)
    course, _ = ground_course(flight)
    assert flight["across"][0] == pytest.approx(-6000.0, rel=0.01)
    assert np.max(course) == pytest.approx(120.0, abs=1.0)
    assert np.max(flight["across"]) < 30.0
    assert np.max(np.abs(flight["across"][-1200:])) < 60.0
    assert set(flight["leg"]) == {1.0}


def test_a_single_waypoint_is_flown_to_and_beyond():
    there = (0.8 * NMI, 0.8 * NMI)
    flight = level(58.0, CourseHold("c172p", waypoints=[there]))
    nearest, _ = vdist(flight["lat"], flight["lon"], *there, WGS84)
    assert np.min(nearest) < 60.0
    passed = np.argmin(nearest)
    assert flight["to_go"][passed] == pytest.approx(0.0, abs=30.0)
    assert flight["to_go"][-1] < -1000.0
    assert set(flight["leg"]) == {0.0}


def test_off_keeps_the_leg_and_engagement_does_not_jump():
    route = [(0.6 * NMI, 0.0), (0.6 * NMI, NMI), (2 * NMI, 2 * NMI)]

    def off(t):
        return float(t < 2.0 - T / 2 or 20.0 - T / 2 < t < 30.0 - T / 2)

    flight = level(40.0, CourseHold("c172p", waypoints=route), ports={"off": off})
    t, u, leg = flight["t"], flight["aileron"], flight["leg"]
    idle = np.array([off(x) > 0.0 for x in t])
    for k in np.flatnonzero(np.diff(idle.astype(int)) == -1):  # last sample off
        assert abs(u[k + 1] - u[k]) < 1e-12
        assert leg[k + 1] >= leg[k]
    assert np.all(np.diff(u[(t > 20.0) & idle]) == 0.0)
    assert np.ptp(leg[idle & (t > 20.0)]) == 0.0
    # leg 0 begins where it is engaged
    engaged = np.flatnonzero(~idle)[0]
    assert flight["across"][engaged] == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("name", "wind"), first([("737", (-25.0, 15.0)), ("737", (0.0, 0.0)), ("c172p", (-25.0, 15.0))])
)
def test_glide_slope_from_capture_to_200_ft(name, wind):
    threshold, elevation, angle = (4.6 * NMI + 47.0, 11.0), 300.0, 3.0
    plane = Aircraft(
        name, **APPROACH[name], setup={"ic/lat-geod-deg": 47.0, "ic/long-gc-deg": 11.0}
    )
    flight = flown(
        plane,
        {"c172p": 225.0, "737": 115.0}[name],
        GlideslopeHold(name, threshold=threshold, elevation=elevation, angle=angle),
        CourseHold(name, waypoints=[threshold]),
        wind=wind,
    )
    capture = np.flatnonzero(flight["captured"])[0]
    assert np.all(flight["captured"][capture:] == 1.0)
    assert np.max(np.abs(flight["h"][:capture] - 1500.0)) < 40.0
    assert flight["gs_ft"][capture] < 0.0  # from below
    end = np.flatnonzero(flight["h"] < elevation + 200.0)
    end = end[0] if len(end) else len(flight["t"]) - 1
    assert flight["h"][end] < elevation + 500.0
    # 20 s after the capture, seen from the path's foot: the line of sight of pymap3d
    path = slice(capture + 2400, end)
    foot = 50.0 / math.tan(math.radians(angle))
    north = threshold[0] + foot / 364_800.0  # ft per deg of latitude at 47 deg
    _, elevation_angle, _ = geodetic2aer(
        *(flight[key][path] for key in ("lat", "lon", "h")), north, 11.0, elevation, WGS84
    )
    assert np.max(np.abs(elevation_angle - angle)) < 0.05
    assert np.max(np.abs(elevation_angle - angle - flight["gs_deg"][path])) < 0.01
    assert np.max(np.abs(flight["gs_ft"][path])) < 25.0
    assert np.max(np.abs(np.diff(flight["theta_cmd"]))) < 4.001 * T  # the ramp of the pitch loop


def test_beyond_the_threshold_the_distance_is_negative():
    hold = GlideslopeHold("c172p", threshold=(0.0, 0.0), crossing_height=0.0)
    rows = []
    for k in range(400):  # along the path at 100 ft per sample, through the threshold
        north = -20_000.0 + 100.0 * k
        h = max(-north * math.tan(math.radians(3.0)) + north**2 / (2 * 20.9e6), 0.0)
        rows.append({"h": h, "hdot": -5.0, "lat": north / 362_700.0})
    found = list(samples(hold, rows))
    assert found[100]["dist"] == pytest.approx(10_000.0, rel=1e-3)
    assert found[100]["gs_ft"] == pytest.approx(0.0, abs=2.0)
    assert found[-1]["captured"] == 1.0
    assert found[-1]["dist"] == pytest.approx(-19_900.0, rel=1e-3)


@pytest.mark.parametrize(("sign", "above", "captured"), [(1, 0, 1), (1, 700, 0), (-1, 0, 0)])
def test_a_glide_slope_is_captured_on_the_path_and_let_go_of_when_off(sign, above, captured):
    # towards the threshold or away from it, on the path or above; then level flight far below it
    hold = GlideslopeHold("c172p", threshold=(0.0, 0.0), crossing_height=0.0)
    rows = []
    for k in range(300):
        north = -20_000.0 + sign * 100.0 * k * T
        h = -north * math.tan(math.radians(3.0)) + above if k < 100 else 500.0
        rows.append({"h": h, "lat": north / 362_700.0, "off": 100 <= k < 200})
    found = [y["captured"] for y in samples(hold, rows)]
    assert found[99] == captured
    assert not any(found[100:])


@pytest.mark.parametrize(
    ("block", "given", "parameter"),
    [
        (CourseHold, {"waypoints": []}, "waypoints"),
        (CourseHold, {"waypoints": (47.0, 11.0)}, "waypoints"),
        (CourseHold, {"waypoints": [(91.0, 11.0)]}, "waypoints"),
        (CourseHold, {"waypoints": [(47.0, 11.0), (47.0, 11.0)]}, "waypoints"),
        (CourseHold, {"waypoints": [(47.0, "east")]}, "waypoints"),
        (CourseHold, {"waypoints": [(47.0, 11.0)], "leg": 1}, "leg"),
        (CourseHold, {"leg": 1}, "leg"),
        (CourseHold, {"leg": -1}, "leg"),
        (CourseHold, {"waypoints": [(47.0, 11.0)], "chi_ref": 30.0}, "chi_ref"),
        (CourseHold, {"intercept": 91.0}, "intercept"),
        (CourseHold, {"intercept": 0.0}, "intercept"),
        (CourseHold, {"waypoints": [(47.0, 11.0)], "fly_over": [2]}, "fly_over"),
        (CourseHold, {"waypoints": [(47.0, 11.0)], "fly_over": 1}, "fly_over"),
        (CourseHold, {"waypoints": [(0, 0), (0, 1)], "arcs": {2: (0, 0, "left")}}, "arcs"),
        (CourseHold, {"waypoints": [(0, 0), (0, 1)], "arcs": {1: (0, 0.1, "left")}}, "arcs"),
        (CourseHold, {"waypoints": [(0, 0), (0, 1)], "arcs": {1: (0, 0.5, "up")}}, "arcs"),
        (CourseHold, {"waypoints": [(0, 0)], "holding": (0.0, "right", 0.0, 1e4)}, "holding"),
        (CourseHold, {"holding": (0.0, "right", 3e3, 1e4)}, "holding"),
        (CourseHold, {"waypoints": [(90, 0)], "holding": (90, "left", 6e3, 12e3)}, "holding"),
        (CourseHold, {"waypoints": [(-89.96, 9)], "holding": (5, "left", 6e3, 12e3)}, "holding"),
        (GlideslopeHold, {"threshold": 47.0}, "threshold"),
        (GlideslopeHold, {"threshold": (-91.0, 0.0)}, "threshold: latitude"),
        (GlideslopeHold, {"crossing_height": -1.0}, "crossing_height"),
        (Localizer, {"station": (95.0, 0.0)}, "station: latitude"),
        (Localizer, {"width": 0.0}, "width"),
        (Glideslope, {"noise": -1.0}, "noise"),
        (LocalizerHold, {"intercept": 90.0}, "intercept"),
    ],
)
def test_bad_parameters_are_refused(block, given, parameter):
    with pytest.raises(BlocksError) as caught:
        block(**given)
    assert caught.value.parameter == parameter


@pytest.mark.long
@pytest.mark.parametrize(
    ("ports", "low", "high"), [(None, 0.0, 800.0), ({"vt": lambda t: 0.0}, 1500.0, 3000.0)]
)
def test_a_turn_allows_for_the_wind(ports, low, high):
    # 25 kt across, which are from behind after the turn: 535 and 1917 ft
    corner = (47.0 + 7.0 * NMI, 11.0)
    end = (corner[0], 11.0 + 14.0 * NMI / math.cos(math.radians(47.0)))
    place = {"ic/lat-geod-deg": 47.0, "ic/long-gc-deg": 11.0}
    plane = Aircraft("A320", altitude=10_000.0, speed=250.0, gear=0.0, heading=0.0, setup=place)
    hold, wind = CourseHold("A320", waypoints=[corner, end]), (0.0, 25.0 * 1.68781)
    flight = flown(plane, 190.0, hold, AltitudeHold("A320"), wind=wind, ports=ports)
    assert low < np.max(-flight["across"][flight["leg"] == 1.0]) < high


@pytest.mark.long
def test_a_waypoint_is_flown_over_on_request():
    route = [(0.02, 0.0), (0.02, 0.06)]
    flight = level(110.0, CourseHold("c172p", waypoints=route, fly_over=[1]))
    away, _ = vdist(flight["lat"], flight["lon"], *route[0], WGS84)
    assert np.min(away) < 10.0
    turned = np.argmax(flight["leg"] == 1.0)
    assert away[turned] < 5.0
    # back onto the leg, from outside the turn
    assert np.min(flight["across"][turned:]) < -500.0
    assert np.max(np.abs(flight["across"][-600:])) < 50.0


@pytest.mark.long
@pytest.mark.parametrize(("side", "east"), first([("right", 1.0), ("left", -1.0)]))
def test_an_arc_in_wind(side, east):
    # a quarter of a circle of 5000 ft about a point beside the first waypoint
    radius = 5000.0
    centre = (0.02, east * radius / 365_221.0)
    top = 0.02 + radius / 362_776.0
    route = [(0.02, 0.0), (top, centre[1]), (top, east * 0.08)]
    hold = CourseHold("c172p", waypoints=route, arcs={1: (*centre, side)})
    flight = level(150.0, hold, wind=(-15.0, 20.0))
    arc = flight["leg"] == 1.0
    away, _ = vdist(flight["lat"][arc], flight["lon"][arc], *centre, WGS84)
    assert np.max(np.abs(away - radius)) < 80.0
    # the block's distance from the arc is that of the geodesics, positive to its right
    assert np.max(np.abs(east * (radius - away) - flight["across"][arc])) < 3.0
    assert flight["to_go"][arc][0] == pytest.approx(math.pi / 2 * radius, rel=0.05)
    assert np.ptp(flight["to_go"][arc]) > 0.9 * math.pi / 2 * radius
    after = flight["leg"] == 2.0
    assert np.max(np.abs(flight["across"][after])) < 80.0
    assert np.max(np.abs(flight["across"][-600:])) < 10.0


def quarter(radius, **options):
    """A right turn from north to east about 0 N 0 E."""
    ends = [(0.0, -radius / 365_221), (radius / 362_779, 0.0)]
    return CourseHold(waypoints=ends, arcs={1: (0.0, 0.0, "right")}, leg=1, **options)


def test_radii_that_take_more_than_the_largest_bank_are_refused():
    # c172p: gains for 90 KCAS at 5000 ft, 97 kt true in ISA: 163.5 ft/s, and 25 deg
    least = 163.5**2 / (32.174 * math.tan(math.radians(25.0)))
    quarter(1.01 * least)
    with pytest.raises(ParameterError) as error:
        quarter(0.99 * least)
    assert error.value.parameter == "arcs"
    quarter(0.99 * least, bank_max=26.0)
    with pytest.raises(ParameterError) as error:
        CourseHold(waypoints=[(0.0, 0.0)], holding=(0.0, "left", 1000.0, 3000.0))
    assert error.value.parameter == "holding"
    # of a schedule the slowest point counts: 225 KCAS at 1000 ft, 385 ft/s
    quarter(10_000.0, gains="A320")
    with pytest.raises(ParameterError):
        quarter(9_800.0, gains="A320")
    # numbers name no airspeed
    quarter(1000.0, gains={"heading": {"Kp": 1.0}, "roll": {"Kp": 0.01, "Ki": 0.001}})


def test_a_wind_that_makes_an_arc_too_tight_is_warned_of_once():
    for speed, said in ((160.0, None), (231.0, " 33 deg of bank at 137 kt over the ground")):
        rows = [{"lat": k * speed * T / 362_779, "lon": -2600.0 / 365_221} for k in range(5)]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            list(samples(quarter(2600.0, gains="c172p"), rows))
        assert [said in str(w.message) for w in caught] == ([True] if said else [])


@pytest.mark.filterwarnings("ignore:CourseHold. the arc of leg")  # of the drift found so far
@pytest.mark.parametrize("lat", [-89.0, 60.0, 89.5])
def test_a_holding_pattern_has_its_shape_at_any_latitude(lat):
    # from the fix once around, by geodesics: half a circle, a straight line, and both again
    course, radius, length = 70.0, 2600.0, 9000.0
    pattern = {"waypoints": [(lat, 20.0)], "holding": (course, "right", radius, length)}
    hold = CourseHold(**pattern, T=1.0)
    turn = [np.array([math.sin(x), 1 - math.cos(x)]) * radius for x in np.linspace(0, math.pi, 90)]
    line = [np.array([-x, 2 * radius]) for x in np.linspace(0.0, length, 90)]
    far_end = np.array([-length, 2 * radius])
    around = [*turn, *line, *(far_end - x for x in turn), *(far_end - x for x in line)]
    rows = []
    for ahead, right in [(-200.0, 0.0), *around]:
        azimuth = course + math.degrees(math.atan2(right, ahead))
        there = vreckon(lat, 20.0, math.hypot(ahead, right), azimuth, WGS84)
        rows.append(dict(zip(("lat", "lon"), map(float, there), strict=True)))
    flight = list(samples(hold, rows))
    assert {y["leg"] for y in flight} == {0.0, 1.0, 2.0, 3.0, 4.0}
    assert max(abs(y["across"]) for y in flight) < 5.0


@pytest.mark.long
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_holding_pattern_is_flown_again_and_again(side):
    fix, radius, length = (0.01, 0.0), 2600.0, 3000.0
    hold = CourseHold("c172p", waypoints=[fix], holding=(0.0, side, radius, length))
    with pytest.warns(RuntimeWarning, match="widened from 2600 to") as warned:
        flight = level(360.0, hold, wind=(10.0, 20.0))
    # 0.8 of 25 deg of bank at the airspeed plus the wind, which is measured on the way to the fix
    radius = float(str(warned[0].message).partition(" to ")[2].partition(" ft")[0])
    need = (163.5 + math.hypot(10.0, 20.0)) ** 2 / (32.174 * math.tan(math.radians(20.0)))
    assert radius == pytest.approx(need, rel=0.02)
    legs = flight["leg"][np.flatnonzero(np.diff(flight["leg"])) + 1]
    assert list(legs[:6]) == [1.0, 2.0, 3.0, 4.0, 1.0, 2.0]
    # the racetrack: two straight lines and two half circles, by geodesics
    turn = 1.0 if side == "right" else -1.0
    north, east, _ = geodetic2ned(flight["lat"], flight["lon"], 0.0, *fix, 0.0, WGS84)
    straight = np.clip(north, -length, 0.0)
    x, y = north - straight, turn * east - radius
    off = np.hypot(x, y) - radius
    pattern = flight["leg"] > 0.0
    assert np.max(np.abs(off[pattern])) < 150.0
    assert np.median(np.abs(off[pattern])) < 45.0


@pytest.mark.long
def test_a_holding_pattern_in_the_worst_of_eight_winds():
    # docs/navigation.md: its pattern in the worst of eight winds, to the south-west
    wind = 13.0 * 1.68781 * math.sqrt(0.5)
    hold = CourseHold("c172p", waypoints=[(0.03, 0.0)], holding=(90.0, "right", 2600.0, 9000.0))
    with pytest.warns(RuntimeWarning, match="widened") as caught:
        flight = level(560.0, hold, wind=(-wind, -wind))
    assert len(caught) == 1
    lap = flight["t"] > 300.0
    assert {*flight["leg"][lap]} == {1.0, 2.0, 3.0, 4.0}
    # 122 ft in this time; in 10 to 15 min of laps 145 ft from NE, 138 from SW, 128 from E, 124 from W,
    # 64 from NW and SE, 49 from N and S
    assert abs(flight["across"][lap]).max() < 150.0
    assert abs(flight["phi"][lap]).max() < 25.0


def test_a_pattern_is_widened_only_with_the_airspeed_and_once():
    def laps(vt, bank_max=25.0):
        pattern = {"waypoints": [(0.0, 0.0)], "holding": (90.0, "right", 2600.0, 3000.0)}
        hold = CourseHold(gains="c172p", bank_max=bank_max, T=1.0, **pattern)
        rows = [{"lon": (k - 5) * 190.0 / 365_221, "psi": 90.0, "vt": vt} for k in range(12)]
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            list(samples(hold, rows))
        return [str(w.message) for w in caught if "widened" in str(w.message)]

    # 190 ft/s over the ground at 163.5 ft/s through the air
    (message,) = laps(163.5)
    radius = 190.0**2 / (32.174 * math.tan(math.radians(20.0)))
    assert f"to {radius:.0f} ft: at 113 kt over the ground" in message
    assert laps(0.0) == laps(163.5, bank_max=35.0) == []
