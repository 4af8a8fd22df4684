"""Receivers, localizer, glide slope from far below and from above, flare and go-around.

Positions are compared with pymap3d's geodesy. A good landing: at most 6 ft/s and 5 deg at the
touchdown, 30 ft beside the centre line.
"""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from flights import WGS84, T, samples
from how_many import first
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, Source
from pymap3d import geodetic2aer, geodetic2ned
from test_navigation import NMI, flown

from pathsim_jsbsim_blocks import (
    Aircraft,
    FlareHold,
    Glideslope,
    GlideslopeHold,
    HeadingHold,
    Localizer,
    LocalizerHold,
    TrimCondition,
    fly,
)
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.control.gain_tables import document_of, table

STATION = (47.0, 11.0)


def seen(receiver, *u, samples=1):
    """Outputs of a receiver at one place, a row for each sample."""
    state, rows = receiver.initial_state(), []
    for _ in range(samples):
        y, state = receiver.law(list(u), state)
        rows.append(y)
    return np.array(rows)


def sampled(block, *rows):
    """The outputs of the last of some samples."""
    return list(samples(block, rows))[-1]


@pytest.mark.parametrize("course", [0.0, 140.0, 265.0])
@pytest.mark.parametrize("place", [(46.93, 10.9), (47.05, 11.02), (46.99, 11.1)])
def test_a_localizer_measures_from_its_course_line(course, place):
    north, east, _ = geodetic2ned(*place, 0.0, *STATION, 0.0, WGS84)
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
    _, elevation, slant = geodetic2aer(lat, lon, 500.0 + height, *STATION, 500.0, WGS84)
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


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "start", "below", "seconds"),
    [
        # V tan(3 deg) is 27 ft/s and 8 ft/s, hdot_max 25 ft/s and 1.6 ft/s
        ("737", {"altitude": 6000.0, "speed": 280.0, "gear": 0.0}, 2430.0, 200.0),
        ("pa28", {"altitude": 2000.0, "speed": 95.0, "solver": "newton"}, 1156.0, 260.0),
    ],
)
def test_the_altitude_is_held_until_the_glide_path_is_met(name, start, below, seconds):
    altitude = start["altitude"]
    away = (altitude + below) / math.tan(math.radians(3.0))
    threshold = (away / 362_760.0, 0.0)
    plane = Aircraft(name, condition=TrimCondition(**start))
    flight = flown(
        plane,
        seconds,
        GlideslopeHold(name, threshold=threshold, crossing_height=0.0),
        HeadingHold(name, psi_ref=0.0),
    )
    # the Earth's surface falls away below the path
    assert flight["gs_ft"][0] == pytest.approx(-below - away**2 / (2 * 20.9e6), abs=20.0)
    capture = np.flatnonzero(flight["captured"])[0]
    assert np.max(np.abs(flight["h"][:capture] - altitude)) < 20.0
    assert -300.0 < flight["gs_ft"][capture] < 0.0
    assert np.max(flight["h"]) < altitude + 20.0
    assert np.max(np.abs(flight["gs_ft"][-600:])) < 25.0
    assert flight["h"][-1] < altitude - 300.0


@pytest.mark.long
def test_on_request_the_glide_path_is_captured_from_above():
    away = 1500.0 / math.tan(math.radians(3.0))
    threshold = ((away - 6000.0) / 362_760.0, 0.0)
    hold = GlideslopeHold("c172p", threshold=threshold, crossing_height=0.0, from_above=True)
    flight = flown(
        Aircraft("c172p", altitude=1500.0, speed=80.0),
        90.0,
        hold,
        HeadingHold("c172p", psi_ref=0.0),
    )
    assert flight["gs_ft"][0] > 290.0
    assert flight["captured"][-1] == 1.0
    assert np.max(np.abs(flight["gs_ft"][-600:])) < 25.0
    assert flight["gs_ft"].min() > -25.0


def approached(diagram, until=lambda outputs: outputs["phase"] >= 1.0):
    """Fly a diagram's approach until something about its flare."""
    while not until(diagram.flare.outputs):
        fly(diagram.sim, 0.1)


def calm(name, **more):
    """A landing in still air, from some seconds before the glide path."""
    height, longitude = {"737": (600.0, 10.945), "c172p": (200.0, 10.980)}[name]
    own = load_diagram(f"autoland_{name}").aircraft.condition
    condition = TrimCondition(
        altitude=height + 500.0,
        speed=own.speed,
        heading=90.0,
        latitude=47.0,
        longitude=longitude,
        gear=own.gear,
        flaps=own.flaps,
    )
    still = {"TURBULENCE": {}, "aircraft.condition": condition}
    return load_diagram(f"autoland_{name}", {**still, **more})


def test_without_a_gain_on_the_heading_a_localizer_is_not_captured():
    hold = LocalizerHold(gains={"heading": {"Kp": 0.0, "Ki": 0.0}, "roll": "c172p"}, course=30)
    rows = [{"psi": 30.0, "loc_ft": 500.0, "loc_dist": 20_000.0 - k} for k in range(3)]
    outputs = sampled(hold, *rows)
    assert np.isfinite([*outputs.values()]).all()
    # the course line is approached infinitely slowly
    assert outputs["chi_cmd"] == pytest.approx(30.0)


@pytest.mark.parametrize("heading", [270.0, 300.0, 190.0])
def test_a_localizer_is_not_captured_outbound(heading):
    # from 8 nmi, on the course line: outbound, and crossing it at 150 and 100 deg
    away = math.radians(heading - 90.0)
    rows = [
        {
            "psi": heading,
            "loc_ft": 130.0 * k * T * math.sin(away),
            "loc_dist": 48_600.0 - 130.0 * k * T * math.cos(away),
            "vc": 75.0,
        }
        for k in range(240)
    ]
    outputs = sampled(LocalizerHold("c172p", course=90.0), *rows)
    assert outputs["captured"] == float(heading == 190.0)
    assert (outputs["aileron"] == 0.0) != outputs["captured"]


def test_a_localizer_is_captured_in_a_crosswind():
    plane = Aircraft(
        "c172p",
        condition=TrimCondition(altitude=1500.0, speed=80.0, heading=60.0, wind_north=-17.0),
    )
    receiver = Localizer(station=(0.004, 0.3), course=90.0)
    hold, scope = LocalizerHold("c172p", course=90.0), Scope()
    wires = [
        Connection(plane["lat", "lon"], receiver["lat", "lon"]),
        Connection(receiver["ft", "dist"], hold["loc_ft", "loc_dist"]),
        Connection(plane["psi", "phi", "p"], hold["psi", "phi", "p"]),
        Connection(hold["aileron"], plane["aileron"]),
        Connection(receiver["ft"], scope[0]),
        Connection(hold["captured"], scope[1]),
        Connection(plane["psi"], scope[2]),
    ]
    fly(Simulation([plane, receiver, hold, scope], wires, dt=T, log=False), 110.0)
    time, (across, captured, psi) = scope.read()
    begun = int(np.argmax(captured))
    assert 1.0 < time[begun] < 60.0
    assert np.max(np.abs(psi[:begun] - 60.0)) < 2.0  # the heading until then
    assert across[0] == pytest.approx(1459.0, abs=10.0)  # 0.004 deg of latitude
    assert across.min() > -60.0
    assert np.max(np.abs(across[-600:])) < 5.0
    # 17 ft/s across 143 ft/s
    assert psi[-1] == pytest.approx(90.0 - math.degrees(math.asin(17.0 / 143.0)), abs=1.0)


@pytest.mark.parametrize("name", first(["c172p", "737"]))
def test_a_landing_in_still_air(name):
    diagram = calm(name)
    approached(diagram)
    # without a bump: no command jumps as the flare begins
    before = [diagram.flare.outputs[port] for port in ("elevator", "aileron", "rudder")]
    fly(diagram.sim, T)
    after = [diagram.flare.outputs[port] for port in ("elevator", "aileron", "rudder")]
    assert np.max(np.abs(np.subtract(after, before))) < 0.1
    approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    fly(diagram.sim, 8.0)
    assert diagram.flare.outputs["brakes"] > 0.9
    fly(diagram.sim, 8.0)
    _, (_, wheels) = diagram.landing.read()
    _, (climb, vc) = diagram.rates.read()
    _, (across, distance) = diagram.ground.read()
    _, (theta, phi, _) = diagram.attitude.read()
    touch = int(wheels.argmax())
    assert 0.5 < -climb[touch - 1] < 3.5
    assert abs(8000.0 - distance[touch]) < 1300.0
    assert abs(across[touch]) < 5.0
    assert abs(phi[touch]) < 1.0
    assert theta[touch] > 0.0
    # idle, on the wheels
    assert diagram.flare.outputs["throttle"] == -1.0
    assert vc[-1] < 0.6 * vc[touch]
    assert np.max(np.abs(across[touch:])) < 10.0


@pytest.mark.long
def test_a_downdraft_in_the_flare_is_countered():
    diagram = calm("c172p")
    plane = diagram.aircraft

    def sinks(t):
        """Air that sinks by up to 14 ft/s below a height of the wheels of 12 to 6 ft."""
        return 14.0 * min(max((16.0 - plane.outputs["h_agl"]) / 6.0, 0.0), 1.0)

    air = Source(sinks)
    diagram.sim.add_block(air)
    diagram.sim.add_connection(Connection(air, plane["wind_down"]))
    approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    _, (_, wheels) = diagram.landing.read()
    _, (climb, _) = diagram.rates.read()
    # 3.4 ft/s; without the gust in the law it is 5.4 ft/s
    assert 0.0 < -climb[int(wheels.argmax()) - 1] < 4.4


SINKS = {"hdot": -8.0, "vc": 65.0, "loc_dist": 9e3, "alpha": 4.0}


@pytest.mark.parametrize(
    ("heights", "ports", "expected"),
    [
        ((17, 15, 10, 15, 19, 21), {}, [1, 1, 1, 1, 1, 3]),
        # 0 is on the wheels: a bounce, a step of the runway, and a bounce of more than 10 ft
        ((5, 0, 2, 7, 3, 0, 0.5), {}, [1, 2, 1, 1, 1, 2, 2]),
        ((5, 0, 2, 8, 13, 20), {}, [1, 2, 1, 1, 3, 3]),
        # another approach, after it was off
        (
            (80, 90, 200, 200, 5),
            {"go_around": (1, 0, 0, 0, 0), "off": (0, 0, 1, 0, 0)},
            [3, 3, 0, 0, 1],
        ),
        # a course that is not that of the runway, forgotten or in radians: it would steer off it
        ((56,), {"psi": (90,)}, [3]),
    ],
)
def test_flare_roll_out_and_go_around_follow_each_other(heights, ports, expected):
    rows = [
        SINKS | {"h_agl": height + 4.0, "wow": height == 0, "elevator": 0.01 * height}
        for height in heights
    ]
    for port, values in ports.items():
        rows = [row | {port: value} for row, value in zip(rows, values, strict=True)]
    found = list(samples(FlareHold("c172p"), rows))
    assert [y["phase"] for y in found] == expected
    for y, row in zip(found, rows, strict=True):
        assert y["phase"] > 0.0 or y["elevator"] == row["elevator"]


def test_a_flare_that_is_too_long_is_given_up():
    # at 1 ft per sample, level above the runway
    rows = [SINKS | {"h_agl": 9.0, "loc_dist": 9e3 - k} for k in range(240)]
    phases = [y["phase"] for y in samples(FlareHold("c172p", float_max=100.0), rows)]
    assert set(phases[:100]) == {1.0}
    assert phases[105] == 3.0


def test_a_low_go_around_never_lowers_its_nose():
    # the airspeed falls by 4 ft/s2, which asks for a descent
    climbs = SINKS | {"hdot": 6.0, "theta": 5.0, "alpha": 2.0, "go_around": 1.0}
    rows = [
        climbs | {"h_agl": 60.0 if k < 240 else 120.0, "vc": 70.0 - 0.02 * k} for k in range(360)
    ]
    pitch = [y["theta_cmd"] for y in samples(FlareHold("c172p"), rows)]
    assert min(pitch[:240]) >= 5.0
    assert pitch[-1] < 3.0


@pytest.mark.long
def test_an_aircraft_that_has_stopped_stands():
    # on full brakes it rolled backwards and could tip onto its tail, which strikes at 10 deg; gusts
    # still rock it by some degrees
    diagram = load_diagram("autoland_c172p")
    approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    fly(diagram.sim, 90.0)
    time, (theta, _, _) = diagram.attitude.read()
    _, (_, distance) = diagram.ground.read()
    late = time > time[-1] - 30.0
    # without brakes idle thrust and gusts move it, more slowly than 2 ft/s
    assert np.ptp(distance[late]) < 60.0
    assert np.max(theta[late]) < 8.0
    assert diagram.aircraft.outputs["gear/wow"]


def test_gains_that_land_in_some_flares_only_warn_with_the_reason(tmp_path):
    with pytest.warns(RuntimeWarning, match=r"1.5 deg/s2 at 181 KCAS .* tau of 6 s"):
        FlareHold("MD11")
    # a file of one's own tells it as a table does
    copy = tmp_path / "mine.json"
    document = document_of(table("MD11"))
    copy.write_text(json.dumps(document))
    with pytest.warns(RuntimeWarning, match="tau of 6 s"):
        FlareHold(str(copy))
    del document["no_landing"]
    copy.write_text(json.dumps(document))
    with pytest.warns(RuntimeWarning, match="no landings were flown"):
        FlareHold(str(copy))


@pytest.mark.long
@pytest.mark.parametrize("height", [10.0, 80.0, None])
@pytest.mark.parametrize("name", ["737", "c172p"])
def test_a_go_around_climbs_away_from_any_height(name, height):
    diagram = calm(name)
    gear = diagram.flare.gear_height
    plane, flare = diagram.aircraft, diagram.flare
    if height is None:
        approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    else:
        approached(diagram, lambda outputs: plane.outputs["h_agl"] < height + gear)
    begun, airspeed = plane.outputs["h_agl"], plane.outputs["vc"]
    sinking = -plane.outputs["hdot"]
    diagram.go_around.value = 1.0
    fly(diagram.sim, 25.0)
    _, (above, _) = diagram.height.read()
    _, (_, vc) = diagram.rates.read()
    since = slice(len(above) - 3000, None)
    assert flare.outputs["phase"] == 3.0
    assert above[-1] > begun + 100.0
    # it gives up at most 2.5 s of its sink, as the rate of climb changes by 8 ft/s2
    assert above[since].min() > begun - 2.5 * max(sinking, 0.0) - 2.0
    assert vc[since].min() > airspeed - 9.0
    assert abs(plane.outputs["phi"]) < 3.0


@pytest.mark.long
def test_a_go_around_deep_in_the_roll_out_keeps_the_tail_off_the_ground():
    # the nose is raised only at the airspeed of the touchdown: a contact would end the flight
    diagram = calm("c172p")
    approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    airspeed = diagram.aircraft.outputs["vc"]
    approached(diagram, lambda outputs: diagram.aircraft.outputs["vc"] < 25.0)
    diagram.go_around.value = 1.0
    approached(diagram, lambda outputs: not diagram.aircraft.outputs["gear/wow"])
    assert diagram.aircraft.outputs["vc"] > airspeed - 5.0
    fly(diagram.sim, 30.0)
    assert diagram.aircraft.outputs["h_agl"] > 150.0
    _, (across, _) = diagram.ground.read()
    assert np.max(np.abs(across)) < 30.0


@pytest.mark.long
@pytest.mark.parametrize("name", ["c172p", "737"])
def test_a_go_around_turns_its_airspeed_into_height(name):
    diagram = calm(name)
    approached(diagram, lambda outputs: diagram.aircraft.outputs["h_agl"] < 150.0)
    airspeed = diagram.aircraft.outputs["vc"]
    diagram.go_around.value = 1.0
    fly(diagram.sim, 90.0)
    _, (_, vc) = diagram.rates.read()
    # the 737 was at 232 KCAS with flaps and gear down
    assert np.max(vc[-6000:]) < 1.2 * airspeed
    assert diagram.aircraft.outputs["hdot"] > diagram.flare.climb


@pytest.mark.long
def test_a_go_around_keeps_its_heading_with_an_engine_at_idle():
    # from 200 ft; with the wings level the heading was 24 deg off after 60 s
    more = {"aircraft.input_properties": ["brakes", "steering", "throttle[0]"]}
    diagram, stopped = calm("737", **more), Constant(0.0)
    diagram.sim.add_block(stopped)
    diagram.sim.add_connection(Connection(stopped, diagram.aircraft["throttle[0]"]))
    approached(diagram, lambda outputs: diagram.aircraft.outputs["h_agl"] < 200.0)
    diagram.go_around.value, stopped.value = 1.0, -2.0
    fly(diagram.sim, 30.0)
    assert abs(diagram.aircraft.outputs["psi"] - 90.0) < 4.0
    assert diagram.aircraft.outputs["h_agl"] > 250.0


@pytest.mark.parametrize("hold", [LocalizerHold, GlideslopeHold])
def test_a_receiver_tuned_to_another_station_captures_nothing(hold):
    # 3 nmi from one on the ground ahead, then 500 ft below and beside the beams of a nearer one
    block = hold("c172p")
    block.inputs.wired = set(block.input_port_labels)
    level = {"h": 500.0, "vc": 75.0, "theta": 2.0, "alpha": 2.0}
    beams = {"loc_ft": 2500.0, "gs_ft": -500.0, "gs_deg": -1.5}
    rows = []
    for k in range(480):
        away = 18_000.0 - k + (8000.0 if k < 240 else 0.0)
        rows.append(level | beams | {"loc_dist": away, "gs_dist": away})
    assert not any(y["captured"] for y in samples(block, rows))


@pytest.mark.filterwarnings("ignore:.*not connected. the command")
@pytest.mark.parametrize(
    ("hold", "connected", "missing"),
    [
        # without gs_ft the height above the path would be 0: captured at once
        (GlideslopeHold, "gs_dist h hdot theta q", "gs_deg, gs_ft"),
        # it would neither steer nor brake
        (FlareHold, "h_agl loc_ft loc_dist hdot theta q psi phi p r vc", "wow"),
    ],
)
def test_a_wire_from_a_receiver_or_wheels_that_is_missing_is_named(hold, connected, missing):
    block = hold("c172p")
    block.inputs.wired.update(connected.split())
    sim = Simulation([block], dt=T, log=False)
    with pytest.warns(RuntimeWarning, match=f"at unconnected inputs: {missing}$"):
        fly(sim, 0.1)


@pytest.mark.long
def test_the_approach_after_a_go_around_lands():
    # on a runway 16,000 ft further on; the holds wait while the go-around climbs
    diagram, again = calm("c172p"), Constant(0.0)
    flare, plane = diagram.flare, diagram.aircraft
    holds = [diagram.vertical, diagram.lateral, diagram.airspeed]
    # inside: a wire of the diagram carries nothing to blocks of its subsystem
    diagram.autoland.add_block(again)
    diagram.autoland.add_connection(Connection(again, flare["off"]))
    diagram.autoland.add_connection(Connection(flare["phase"], *(hold["off"] for hold in holds)))
    approached(diagram, lambda outputs: plane.outputs["h_agl"] < 80.0)
    diagram.go_around.value = 1.0
    approached(diagram, lambda outputs: plane.outputs["h_agl"] > 300.0)
    diagram.go_around.value, again.value = 0.0, 1.0
    further = 16_000.0 / (365_221.0 * 1.0018 * math.cos(math.radians(47.0)))
    diagram.glideslope.station = (47.0, 11.0 + further)
    diagram.localizer.station = (47.0, 11.0321 + further)
    fly(diagram.sim, 0.1)
    again.value = 0.0
    approached(diagram, lambda outputs: outputs["phase"] > 0.0)
    approached(diagram, lambda outputs: outputs["phase"] != 1.0)
    assert flare.outputs["phase"] == 2.0
    assert plane.outputs["hdot"] > -6.0
    assert abs(diagram.glideslope.outputs["dist"]) < 1000.0
    assert abs(diagram.localizer.outputs["ft"]) < 30.0
    _, (_, vc) = diagram.rates.read()
    assert np.min(vc) > 65.0


def test_in_the_roll_out_a_gust_is_no_stall():
    # at 13 KCAS an angle of attack of 60 deg is a breeze; the elevator went to its stop
    rolls = {"h_agl": 4.0, "theta": -1.0, "wow": 1.0}
    rows = [
        rolls | {"vc": 40.0 - 0.075 * k, "loc_dist": 9e3 - k, "alpha": 2.0 if k < 340 else 60.0}
        for k in range(360)
    ]
    outputs = sampled(FlareHold("c172p"), *rows)
    assert outputs["phase"] == 2.0
    assert outputs["theta_cmd"] == pytest.approx(-1.0)
    assert abs(outputs["elevator"]) < 0.1


@pytest.mark.parametrize(("speed", "brakes"), [(40.0, 1.0), (10.0, 0.5), (0.0, 0.0), (-5.0, 0.0)])
def test_brakes_ease_to_none_at_the_standstill(speed, brakes):
    rolls = {"h_agl": 4.0, "wow": 1.0, "theta": -1.0, "alpha": 2.0}
    rows = [rolls | {"loc_dist": 9e3 - speed * k * T} for k in range(720)]
    assert sampled(FlareHold("c172p"), *rows)["brakes"] == pytest.approx(brakes, abs=0.01)


A320 = {
    **{f"{x}.gains": "A320" for x in ("lateral", "vertical", "airspeed", "damper", "flare")},
    "aircraft.aircraft": "A320",
    "flare.gear_height": 8.9,
    "flare.tau": 3.0,
    "flare.float_max": 8000.0,
    "flare.theta_max": 10.0,
}


@pytest.mark.long
@pytest.mark.parametrize("wind", [17.0, -17.0])  # ft/s
@pytest.mark.parametrize(
    ("name", "more", "speed"), [("737", A320, 185.0), ("737", {}, 148.0), ("c172p", {}, 70.0)]
)
def test_a_roll_out_in_a_crosswind_stays_on_the_runway(name, more, speed, wind):
    # with the yaw damper's rudder the A320 was 119 ft aside, of 75 ft
    own = calm(name).aircraft.condition
    condition = replace(own, speed=speed, wind_north=wind)
    diagram = calm(name, **more, **{"aircraft.condition": condition})
    approached(diagram, lambda outputs: outputs["phase"] == 2.0)
    approached(diagram, lambda _: diagram.aircraft.outputs["vc"] < 30.0)
    _, (_, wheels) = diagram.landing.read()
    _, (across, _) = diagram.ground.read()
    assert np.max(np.abs(across[int(wheels.argmax()) :])) < 40.0
