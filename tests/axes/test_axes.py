"""Each pair of axes against JSBSim's own properties in flight, with wind and every angle moving."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plain_jsbsim import trimmed

from pathsim_jsbsim_blocks import (
    BodyToNED,
    BodyToWind,
    GeodeticToNED,
    NEDToBody,
    ParameterError,
    WindToBody,
    axes,
)

BODY = [f"forces/fb{i}-aero-lbs" for i in "xyz"]
WIND = [f"forces/fw{i}-aero-lbs" for i in "xyz"]
STABILITY = [f"forces/fs{i}-aero-lbs" for i in "xyz"]
MOMENT_BODY = [f"moments/{i}-aero-lbsft" for i in "lmn"]
MOMENT_STABILITY = [f"moments/{i}-stab-aero-lbsft" for i in ("roll", "pitch", "yaw")]
MOMENT_WIND = [f"moments/{i}-wind-aero-lbsft" for i in ("roll", "pitch", "yaw")]
ANGLES = ["aero/alpha-deg", "aero/beta-deg"]
EULER = ["attitude/phi-deg", "attitude/theta-deg", "attitude/psi-deg"]
GROUND = [f"velocities/{i}-fps" for i in "uvw"]
AIR = [f"velocities/{i}-aero-fps" for i in "uvw"]
NED = [f"velocities/v-{i}-fps" for i in ("north", "east", "down")]
VELOCITY_ECEF = [f"velocities/ecef-{i}-fps" for i in "xyz"]
GEODETIC = ["position/lat-geod-deg", "position/long-gc-deg", "position/geod-alt-ft"]
ECEF = [f"position/ecef-{i}-ft" for i in "xyz"]
ECI = [f"position/eci-{i}-ft" for i in "xyz"]
FROM_START = [f"position/from-start-neu-{i}-ft" for i in "neu"]
CG = [f"inertia/cg-{i}-in" for i in "xyz"]
REFERENCE_POINT = [f"metrics/visualrefpoint-{i}-in" for i in "xyz"]
REFERENCE_POINT_EARTH = [
    "position/vrp-gc-latitude_deg",
    "position/vrp-longitude_deg",
    "position/vrp-radius-ft",
]
OTHERS = ["velocities/vt-fps", "position/epa-rad"]
VECTORS = [BODY, WIND, STABILITY, MOMENT_BODY, MOMENT_STABILITY, MOMENT_WIND, EULER, GROUND, AIR]
VECTORS += [NED, VELOCITY_ECEF, GEODETIC, ECEF, ECI, FROM_START, CG, REFERENCE_POINT]
PROPERTIES = [*itertools.chain(*VECTORS, REFERENCE_POINT_EARTH, ANGLES, OTHERS)]

START = {
    "c172p": {"lat": 37.0, "lon": -122.0, "h": 5000.0, "kcas": 90.0, "psi": 40.0},
    "737": {"lat": -35.0, "lon": 150.0, "h": 15000.0, "kcas": 280.0, "psi": 250.0},
}

# Neighbouring doubles are 1e-11 apart at 1e5 lbf and 4e-9 apart at the Earth's 2e7 ft.
ROUNDING = 1e-8  # lbf, lbf ft, ft/s, ft
EARTH_ROUNDING = 1e-7  # ft


class Flight(dict):
    """Time histories of JSBSim properties; a list of names gives a tuple of them."""

    def __call__(self, names):
        return tuple(self[name] for name in names)


@pytest.fixture(scope="module", params=list(START))
def flight(request):
    """10 s of a plain JSBSim loop in wind, with the stick, wheel and pedals moving."""
    start = START[request.param]
    setup = {
        "ic/lat-geod-deg": start["lat"],
        "ic/long-gc-deg": start["lon"],
        "ic/vw-north-fps": 20.0,
        "ic/vw-east-fps": -30.0,
        "ic/vw-down-fps": 4.0,
    }
    fdm = trimmed(request.param, start["h"], start["kcas"], heading=start["psi"], setup=setup)
    rows = []
    for k in range(1200):
        t = k / 120.0
        fdm["fcs/elevator-cmd-norm"] = -0.2 * np.sin(2.0 * t)
        fdm["fcs/aileron-cmd-norm"] = 0.3 * np.sin(1.5 * t)
        fdm["fcs/rudder-cmd-norm"] = 0.5 * np.cos(t)
        assert fdm.run()
        if k % 10 == 9:
            rows.append([fdm[name] for name in PROPERTIES])
    return Flight(zip(PROPERTIES, np.transpose(rows), strict=True), start=start)


def largest(got, want):
    return np.max(np.abs(np.subtract(got, want)))


def test_the_flight_moves_every_angle(flight):
    alpha, beta = flight(ANGLES)
    phi, theta, psi = flight(EULER)
    assert np.ptp(alpha) > 2.0
    assert beta.min() < -1.0
    assert beta.max() > 1.0
    assert np.abs(phi).max() > 10.0
    assert np.ptp(theta) > 4.0
    assert np.ptp(psi) > 4.0


def test_drag_side_and_lift(flight):
    alpha, beta = flight(ANGLES)
    assert largest(axes.body_to_drag_side_lift(*flight(BODY), alpha, beta), flight(WIND)) < ROUNDING
    assert largest(axes.drag_side_lift_to_body(*flight(WIND), alpha, beta), flight(BODY)) < ROUNDING
    # without beta they are those of the stability axes
    assert largest(axes.body_to_drag_side_lift(*flight(BODY), alpha), flight(STABILITY)) < ROUNDING
    assert largest(axes.drag_side_lift_to_body(*flight(STABILITY), alpha), flight(BODY)) < ROUNDING


def test_body_stability_and_wind_axes(flight):
    alpha, beta = flight(ANGLES)
    body, stability, wind = flight(MOMENT_BODY), flight(MOMENT_STABILITY), flight(MOMENT_WIND)
    assert largest(axes.body_to_stability(*body, alpha), stability) < ROUNDING
    assert largest(axes.stability_to_body(*stability, alpha), body) < ROUNDING
    assert largest(axes.stability_to_wind(*stability, beta), wind) < ROUNDING
    assert largest(axes.wind_to_stability(*wind, beta), stability) < ROUNDING
    assert largest(axes.body_to_wind(*body, alpha, beta), wind) < ROUNDING
    assert largest(axes.wind_to_body(*wind, alpha, beta), body) < ROUNDING


def test_airspeed_lies_along_the_wind_axis(flight):
    alpha, beta = flight(ANGLES)
    speed = flight["velocities/vt-fps"]
    x, y, z = axes.body_to_wind(*flight(AIR), alpha, beta)
    assert largest(x, speed) < ROUNDING
    assert largest((y, z), 0.0) < ROUNDING
    got = axes.aerodynamic_angles(*flight(AIR))
    assert largest(got, (alpha, beta, speed)) < ROUNDING


def test_local_ned_and_body_axes(flight):
    euler = flight(EULER)
    assert largest(axes.body_to_ned(*flight(GROUND), *euler), flight(NED)) < ROUNDING
    assert largest(axes.ned_to_body(*flight(NED), *euler), flight(GROUND)) < ROUNDING


def test_geodetic_and_earth_centred_coordinates(flight):
    assert largest(axes.geodetic_to_ecef(*flight(GEODETIC)), flight(ECEF)) < EARTH_ROUNDING
    lat, lon, h = axes.ecef_to_geodetic(*flight(ECEF))
    want_lat, want_lon, want_h = flight(GEODETIC)
    # 1e-12 deg is 4e-7 ft on the ground
    assert largest((lat, lon), (want_lat, want_lon)) < 1e-12
    assert largest(h, want_h) < EARTH_ROUNDING


def test_tangent_plane_at_the_start(flight):
    lat0, lon0 = flight["start"]["lat"], flight["start"]["lon"]
    north, east, up = flight(FROM_START)
    want = north, east, -up
    assert largest(axes.geodetic_to_ned(*flight(GEODETIC), lat0, lon0), want) < EARTH_ROUNDING
    assert largest(axes.ecef_to_ned(*flight(ECEF), lat0, lon0), want) < EARTH_ROUNDING
    assert largest(axes.ned_to_ecef(*want, lat0, lon0), flight(ECEF)) < EARTH_ROUNDING
    back = axes.ned_to_geodetic(*want, lat0, lon0)
    assert largest(back[:2], flight(GEODETIC)[:2]) < 1e-12
    assert largest(back[2], flight(GEODETIC)[2]) < EARTH_ROUNDING


def test_velocity_in_earth_axes(flight):
    lat, lon, _ = flight(GEODETIC)
    assert (
        largest(axes.ned_vector_to_ecef(*flight(NED), lat, lon), flight(VELOCITY_ECEF)) < ROUNDING
    )
    assert (
        largest(axes.ecef_vector_to_ned(*flight(VELOCITY_ECEF), lat, lon), flight(NED)) < ROUNDING
    )


def test_inertial_and_earth_fixed_axes(flight):
    angle = np.rad2deg(flight["position/epa-rad"])
    assert np.ptp(angle) > 0.04  # 10 s at 15 deg an hour
    assert largest(axes.eci_to_ecef(*flight(ECI), angle), flight(ECEF)) < EARTH_ROUNDING
    assert largest(axes.ecef_to_eci(*flight(ECEF), angle), flight(ECI)) < EARTH_ROUNDING


def test_structural_axes_by_the_visual_reference_point(flight):
    """JSBSim carries the point from the structure to the Earth: every step of the way at once."""
    cg, point = flight(CG), flight(REFERENCE_POINT)
    lat, lon, _ = flight(GEODETIC)
    arm = axes.structural_to_body(*point, cg)
    ned = axes.body_to_ned(*arm, *flight(EULER))
    got = np.add(flight(ECEF), axes.ned_vector_to_ecef(*ned, lat, lon))

    lat_gc, lon_gc, radius = flight(REFERENCE_POINT_EARTH)
    lat_gc, lon_gc = np.deg2rad(lat_gc), np.deg2rad(lon_gc)
    want = (
        radius * np.cos(lat_gc) * np.cos(lon_gc),
        radius * np.cos(lat_gc) * np.sin(lon_gc),
        radius * np.sin(lat_gc),
    )
    # A wrong sign would show: the c172p's arm has all three parts, the 737's lies in its symmetry
    # plane.
    assert np.min(np.abs([part for part in arm if part.any()])) > 0.03
    assert largest(got, want) < EARTH_ROUNDING
    assert largest(axes.body_to_structural(*arm, cg), point) < ROUNDING


def test_the_axes_of_the_ellipsoid():
    a, b = 6378137.0 / 0.3048, 6356752.3142 / 0.3048  # TR8350.2, m to ft
    # JSBSim's semi-axes are rounded to 2e-4 ft.
    assert axes.geodetic_to_ecef(0.0, 0.0, 0.0) == pytest.approx((a, 0.0, 0.0), abs=3e-4)
    assert axes.geodetic_to_ecef(0.0, 90.0, 0.0) == pytest.approx((0.0, a, 0.0), abs=3e-4)
    assert axes.geodetic_to_ecef(-90.0, 0.0, 100.0) == pytest.approx(
        (0.0, 0.0, -b - 100.0), abs=3e-4
    )
    lat, _, h = axes.ecef_to_geodetic(0.0, 0.0, -b - 100.0)
    assert lat == -90.0
    assert h == pytest.approx(100.0, abs=3e-4)


parts = st.tuples(*[st.floats(-1e6, 1e6)] * 3)
angles = st.floats(-360.0, 360.0)


@given(st.floats(0.1, 1e4), st.floats(-179.0, 179.0), st.floats(-89.0, 89.0))
def test_aerodynamic_angles_of_a_velocity(speed, alpha, beta):
    u, v, w = axes.wind_to_body(speed, 0.0, 0.0, alpha, beta)
    assert axes.aerodynamic_angles(u, v, w) == pytest.approx((alpha, beta, speed), abs=1e-10)


@given(st.floats(-90.0, 90.0), st.floats(-180.0, 180.0), st.floats(-2000.0, 330000.0))
def test_geodetic_coordinates_and_back(lat, lon, h):
    ecef = axes.geodetic_to_ecef(lat, lon, h)
    # The documented error; degrees of longitude mean nothing at the poles, so compare points.
    tolerance = 1e-7 if h < 1e5 else 1e-5
    assert largest(axes.geodetic_to_ecef(*axes.ecef_to_geodetic(*ecef)), ecef) < tolerance
    assert axes.ecef_to_geodetic(*ecef)[2] == pytest.approx(h, abs=1e-7)


def test_angles_and_heights_not_given_are_0():
    assert axes.body_to_drag_side_lift(1.0, 2.0, 3.0) == (-1.0, 2.0, -3.0)
    assert axes.drag_side_lift_to_body(1.0, 2.0, 3.0) == (-1.0, 2.0, -3.0)
    point = (47.1, 8.2, 3000.0)
    ned, ecef = axes.geodetic_to_ned(*point, 47.0, 8.0, 0.0), axes.geodetic_to_ecef(*point)
    assert axes.geodetic_to_ned(*point, 47.0, 8.0) == ned
    assert axes.ned_to_geodetic(*ned, 47.0, 8.0) == pytest.approx(point, rel=1e-12)
    assert axes.ecef_to_ned(*ecef, 47.0, 8.0) == pytest.approx(ned, abs=1e-7)
    assert axes.ned_to_ecef(*ned, 47.0, 8.0) == pytest.approx(ecef, abs=1e-7)


def test_arrays_broadcast_and_are_not_shared():
    x = np.array([1.0, 2.0, 3.0])
    got = axes.body_to_stability(x, [[4], [5]], 0, 90.0)
    assert [part.shape for part in got] == [(2, 3)] * 3
    got[1][:] = 0.0
    got[0][:] = 0.0
    assert x.tolist() == [1.0, 2.0, 3.0]


def test_numbers_give_floats_and_nan_stays_where_it_is():
    assert all(isinstance(part, float) for part in axes.ned_to_body(1, 2, 3, 4, 5, 6))
    assert all(isinstance(part, float) for part in axes.geodetic_to_ned(1, 2, 3, 4, 5, 6))
    x, _, _ = axes.ned_to_body([1.0, np.nan], 0.0, 0.0, 0.0, 0.0, 0.0)
    assert x.tolist() == pytest.approx([1.0, np.nan], nan_ok=True)


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda: axes.ned_to_body("1", 0, 0, 0, 0, 0), "north"),
        (lambda: axes.body_to_wind(1, 0, 0, None, 0), "alpha"),
        (lambda: axes.body_to_wind(1, 0, 0, 0, 1j), "beta"),
        (lambda: axes.body_to_stability([[1], [1, 2]], 0, 0, 0), "x"),
        (lambda: axes.body_to_ned([1, 2], 0, 0, [1, 2, 3], 0, 0), "x, y, z, phi, theta, psi"),
        (lambda: axes.structural_to_body(1, 2, 3, (1, 2)), "reference"),
        (lambda: axes.body_to_structural(1, 2, 3, 4), "reference"),
        (lambda: axes.body_to_structural(1, 2, 3, np.array(4.0)), "reference"),
        (lambda: axes.structural_to_body(1, 2, 3, (1, 2, "3")), "reference[2]"),
        (lambda: axes.geodetic_to_ecef(91, 0, 0), "lat"),
        (lambda: axes.geodetic_to_ned(0, 0, 0, [0, -91], 0), "lat0"),
        (lambda: axes.ned_to_geodetic(0, 0, 0, 100, 0), "lat0"),
        (lambda: axes.ecef_vector_to_ned(0, 0, 0, 100, 0), "lat"),
        (lambda: axes.ned_vector_to_ecef(0, 0, 0, 100, 0), "lat"),
        (lambda: axes.ecef_to_geodetic(0, 0, 0), "x, y, z"),
        (lambda: axes.ecef_to_geodetic(6378137.0, 0, 0), "x, y, z"),  # metres
        (lambda: GeodeticToNED(lat0=-90.5), "lat0"),
        (lambda: GeodeticToNED(lon0=float("nan")), "lon0"),
        (lambda: GeodeticToNED(h0="5000"), "h0"),
    ],
)
def test_bad_input_is_refused_by_name(call, parameter):
    with pytest.raises(ParameterError) as error:
        call()
    assert error.value.parameter == parameter


FORCE_PORTS = ["drag", "side", "lift"]
XYZ_PORTS = ["x", "y", "z"]
NED_PORTS = ["north", "east", "down"]
ANGLE_PORTS = ["alpha", "beta"]
EULER_PORTS = ["phi", "theta", "psi"]


def evaluate(block, ports, values, outputs):
    for port, value in zip(ports, values, strict=True):
        block.inputs[block.input_port_labels[port]] = value
    block.update(0.0)
    return [block.outputs[port] for port in outputs]


@pytest.mark.parametrize(
    ("block", "ports", "inputs", "to_ports", "outputs"),
    [
        (WindToBody, FORCE_PORTS + ANGLE_PORTS, WIND + ANGLES, XYZ_PORTS, BODY),
        (BodyToWind, XYZ_PORTS + ANGLE_PORTS, BODY + ANGLES, FORCE_PORTS, WIND),
        (NEDToBody, NED_PORTS + EULER_PORTS, NED + EULER, XYZ_PORTS, GROUND),
        (BodyToNED, XYZ_PORTS + EULER_PORTS, GROUND + EULER, NED_PORTS, NED),
        # without beta the wind axes are the stability axes
        (WindToBody, [*FORCE_PORTS, "alpha"], STABILITY + ANGLES[:1], XYZ_PORTS, BODY),
        (BodyToWind, [*XYZ_PORTS, "alpha"], BODY + ANGLES[:1], FORCE_PORTS, STABILITY),
    ],
)
def test_blocks_turn_what_jsbsim_flew(flight, block, ports, inputs, to_ports, outputs):
    for u, y in zip(np.transpose(flight(inputs)), np.transpose(flight(outputs)), strict=True):
        assert largest(evaluate(block(), ports, u, to_ports), y) < ROUNDING


def test_block_of_the_tangent_plane(flight):
    block = GeodeticToNED(flight["start"]["lat"], flight["start"]["lon"])
    u = [history[-1] for history in flight(GEODETIC)]
    north, east, up = (history[-1] for history in flight(FROM_START))
    got = evaluate(block, ["lat", "lon", "h"], u, NED_PORTS)
    assert largest(got, (north, east, -up)) < EARTH_ROUNDING
    block.h0 = 1000.0  # edited while the diagram runs
    got = evaluate(block, ["lat", "lon", "h"], u, NED_PORTS)
    assert largest(got, (north, east, 1000.0 - up)) < EARTH_ROUNDING
