"""The holds on the nonlinear aircraft in still air: the table of docs/evidence/autopilots.md.

The limits are those documented for the holds; the measured values are about half of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from flights import POINTS, T, fly, on, start, step, until, wrap
from how_many import first
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import PitchHold

AIRCRAFT = list(POINTS)
PITCH = {"pitch_mode": on, "roll_mode": on, "speed_off": on}


@pytest.mark.parametrize(
    ("name", "time", "overshoot", "error"),
    first([("737", 3.5, 8.0, 0.02), ("c172p", 4.0, 6.0, 0.03), ("global5000", 9.0, 8.0, 0.03)]),
)
def test_pitch_step_to_3_deg(name, time, overshoot, error):
    flight = fly(start(name), 30.0, PITCH, theta_ref=3.0)
    theta = flight["theta"]
    size = 3.0 - theta[0]
    assert flight.settled("theta", 3.0, 0.05) < time
    assert 100 * np.max((theta - 3.0) / size) < overshoot
    assert np.max(np.abs(theta[-600:] - 3.0)) < error  # over the last 5 s


@pytest.mark.parametrize(
    ("name", "pulse", "time"),
    first([("c172p", 0.132, 2.5), ("737", -0.409, 3.0), ("global5000", 0.209, 3.0)]),
)
def test_pitch_upset_of_5_deg(name, pulse, time):
    plane = start(name)
    theta = plane.trim.theta
    flight = fly(
        plane,
        10.0,
        {**PITCH, "pitch_off": until(1.5)},
        theta_ref=theta,
        pulse={"elevator": lambda t: pulse * (0.5 < t + T / 2 < 1.5)},
    )
    after = flight.after(1.5)
    assert abs(after["theta"][0] - theta) == pytest.approx(5.0, abs=0.3)
    assert after.settled("theta", theta, 0.5) < time


@pytest.mark.parametrize(
    ("name", "overshoot"), first([("global5000", 0.6), ("c172p", 0.5), ("737", 0.6)])
)
def test_roll_to_20_deg_and_back(name, overshoot):
    ports = {"roll_mode": on, "phi_ref": lambda t: 20.0 * (t < 20.0 - T / 2)}
    flight = fly(start(name), 40.0, ports, phi_ref=0.0)
    there, back = flight.before(20.0), flight.after(20.0)
    assert there.settled("phi", 20.0, 0.4) < 4.5
    assert np.max(there["phi"]) - 20.0 < overshoot
    assert back.settled("phi", 0.0, 0.4) < 4.5
    assert -np.min(back["phi"]) < overshoot


@pytest.mark.parametrize(
    ("name", "time", "heading", "turn"),
    first([("c172p", 18.0, 350.0, 20.0), ("737", 40.0, 90.0, 30.0), ("global5000", 42.0, 350, 20)]),
)
def test_heading(name, time, heading, turn):
    flight = fly(start(name, heading=heading), 50.0, {"psi_ref": step(turn)})
    assert flight.settled("psi", heading + turn, 0.5) < time
    error = wrap(flight["psi"] - heading - turn) * np.sign(turn)
    assert np.max(error) < 0.3
    # through the smaller angle: at most one degree of adverse yaw away from the start
    assert np.min(error) > -abs(turn) - 1.0
    assert np.max(np.abs(flight["phi"])) < 25.5


@pytest.mark.parametrize(
    ("name", "seconds"), first([("c172p", 70.0), ("737", 200.0), ("global5000", 200.0)])
)
def test_half_a_turn_leaves_no_wound_up_integral(name, seconds):
    flight = fly(start(name), seconds, {"psi_ref": step(179.0)})
    error = wrap(flight["psi"] - 90.0 - 179.0)
    assert np.max(error[np.abs(error) < 90.0]) < 0.1
    assert abs(error[-1]) < 0.05


@pytest.mark.long
@pytest.mark.parametrize(("name", "time"), [("c172p", 60.0), ("737", 38.0), ("global5000", 35.0)])
def test_altitude_500_ft_up_and_held_for_300_s(name, time):
    flight = fly(start(name), 400.0, {"h_ref": step(500.0)})
    goal = flight["h"][0] + 500.0
    assert flight.settled("h", goal, 10.0) < time
    assert np.max(flight["h"]) - goal < 5.0
    assert np.max(np.abs(flight.after(100.0)["h"] - goal)) < 2.0
    assert np.max(np.abs(flight["hdot_cmd"])) <= {"c172p": 10.0}.get(name, 25.0)
    # the autothrottle, with the climb fed forward
    assert np.max(np.abs(flight["vc"] - flight["vc"][0])) < 5.0


@pytest.mark.parametrize(
    ("name", "time", "altitude"),
    first([("737", 28.0, 15.0), ("c172p", 15.0, 10.0), ("global5000", 28.0, 15.0)]),
)
def test_airspeed_10_kt_up(name, time, altitude):
    flight = fly(start(name), 60.0, {"vc_ref": step(10.0)})
    assert flight.settled("vc", flight["vc"][0] + 10.0, 0.5) < time
    assert np.max(np.abs(flight["h"] - flight["h"][0])) < altitude
    assert np.max(np.abs(np.diff(flight["vc_cmd"]))) < 3.0 * T  # kt per sample


@pytest.mark.parametrize("name", first(AIRCRAFT))
def test_nothing_moves_in_still_air(name):
    flight = fly(start(name), 20.0)
    assert np.max(np.abs(flight["h"] - flight["h"][0])) < 0.2
    assert np.max(np.abs(flight["psi"] - flight["psi"][0])) < 0.05
    assert np.max(np.abs(flight["vc"] - flight["vc"][0])) < 0.05


@pytest.mark.parametrize(
    ("modes", "condition"),
    first(
        [
            (PITCH, {"mode": "turn", "bank": 20.0}),
            ({}, {"gamma": 3.0}),
            (PITCH, {}),
            (PITCH, {"gamma": 3.0}),
            ({}, {"mode": "turn", "bank": 20.0}),
        ],
        2,
    ),
)
@pytest.mark.parametrize("name", first(AIRCRAFT))
def test_no_command_jumps_at_engagement(name, condition, modes):
    offs = {port: until(2.0) for port in ("pitch_off", "roll_off", "speed_off", "yaw_off")}
    flight = fly(start(name, **condition), 3.0, {**modes, **offs})
    k = np.flatnonzero(flight["t"] > 2.0 - T / 2)[0]
    for command in ("elevator", "aileron", "rudder", "throttle"):
        assert np.all(flight[command][:k] == 0.0)
        assert abs(flight[command][k]) < 1e-12
    if modes:
        # engaged with default references, the flight continues unchanged
        for angle in ("theta", "phi"):
            assert np.max(np.abs(flight[angle] - flight[angle][k])) < 0.15


def test_references_and_gains_change_in_flight():
    plane, hold, scope = start("c172p"), PitchHold("c172p"), Scope()
    connections = [
        Connection(plane["theta", "q"], hold["theta", "q"]),
        Connection(hold["elevator"], plane["elevator"], scope),
    ]
    sim = Simulation([plane, hold, scope], connections, dt=T, log=False)
    sim.run(2.0)
    hold.theta_ref = 4.0
    sim.run(10.0)
    assert plane.outputs["theta"] == pytest.approx(4.0, abs=0.05)
    hold.theta_ref = None  # what it finds
    sim.run(2.0)
    assert plane.outputs["theta"] == pytest.approx(4.0, abs=0.1)
    k = len(scope.read()[0])
    hold.gains = {"Kp": 0.0, "Ki": 0.0}
    sim.run(0.5)
    assert np.ptp(scope.read()[1][0][k:]) < 1e-15
