"""Loops around the attitude, designed for small analytic plants and checked in plain loops."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hand_tuned import GAINS
from how_many import first
from scipy.linalg import expm

from pathsim_jsbsim_blocks.control.gains import AltitudeGains, YawGains
from pathsim_jsbsim_blocks.control.loops import SpeedLoop
from pathsim_jsbsim_blocks.design.outer import (
    coordinate,
    damped,
    design_altitude,
    design_feed,
    design_heading,
    design_rudder,
    design_speed,
    design_yaw,
    dutch_roll,
    level_slopes,
    speed_report,
    with_altitude,
    with_speed,
)
from pathsim_jsbsim_blocks.design.plant import Plant
from pathsim_jsbsim_blocks.design.search import Neighbours, Unstable

T = 1 / 120
OUTPUTS = ("theta", "phi", "psi", "p", "q", "r", "beta", "h", "hdot", "vc")


def sampled(A, B, *inputs, **rows):
    """A continuous plant whose inputs are held; outputs without a row are 0."""
    n, m = len(A), len(inputs)
    A, B = np.array(A, dtype=float), np.array(B, dtype=float).reshape(n, m)
    both = expm(np.block([[A, B], [np.zeros((m, n + m))]]) * T)
    C = np.array([rows.get(name, [0.0] * n) for name in OUTPUTS], dtype=float)
    return Plant(both[:n, :n], both[:n, n:], C, [*inputs], OUTPUTS, T)


def yawing(frequency=2.0, damping=0.2, power=-4.0):
    """A Dutch roll in sideslip and yaw rate (deg, deg/s) that the rudder excites."""
    decay = -frequency * damping
    A = [[decay, -1.0], [frequency**2 * (1 - damping**2), decay]]
    return sampled(A, [0.0, power], "rudder", beta=[1, 0], r=[0, 1])


@pytest.mark.parametrize(("frequency", "damping"), [(2.0, 0.1), (6.0, 0.3)])
def test_the_dutch_roll_is_found(frequency, damping):
    assert dutch_roll(yawing(frequency, damping)) == pytest.approx((frequency, damping), rel=1e-6)


@pytest.mark.parametrize("frequency", [0.2, 20.0])
def test_what_is_too_slow_or_too_fast_is_no_dutch_roll(frequency):
    assert dutch_roll(yawing(frequency)) is None


@pytest.mark.parametrize("power", [-4.0, 4.0])
@pytest.mark.parametrize("damping", [0.2, 0.3])
def test_the_yaw_damper_damps_the_dutch_roll_by_the_lowest_gain(power, damping):
    plant = yawing(damping=damping, power=power)
    gains = design_yaw(plant, room=1000.0)
    assert math.copysign(1.0, gains.K) == -math.copysign(1.0, power)
    assert dutch_roll(damped(plant, gains))[1] >= 0.35
    # gains are tried in steps of a factor of 1.19
    less = YawGains(K=gains.K / 1.19, tau=gains.tau)
    assert dutch_roll(damped(plant, less))[1] < 0.35


@pytest.mark.parametrize(
    ("plant", "room"),
    [
        pytest.param(yawing(damping=0.4), 1000.0, id="it is damped"),
        pytest.param(yawing(), 0.001, id="no rudder is left"),
        # the smallest gains fit, and damp no more than by a hundredth
        pytest.param(yawing(), 0.1, id="little rudder is left"),
    ],
)
def test_no_yaw_damper_where_it_is_of_no_use(plant, room):
    assert design_yaw(plant, room).K == 0.0


def test_the_yaw_damper_of_a_slow_rudder_has_the_margins_asked_for():
    # two lags of 0.35 s, so that a gain that damps well comes near to instability
    A = [[-0.2, -1, 0, 0], [3.96, -0.2, -4, 0], [0, 0, -1 / 0.35, 1 / 0.35], [0, 0, 0, -1 / 0.35]]
    plant = sampled(A, [0, 0, 0, 1 / 0.35], "rudder", beta=[1, 0, 0, 0], r=[0, 1, 0, 0])
    gains = design_yaw(plant, room=1000.0)
    assert gains.K != 0.0
    s = 1j * np.geomspace(0.05, 50.0, 2000)
    rudder = -4.0 / (0.35 * s + 1.0) ** 2 * np.exp(-0.5 * s * T)
    loop = -gains.K * 2.0 * s / (2.0 * s + 1.0) * rudder * (s + 0.2) / ((s + 0.2) ** 2 + 3.96)
    assert np.abs(1.0 + loop).min() >= 1 / 1.405
    assert np.abs(1.0 + loop * np.exp(-0.05 * s)).min() >= 1 / 1.81


def test_the_yaw_damper_keeps_to_the_rudder_that_is_left():
    free = abs(design_yaw(yawing(), room=1000.0).K)
    room = 10.0 * free / 0.9 * 0.8
    assert 10.0 * abs(design_yaw(yawing(), room).K) <= 0.9 * room


def rolling(speed, lag, sign=1.0):
    """Bank with a lag, and the heading that it turns: psi-dot is g phi / V."""
    A = [[-1 / lag, 0.0], [sign * 32.174 / speed, 0.0]]
    return sampled(A, [1 / lag, 0.0], "phi_cmd", phi=[1, 0], psi=[0, 1])


def flown_heading(plant, Kp, ramp, bank_max):
    """Heading and bank of a plain loop: bank per error, limited in size and rate."""
    x, cmd, flown = np.zeros(len(plant.A)), 0.0, []
    for _ in range(round(60.0 / T)):
        psi, phi = plant.row("psi") @ x, plant.row("phi") @ x
        flown.append((psi, phi))
        wanted = min(max(Kp * (30.0 - psi), -bank_max), bank_max)
        cmd += min(max(wanted - cmd, -ramp * T), ramp * T)
        x = plant.A @ x + plant.column("phi_cmd") * cmd
    return np.array(flown).T


def settles(signal, goal, tolerance):
    """Time from which a signal stays within a tolerance of its goal."""
    return (np.flatnonzero(np.abs(signal - goal) > tolerance)[-1] + 1) * T


@pytest.mark.parametrize(("speed", "lag"), [(400.0, 1.0), (200.0, 0.5), (800.0, 2.0)])
def test_a_turn_settles_as_reported(speed, lag):
    plant = rolling(speed, lag)
    gains, found = design_heading(plant, 10.0, 3.0, speed)
    psi, phi = flown_heading(plant, gains.Kp, 10.0, 25.0)
    assert found.settling == pytest.approx(settles(psi, 30.0, 0.5), abs=0.1)
    assert found.overshoot == pytest.approx(max(psi.max() - 30.0, 0.0), abs=0.02)
    assert found.use == pytest.approx(np.abs(phi).max() / 25.0, abs=0.01)
    assert found.overshoot <= 0.5
    assert found.relaxed == ""
    # in closed form: L = Kp g / (V s (lag s + 1)), and the hold of T
    w = found.crossover
    loop = gains.Kp * 32.174 / speed / (1j * w * (1j * lag * w + 1.0)) * np.exp(-0.5j * w * T)
    assert abs(loop) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(180.0 + np.degrees(np.angle(loop)), abs=0.5)


def test_a_bank_that_turns_the_wrong_way_has_no_heading_gains():
    with pytest.raises(Unstable):
        design_heading(rolling(400.0, 1.0, sign=-1.0), 10.0, 3.0, 400.0)


def climbing(speed, lag):
    """Rate of climb, with a lag behind the pitch angle, and altitude."""
    A = [[-2.0, 0.0, 0.0], [speed / 57.3 / lag, -1 / lag, 0.0], [0.0, 1.0, 0.0]]
    return sampled(A, [2.0, 0.0, 0.0], "theta_cmd", theta=[1, 0, 0], hdot=[0, 1, 0], h=[0, 0, 1])


@pytest.mark.parametrize(
    ("speed", "lag", "hdot_max", "ramp"),
    # the first needs the pitch angle faster than it may move
    first([(400.0, 1.0, 20.0, 0.3), (400.0, 1.0, 20.0, 4.0), (170.0, 0.6, 8.0, 4.0)]),
)
def test_a_climb_settles_as_reported(speed, lag, hdot_max, ramp):
    plant = climbing(speed, lag)
    gains, found = design_altitude(plant, ramp, hdot_max)
    assert gains.hdot_max == hdot_max
    x, total, cmd, flown = np.zeros(3), 0.0, 0.0, []
    for _ in range(round((80.0 + 1.3 * 500.0 / hdot_max) / T)):
        h, hdot = plant.row("h") @ x, plant.row("hdot") @ x
        flown.append((h, hdot, cmd))
        error = min(max(gains.Kh * (500.0 - h), -hdot_max), hdot_max) - hdot
        wanted = gains.Kp * error + total
        total += gains.Ki * T * error
        cmd += min(max(wanted - cmd, -ramp * T), ramp * T)
        x = plant.A @ x + plant.column("theta_cmd") * cmd
    h, _, theta = np.array(flown).T
    assert found.settling == pytest.approx(settles(h, 500.0, 10.0), abs=0.3)
    # the design computes with 6 periods in one step
    assert found.overshoot == pytest.approx(max(h.max() - 500.0, 0.0), abs=0.6)
    assert found.use == pytest.approx(np.abs(theta).max() / 10.0, abs=0.02)
    assert np.abs(h[-round(5.0 / T) :] - 500.0).max() < 0.2
    assert found.overshoot <= 5.0
    # in closed form: L = (Kp + Ki / s) (1 + Kh / s) hdot / theta, and the hold of T
    s = 1j * found.crossover
    loop = (gains.Kp + gains.Ki / s) * (1.0 + gains.Kh / s) * 2.0 / (s + 2.0)
    loop *= speed / 57.3 / (lag * s + 1.0) * np.exp(-0.5 * s * T)
    assert abs(loop) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(180.0 + np.degrees(np.angle(loop)), abs=0.6)


def accelerating(thrust, drag, lift=0.0, weight=0.0, engine=1.0):
    """Airspeed by throttle behind an engine, and by pitch, in kt/s; lift in ft/s of climb per kt.

    The rate of climb is that of the pitch reference, and of the airspeed by its lift.
    """
    A = [[-1 / engine, 0.0], [thrust, -drag - weight * lift]]
    both = expm(np.block([[np.array(A), np.diag([1 / engine, -weight])], [np.zeros((2, 4))]]) * T)
    # the rate of climb per deg is 1 ft/s, as far as the airspeed is concerned, and seen a period on
    a, B = np.zeros((3, 3)), np.zeros((3, 2))
    a[:2, :2], B[:2] = both[:2, :2], both[:2, 2:]
    B[2, 1] = 1.0
    C = np.zeros((len(OUTPUTS), 3))
    C[OUTPUTS.index("vc"), 1] = 1.0
    C[OUTPUTS.index("hdot")] = [0.0, lift, 1.0]
    return Plant(a, B, C, ["throttle", "theta_cmd"], OUTPUTS, T)


@pytest.mark.parametrize(("thrust", "drag"), [(6.0, 1 / 60), (3.0, -0.01), (18.0, 0.04)])
def test_slopes_are_those_of_level_flight(thrust, drag):
    # the climb that the airspeed makes at a held pitch angle takes 0.05 1/s beside the drag
    found = level_slopes(accelerating(thrust, drag, lift=0.5, weight=0.1, engine=0.05))
    assert found[0] == pytest.approx(thrust, rel=0.01)
    assert found[1] == pytest.approx(drag, abs=0.001)


@pytest.mark.parametrize(
    ("room", "step"), first([((-0.9, 0.9), 10.0), ((-0.6, 0.4), -40.0), ((-0.9, 0.1), 6.0)])
)
def test_an_airspeed_settles_as_reported(room, step):
    # 6 kt/s of full travel against a drag that takes 60 s, behind an engine that takes 1 s
    plant = accelerating(6.0, 1 / 60)
    gains = design_speed(plant, 180.0, room, 0.0)
    # without a model of turbulence
    assert gains.Kp * 6.0 == pytest.approx(0.12, rel=0.04)
    assert gains.Kp / gains.Ki == pytest.approx(25.0)
    found = speed_report(plant, gains, room, step)
    law, state = SpeedLoop(T, gains, room), SpeedLoop.START
    x, rows = np.zeros(3), []
    for k in range(round(150.0 / T)):
        vc = plant.row("vc") @ x
        command, _, state = law.sample(state, vc, 0.0, step if k else 0.0, 0.0, 0.0, False)
        rows.append((vc, command))
        x = plant.A @ x + plant.column("throttle") * command
    vc, throttle = np.array(rows).T
    assert found.settling == pytest.approx(settles(vc, step, 0.5), abs=0.5)
    assert found.overshoot == pytest.approx(max((np.sign(step) * (vc - step)).max(), 0.0), abs=0.05)
    assert found.overshoot < 0.5
    assert throttle.min() >= room[0]
    assert throttle.max() <= room[1]
    # in closed form: L = (Kp + Ki / s - Kp Tf s / (Tf s + 1)) 6 / ((s + 1) (s + 1 / 60))
    s = 1j * found.crossover
    law = gains.Kp / (0.5 * s + 1.0) + gains.Ki / s
    loop = law * 6.0 / (s + 1.0) / (s + 1 / 60) * np.exp(-0.5 * s * T)
    assert abs(loop) == pytest.approx(1.0, rel=0.01)
    assert found.phase_margin == pytest.approx(180.0 + np.degrees(np.angle(loop)), abs=0.5)


def in_noise(plant, size):
    """The plant with the airspeed moved by noise of that size, kt, through a lag of 8 s."""
    n, fade = len(plant.A), np.exp(-T / 8.0)
    A = np.block([[plant.A, np.zeros((n, 1))], [np.zeros((1, n)), fade * np.ones((1, 1))]])
    B = np.zeros((n + 1, 4))
    B[:n, :2] = plant.B
    B[n, 2] = (1.0 - fade) * size * np.sqrt(2.0 * 8.0)
    C = np.hstack([plant.C, np.zeros((len(plant.C), 1))])
    C[OUTPUTS.index("vc"), n] = 1.0
    return Plant(A, B, C, [*plant.inputs, "along", "up"], OUTPUTS, T)


LEVEL = AltitudeGains(Kh=0.1, Kp=0.1, Ki=0.05)


@pytest.mark.parametrize(
    ("size", "thrust", "crossover"),
    # calm air; a throttle of 0.032 per kt; rough air; air that is rough at any crossover
    [(0.5, 12.0, 0.3), (0.5, 6.0, 0.19), (12.0, 12.0, None), (50.0, 6.0, 0.09)],
)
def test_the_crossover_is_the_highest_whose_throttle_is_quiet_in_turbulence(
    size, thrust, crossover
):
    plant, room = in_noise(accelerating(thrust, 1 / 60), size), (-0.6, 0.4)
    gains = design_speed(plant, 180.0, room, 0.0, altitude=LEVEL)
    wc = gains.Kp * thrust
    if crossover:
        assert wc == pytest.approx(crossover, rel=0.06)
    # rms of the throttle behind the closed loop, by a time history of the plant and its noise
    held = with_speed(with_altitude(plant, LEVEL), gains).slower(12)
    x, throttle = np.zeros(len(held.A)), []
    for w in np.random.default_rng(2).normal(size=40_000) / np.sqrt(12.0 * T):
        x = held.A @ x + held.column("along") * w
        throttle.append(held.row("throttle") @ x)
    if wc > 0.095:
        assert np.std(throttle) < 1.1 * 0.4 / 3.0
    if crossover is None:
        assert 0.09 < wc < 0.3
        assert np.std(throttle) == pytest.approx(0.4 / 3.0, rel=0.1)


def test_the_airspeed_loop_is_that_of_the_neighbours_but_for_what_is_fed_forward():
    other = GAINS["c172p"]
    near = Neighbours([replace(other, speed=None), other])
    gains = design_speed(accelerating(6.0, 1 / 60), 180.0, (-0.6, 0.4), 0.02, near)
    assert gains == replace(other.speed, Kc=0.02)


def test_the_gains_of_the_neighbours_are_tried_too():
    own, other = np.array([7.0]), GAINS["c172p"]
    (Kp,) = Neighbours([other]).joined("pitch", Kp=own)
    assert Kp[0] == 7.0
    assert other.pitch.Kp in Kp
    assert (Kp[1:].min(), Kp.max()) == pytest.approx((other.pitch.Kp / 1.4, 7.0))
    assert Neighbours().joined("pitch", Kp=own) == (own,)


def test_a_throttle_that_slows_the_aircraft_has_no_airspeed_loop():
    with pytest.raises(Unstable) as caught:
        design_speed(accelerating(-2.0, 1 / 60), 180.0, (-0.6, 0.4), 0.0)
    assert caught.value.loop == "speed"


@pytest.mark.parametrize(("vc", "rate"), [(60.0, 1.0), (270.0, 1.2)])
def test_a_fast_aircraft_changes_its_airspeed_faster(vc, rate):
    assert design_speed(accelerating(6.0, 0.01), vc, (-0.6, 0.4), 0.0).ramp == pytest.approx(rate)


def test_the_throttle_that_a_climb_needs_is_fed_forward_up_to_a_share_of_what_is_left():
    # a climb takes 0.5 kt/s per ft/s, full throttle gives 5 kt/s: 0.1 of the throttle per ft/s
    A = np.array([[0.0, 0.0], [-0.5, -0.01]])
    both = expm(np.block([[A, np.diag([0.0, 5.0])], [np.zeros((2, 4))]]) * T)
    C = np.zeros((len(OUTPUTS), 2))
    C[OUTPUTS.index("vc"), 1] = 1.0
    B = both[:2, 2:]
    # the rate of climb follows the pitch reference within a period
    a = np.array([[0.0, 0.0], both[1, :2]])
    C[OUTPUTS.index("hdot"), 0] = 1.0
    B[0, 0] = 1.0
    plant = Plant(a, B, C, ["theta_cmd", "throttle"], OUTPUTS, T)
    assert design_feed(plant, (-0.9, 20.0), 40.0)[0] == pytest.approx(0.9 / 40.0)
    assert design_feed(plant, (-0.9, 0.3), 20.0)[0] == pytest.approx(0.3 / 20.0)
    assert design_feed(plant, (-9.0, 9.0), 20.0)[0] == pytest.approx(0.1, rel=0.02)


def turning(slip_per_bank, slip_per_rate, power):
    """Bank with a lag, and a sideslip that bank, roll rate and rudder build up: 2nd input."""
    lag, decay = 0.4, 1.5
    A = [[0.0, 1.0, 0.0], [-1 / lag**2, -2 / lag, 0.0], [slip_per_bank, slip_per_rate, -decay]]
    B = [[0.0, 0.0], [1 / lag**2, 0.0], [0.0, power]]
    rows = {"phi": [1, 0, 0], "p": [0, 1, 0], "beta": [0, 0, 1]}
    return sampled(A, B, "phi_cmd", "rudder", **rows)


@pytest.mark.parametrize("power", [-3.0, 5.0])
def test_what_bank_and_roll_rate_do_to_the_sideslip_is_cancelled(power):
    gains = coordinate(turning(0.12, -0.08, power), YawGains(K=0.0), 1.0, 10.0)
    # the rudder's effect is the opposite of theirs
    assert gains.Kbank == pytest.approx(-0.12 / power, rel=0.02)
    assert gains.Kroll == pytest.approx(0.08 / power, rel=0.05)


def test_little_rudder_is_kept_for_the_turn():
    free = coordinate(turning(0.12, -0.08, -3.0), YawGains(K=0.0), 1.0, 10.0)
    # a thousandth of the rudder: a degree of sideslip is cheaper
    short = coordinate(turning(0.12, -0.08, -3.0), YawGains(K=0.0), 0.001, 10.0)
    assert abs(short.Kbank) < 0.2 * abs(free.Kbank)


@pytest.mark.parametrize("power", [-3.0, 5.0])
def test_a_steady_sideslip_is_taken_out_and_its_rudder_given_back(power):
    yaw, _ = design_rudder(turning(0.12, -0.08, power), YawGains(K=0.0), 1.0, 300.0, 10.0)
    beta, total, found = 0.0, 0.0, []
    for push in (1.0, 0.0):  # deg/s, as a failed engine does; 0.67 deg without the rudder
        for _ in range(round(45.0 / T)):
            rudder = -yaw.Kp * beta - yaw.Ki * total
            total += T * beta
            beta += T * (push - 1.5 * beta + power * rudder)
        found.append((abs(beta), abs(rudder)))
    (slip, held), (_, after) = found
    assert slip < 0.02
    assert held == pytest.approx(1.0 / abs(power), rel=0.05)
    assert after < 0.03 * held
