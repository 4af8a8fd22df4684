"""The autopilot diagrams: what their docstrings say is what they fly."""

import control
import numpy as np
import pytest
from pathsim import Connection
from pathsim.blocks import Scope
from pymap3d import geodetic2ned
from test_diagrams_flight import flown

from pathsim_jsbsim_blocks import fly as fly_diagram
from pathsim_jsbsim_blocks.axes.earth import _ellipsoid
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.plots import signal

T = 1 / 120


def settled(time, error, tolerance):
    return time[np.flatnonzero(np.abs(error) > tolerance)[-1] + 1]


def test_pitch_hold():
    diagram = flown("pitch_hold")
    time, theta = signal(diagram.pitch, "pitch angle")
    assert diagram.sim.time == pytest.approx(30.0)
    assert theta[0] == pytest.approx(1.28, abs=0.01)
    assert settled(time, theta - 3.0, 0.05) == pytest.approx(1.8, abs=0.1)
    assert theta.max() == pytest.approx(3.025, abs=0.005)
    _, elevator = signal(diagram.flight, "elevator increment")
    assert elevator[0] == 0.0
    assert elevator[time == time[60]] < 0.0  # nose up is negative
    _, h = signal(diagram.flight, "altitude")
    _, vc = signal(diagram.flight, "calibrated airspeed")
    assert h[-1] - h[0] == pytest.approx(93.0, abs=1.0)
    assert vc[-1] == pytest.approx(83.1, abs=0.1)


def test_fleet_pitch_hold():
    diagram = flown("fleet_pitch_hold")
    time, pitches = diagram.pitch.read()
    after = {}
    for label, theta in zip(diagram.pitch.labels, pitches, strict=True):
        name = label.split()[0]
        error = theta - theta[0] - 5.0
        after[name] = settled(time, error, 0.5) - 1.0
        assert np.max(error) < 0.05 * 5.0, name
        assert np.abs(error[-120:]).max() < 0.1, name
        # the same by python-control, for which a step is in the band of 10 %
        late = time > 1.0 - 1e-9
        info = control.step_info(
            theta[late] - theta[0], T=time[late] - 1.0, yfinal=5.0, SettlingTimeThreshold=0.1
        )
        assert after[name] == pytest.approx(info["SettlingTime"], abs=1.01 * T)
    assert after["c172p"] == pytest.approx(1.9, abs=0.1)
    assert after["A320"] == pytest.approx(3.1, abs=0.1)
    assert max(after.values()) == after["A320"]


@pytest.mark.long
def test_approach_737():
    diagram = flown("approach_737")
    _, (distance, altitude) = diagram.position.read()
    time, (across, above) = diagram.deviation.read()
    _, (vc, psi, chi) = diagram.flight.read()
    assert time[-1] == pytest.approx(290.0, abs=2.0)
    assert altitude[-1] == pytest.approx(700.0, abs=0.2)
    # 150 ft above the crossing height, on a path of 3 deg
    assert distance[-1] == pytest.approx(150.0 / np.tan(np.radians(3.0)), abs=20.0)
    place = diagram.aircraft.outputs["lat"], diagram.aircraft.outputs["lon"]
    north, east, _ = geodetic2ned(*place, 0.0, *diagram.THRESHOLD, 0.0, _ellipsoid())
    assert np.hypot(north, east) == pytest.approx(distance[-1], abs=0.1)
    assert -north == pytest.approx(across[-1], abs=1.0)  # the runway leads to the east
    assert across.min() > -1.0
    final = distance < 5 * 6076.12
    assert np.abs(across[final]).max() < 5.0
    assert np.abs(above[final]).max() < 10.0
    assert vc[0] == pytest.approx(170.0, abs=0.1)
    assert vc[-1] == pytest.approx(150.7, abs=0.3)
    assert chi[-1] - psi[-1] == pytest.approx(5.5, abs=0.5)


@pytest.mark.long
def test_stall_protection():
    diagram = flown("stall_protection")
    _, [kept, lost] = diagram.heights.read()
    _, [vc, vc_lost] = diagram.speeds.read()
    _, [alpha, alpha_lost] = diagram.angles.read()
    # what an autopilot does that watches the airspeed alone
    assert vc_lost.min() == pytest.approx(46.3, abs=0.1)
    assert alpha_lost.max() == pytest.approx(25.3, abs=0.1)
    assert lost[0] - lost[-1] == pytest.approx(4351.0, abs=50.0)
    assert vc.min() == pytest.approx(50.6, abs=0.1)
    assert vc[-1] == pytest.approx(51.9, abs=0.1)
    assert alpha.max() == pytest.approx(12.5, abs=0.1)
    assert np.abs(kept - 5000.0).max() < 14.5
    # a throttle with three times the gain oscillates by 1 kt until the end
    swing = [np.ptp(vc[t * 120 : (t + 20) * 120]) for t in (60, 100, 140, 180)]
    assert swing == pytest.approx([0.76, 0.49, 0.31, 0.17], abs=0.02)


@pytest.mark.long
def test_pitch_hold_from_primitives_holds_the_same_with_more_overshoot():
    diagram = flown("pitch_hold_primitives")
    time, theta = signal(diagram.pitch, "pitch angle")
    assert settled(time, theta - 3.0, 0.05) == pytest.approx(2.6, abs=0.05)
    assert theta.max() == pytest.approx(3.18, abs=0.01)
    assert abs(theta[-1] - 3.0) < 0.02
    _, elevator = signal(diagram.flight, "elevator increment")
    assert elevator[0] == pytest.approx(-0.171, abs=0.001)
    _, hold = signal(flown("pitch_hold").flight, "elevator increment")
    assert np.abs(hold).max() == pytest.approx(0.055, abs=0.001)
    # with the same gains, both end at the same elevator
    assert elevator[-1] == pytest.approx(hold[-1], abs=0.002)


@pytest.mark.long
def test_altitude_hold():
    diagram = flown("altitude_hold")
    time, h = signal(diagram.climb, "altitude")
    assert settled(time, h - 5500.0, 10.0) - 5.0 == pytest.approx(51.4, abs=0.05)
    assert h.max() == pytest.approx(5502.1, abs=0.2)
    _, climb = signal(diagram.climb, "rate of climb")
    assert climb.max() == pytest.approx(10.0, abs=0.1)
    _, vc = signal(diagram.climb, "calibrated airspeed")
    assert vc.min() == pytest.approx(86.7, abs=0.1)
    assert vc.max() == pytest.approx(90.9, abs=0.1)


def test_heading_hold_goes_the_short_way_across_north():
    diagram = flown("heading_hold")
    time, psi = signal(diagram.heading, "heading")
    error = psi - 10.0
    assert psi[0] == pytest.approx(-10.0)
    assert error.min() > -21.0
    assert error.max() < 0.1
    assert settled(time, error, 0.5) == pytest.approx(12.6, abs=0.05)
    _, phi = signal(diagram.bank, "roll angle")
    assert phi.max() == pytest.approx(23.8, abs=0.5)
    _, h = signal(diagram.flight, "altitude")
    assert np.max(np.abs(h - h[0])) < 4.6


def test_airspeed_hold():
    diagram = flown("airspeed_hold")
    time, vc = signal(diagram.speed, "calibrated airspeed")
    assert settled(time, vc - 100.0, 0.5) - 5.0 == pytest.approx(11.9, abs=0.1)
    assert vc.max() < 100.5
    _, h = signal(diagram.flight, "altitude")
    assert np.max(np.abs(h - h[0])) < 3.0


def test_yaw_damper_doubles_the_damping():
    diagram = flown("yaw_damper")
    assert diagram.damping_ratio("bare") == pytest.approx(0.18, abs=0.01)
    assert diagram.damping_ratio("damped") == pytest.approx(0.40, abs=0.01)
    time, r = signal(diagram.yaw, "yaw rate, bare")
    free = r[time > 1.5] - r[-1]
    crossings = time[time > 1.5][1:][np.diff(np.sign(free)) != 0]
    assert np.mean(np.diff(crossings)[:4]) * 2 == pytest.approx(2.9, abs=0.1)  # s, the period


@pytest.mark.long
def test_autopilot_mission_follows_every_reference_in_turbulence():
    diagram, limits = load_diagram("autopilot_mission"), Scope()
    diagram.sim.add_block(limits)
    outputs = ("elev_sat", "ail_sat", "rud_sat", "thr_sat")
    diagram.sim.add_connection(Connection(diagram.aircraft[outputs], limits[:4]))
    fly_diagram(diagram.sim, diagram.DURATION)
    saturation = limits.read()[1]
    time, h = signal(diagram.flight, "altitude")
    _, psi = signal(diagram.flight, "heading")
    _, vc = signal(diagram.flight, "calibrated airspeed")
    level, low = (time > 90.0) & (time < 180.0), time > 215.0
    assert np.max(np.abs(h[level] - 11_500.0)) < 40.0
    assert np.max(np.abs(h[low] - 11_000.0)) < 45.0
    assert np.max(np.abs(psi[time > 115.0] - 150.0)) < 2.2
    fast = time > 150.0
    assert np.max(np.abs(vc[fast] - 295.0)) < 15.1
    assert np.mean(vc[fast]) == pytest.approx(295.0, abs=1.0)
    assert np.std(np.diff(vc)) > 0.05  # kt: the air is not still
    assert np.all(saturation[:3] == 0.0)
    assert np.mean(saturation[3] != 0.0) == pytest.approx(0.0022, abs=0.001)
