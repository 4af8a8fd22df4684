"""Turbulence on linear aircraft, against flights through moving air, noise and closed forms."""

import dataclasses

import numpy as np
import pytest
from hand_tuned import GAINS

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.design import outer, search
from pathsim_jsbsim_blocks.design.plant import Plant
from pathsim_jsbsim_blocks.design.turbulence import AIR, Rough, at_a_stop, in_turbulence, rms
from pathsim_jsbsim_blocks.wind import dryden_field

T = 1 / 120
LINEAR = ("theta", "phi", "psi", "p", "q", "r", "beta", "h", "hdot", "vc")
POINT = {"altitude": 5000.0, "speed": 90.0}


@pytest.fixture(scope="module")
def model():
    plane = Aircraft("c172p", **POINT)
    return plane.linear_model(inputs=["elevator", "aileron", "rudder", "throttle"], outputs=LINEAR)


@pytest.fixture(scope="module")
def rough(model):
    return in_turbulence(Plant.of(model), model, POINT["altitude"])


def held(plant, gains):
    """The plant with pitch angle, airspeed and altitude held."""
    plant = search.closed(plant, search.PITCH, gains.pitch, "theta_cmd")
    return outer.with_altitude(outer.with_speed(plant, gains.speed), gains.altitude)


def flown(wind, omega, gains):
    """Complex amplitudes of the outputs per ft/s of a wind that oscillates.

    The gains have no envelope, so no protection acts.
    """
    plane, autopilot = Aircraft("c172p", **POINT), Autopilot(gains=gains, T=T)
    ports, names = autopilot.input_port_labels, list(Aircraft.output_port_labels)
    wired = [(ports[name], i) for i, name in enumerate(names) if name in ports]
    period = round(2 * np.pi / omega / T)
    # what begins with the wind has decayed
    n = round(40.0 / T) + 2 * period
    u, state, rows = [0.0] * len(ports), autopilot.initial_state(), np.empty((n, len(names) + 1))
    command, y = [0.0] * len(plane.input_port_labels), plane.outputs.to_array().tolist()
    for k in range(n):
        plane.fdm[f"atmosphere/wind-{wind}-fps"] = np.sin(omega * k * T)
        rows[k] = *y, command[3]
        for port, i in wired:
            u[port] = y[i]
        out, state = autopilot.law(u, state)
        command[:4] = out[:4]
        y = plane.advance(k + 1, command)
    late = rows[-2 * period :]
    turn = np.exp(-1j * omega * T * np.arange(n - 2 * period, n)) / period * 1j
    return dict(zip([*names, "throttle"], (late - late.mean(axis=0)).T @ turn, strict=True))


@pytest.mark.parametrize(("wind", "sign", "air"), [("north", 1.0, "along"), ("down", -1.0, "up")])
def test_moving_air_moves_the_linear_aircraft_as_the_flown_one(rough, wind, sign, air):
    # the aircraft flies north, where JSBSim's wind blows to
    omega, gains = 0.4, GAINS["c172p"]
    plant = held(rough, gains)
    response = plant.response(np.array([omega]), air)
    # per ft/s of the air's own motion, which is the state after its lag
    z = np.exp(1j * omega * T)
    x = np.linalg.solve(z * np.eye(len(plant.A)) - plant.A, plant.column(air))
    moves = x[len(rough.A) - len(AIR) + AIR.index(air)]
    amplitudes = flown(wind, omega, gains)
    for name in ("h", "hdot", "theta", "vc", "throttle"):
        expected = sign * response[name][0] / moves
        assert amplitudes[name] == pytest.approx(expected, abs=0.03 * abs(expected)), name


@pytest.fixture
def rising(model):
    """How a plant that does nothing by itself rises with the air."""
    n = len(model.states)
    still = Plant(np.eye(n), np.zeros((n, 1)), np.zeros((len(LINEAR), n)), ["elevator"], LINEAR, T)
    return lambda h, omega: in_turbulence(still, model, h).response(omega, "up")["hdot"]


def test_a_frozen_aircraft_rises_with_the_air(rising):
    omega = np.geomspace(1e-4, 300.0, 2000)
    assert rms(omega, rising(5000.0, omega)) == pytest.approx(
        dryden_field(5000.0).sigma_w, rel=0.01
    )
    # and below 1000 ft the air rises less: MIL-F-8785C, a tenth of 30 kt
    low = rms(omega, rising(900.0, omega))
    assert low == pytest.approx(3.0 * 1852 / 3600 / 0.3048, rel=0.01)


def test_the_air_rises_through_a_lag(rising):
    omega = np.array([0.01, 0.2, 3.0])
    # the corner is 2 V / L with L of 1750 ft; 90 KCAS is 163.6 ft/s at 5000 ft (ISA)
    corner = 2.0 * 163.6 / 1750.0
    size = dryden_field(5000.0).sigma_w * np.sqrt(2.0 * corner)
    expected = size / np.hypot(omega, corner)
    assert np.abs(rising(5000.0, omega)) == pytest.approx(expected, rel=2e-3)


def test_the_rms_of_independent_noises_adds_in_squares():
    omega = np.geomspace(1e-4, 1e4, 4000)
    # unit noise through sqrt(2 a) / (s + a): 1
    lag = np.sqrt(2 * 0.5) / (1j * omega + 0.5)
    assert rms(omega, 3.0 * lag, 4.0 * lag) == pytest.approx(5.0, rel=1e-3)


@pytest.mark.parametrize("room", [(-0.5, 0.5), (-0.9, 0.1), (-0.2, 0.8)])
def test_the_share_at_a_stop_is_that_of_normal_numbers(room):
    throttle = 0.2 * np.random.default_rng(3).normal(size=400_000)
    expected = np.mean((throttle <= room[0]) | (throttle >= room[1]))
    assert at_a_stop(np.array([0.2]), room)[0] == pytest.approx(expected, abs=0.002)
    assert at_a_stop(np.array([0.0]), room)[0] == 0.0


@pytest.mark.parametrize(
    ("altitude", "pitch", "stop", "cost"),
    [
        # aimed at are 60 ft as 3.3 rms, 3.75 deg and 1 % of the time
        (18.0, 3.7, 0.009, 0.0),
        (2.0 * 60.0 / 3.3, 0.0, 0.0, 30.0),
        (0.0, 1.25 * 3.75, 0.0, 200.0),
        (0.0, 0.0, 0.02, 40.0),
        # above 5.6 deg and 5 % a little less makes no difference
        (0.0, 5.7, 0.0, 400.0),
        (0.0, 8.0, 0.0, 400.0),
        (0.0, 0.0, 0.051, 160.0),
        (0.0, 0.0, 0.3, 160.0),
    ],
)
def test_what_an_excess_costs(altitude, pitch, stop, cost):
    found = Rough(*(np.array([x]) for x in (altitude, pitch, stop)))
    assert found.cost()[0] == pytest.approx(cost)


def test_requirements_that_are_not_met_are_listed():
    rough = Rough(*(np.array(x) for x in ((18.0, 20.0), (3.7, 5.2), (0.009, 0.06))))
    assert rough.violations(0) == ()
    assert rough.violations(1) == (
        "turbulence 20 ft rms",
        "turbulence 5.2 deg rms",
        "turbulence 6% at the throttle's stop",
    )


def test_states_that_no_output_shows_leave_turbulence_out(model):
    hidden = dataclasses.replace(model, states=(*model.states[:-1], "x1"))
    assert in_turbulence(Plant.of(hidden), hidden, 5000.0).inputs == list(hidden.inputs)


def test_the_law_of_the_throttle_is_an_output(rough):
    gains = dataclasses.replace(GAINS["c172p"].speed, Kd=-0.01, Tf=0.5)
    plant = outer.with_speed(rough, gains)
    omega = np.array([0.05, 0.3])
    y = plant.response(omega, "elevator")
    climb = plant.response(omega, "hdot_cmd")
    s = 1j * omega
    # the continuous law
    law = gains.Kp + gains.Ki / s + gains.Kd * s / (gains.Tf * s + 1.0)
    assert y["throttle"] == pytest.approx(-law * y["vc"], rel=0.01)
    # the commanded rate of climb is fed forward behind a lag of 2 s
    expected = gains.Kc / (2.0 * s + 1.0) - law * climb["vc"]
    assert climb["throttle"] == pytest.approx(expected, rel=0.01)


def test_the_throttle_follows_the_aircraft_and_not_the_gust(rough):
    omega = np.array([0.02, 0.1, 1.0])
    y = rough.response(omega, "along")
    u = y["airspeed"] - y["vc"]
    # u with a corner of V / L, behind a high-pass of 10 s, in kt of calibrated airspeed: 90 KCAS
    # are 163.6 ft/s at 5000 ft (ISA)
    corner, s = 163.6 / 1750.0, 1j * omega
    size = dryden_field(5000.0).sigma_u * np.sqrt(2.0 * corner) * 90.0 / 163.6
    expected = size / (s + corner) * 10.0 * s / (10.0 * s + 1.0)
    assert u == pytest.approx(expected, rel=0.01)
