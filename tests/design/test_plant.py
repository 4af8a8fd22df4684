"""The sampled plant and loops closed around it, against plain loops with the library's own laws."""

import dataclasses

import control
import numpy as np
import pytest

from pathsim_jsbsim_blocks import Aircraft
from pathsim_jsbsim_blocks.control.gains import AltitudeGains, AttitudeGains, SpeedGains, YawGains
from pathsim_jsbsim_blocks.control.loops import SpeedLoop, YawLoop, attitude_loop
from pathsim_jsbsim_blocks.design import outer, search
from pathsim_jsbsim_blocks.design.plant import Plant
from pathsim_jsbsim_blocks.guidance.climb_loops import AltitudeLoop, AltitudeState

T = 1 / 120
OUTPUTS = ("theta", "phi", "psi", "p", "q", "r", "beta", "h", "hdot", "vc")
FAR = (-1e9, 1e9)


@pytest.fixture(scope="module")
def model():
    plane = Aircraft("737", altitude=5000.0, speed=260.0, gear=0.0)
    return plane.linear_model(inputs=["elevator", "aileron", "rudder", "throttle"], outputs=OUTPUTS)


@pytest.fixture(scope="module")
def plant(model):
    return Plant.of(model)


def fly(plant, u):
    """Outputs for inputs of shape (n, m)."""
    x, y = np.zeros(len(plant.A)), []
    for row in u:
        y.append(plant.C @ x)
        x = plant.A @ x + plant.B @ row
    return np.array(y)


def test_the_plant_is_the_linear_model(model, plant):
    u = np.random.default_rng(1).normal(0.0, 0.02, (400, 4))
    model = dataclasses.replace(model, D=np.zeros_like(model.D))
    expected = model.simulate(u + model.u0)[:-1] - model.y0
    assert fly(plant, u) == pytest.approx(expected, abs=1e-9)


def test_the_frequency_response_is_that_of_the_model_with_its_delay(model, plant):
    omega = np.array([0.1, 1.0, 5.0, 100.0])
    theta = OUTPUTS.index("theta")
    model = dataclasses.replace(model, D=np.zeros_like(model.D))
    expected = model.frequency_response(omega)[:, theta, 0]
    found = plant.response(omega, "elevator")["theta"]
    assert found == pytest.approx(expected, rel=1e-6)


def stepped(plant, input_, size, n):
    u = np.zeros((n, len(plant.inputs)))
    u[1:, plant.inputs.index(input_)] = size
    return fly(plant, u)


def law_flown(plant, actuator, law, n):
    """A plain loop of the plant and a law, from outputs by name to a command."""
    x, y = np.zeros(len(plant.A)), []
    b = plant.column(actuator)
    for k in range(n):
        row = plant.C @ x
        y.append(row)
        x = plant.A @ x + b * law(k, dict(zip(plant.outputs, row, strict=True)))
    return np.array(y)


def attitude_flown(plant, law, angle, rate, actuator, size):
    """600 samples of a law in a step of its reference: the outputs, and the commands."""
    state, commands = law.START, []

    def fly_law(k, y):
        nonlocal state
        target = size if k else 0.0
        command, _, state = law.sample(state, y[angle], y[rate], target, 0.0, 0.0, False)
        commands.append(command)
        return command

    return law_flown(plant, actuator, fly_law, 600), commands


GAINS = AttitudeGains(Kp=0.2, Ki=0.15, Kr=0.05, b=0.4, ramp=1e6)


@pytest.mark.parametrize(
    ("loop", "sign", "angle", "rate", "actuator"),
    [
        (search.PITCH, -1.0, "theta", "q", "elevator"),
        (search.ROLL, 1.0, "phi", "p", "aileron"),
    ],
)
def test_a_closed_attitude_loop_is_the_law_that_is_flown(plant, loop, sign, angle, rate, actuator):
    law = attitude_loop(T, GAINS, FAR, sign)
    expected, commands = attitude_flown(plant, law, angle, rate, actuator, 1.0)
    found = stepped(search.closed(plant, loop, GAINS, "reference"), "reference", 1.0, 600)
    assert found[:, : len(OUTPUTS)] == pytest.approx(expected, abs=1e-9)
    error, peak = search.tracked(
        plant,
        loop,
        loop.required.size,
        600 * T,
        1e6,
        FAR,
        [np.array([x]) for x in (GAINS.Kp, GAINS.Ki, GAINS.Kr)],
        np.array([GAINS.b]),
    )
    assert error[:, 0] / loop.required.size + 1.0 == pytest.approx(
        expected[:, OUTPUTS.index(angle)], abs=1e-9
    )
    assert peak[0] / loop.required.size == pytest.approx(np.abs(commands).max(), rel=1e-9)


@pytest.mark.parametrize("Ki", [0.15, 90.0])  # at most half of the excess leaves the integral
def test_a_step_that_reaches_a_limit_is_the_law_that_is_flown(plant, Ki):
    size, room = search.PITCH.required.size, (-0.3, 0.2)
    law = attitude_loop(T, dataclasses.replace(GAINS, Ki=Ki), room, -1.0)
    flown, commands = attitude_flown(plant, law, "theta", "q", "elevator", size)
    gains = [np.array([x]) for x in (GAINS.Kp, Ki, GAINS.Kr)]
    b = np.array([GAINS.b])
    error, peak = search.tracked(plant, search.PITCH, size, 600 * T, 1e6, room, gains, b)
    assert min(commands) == room[0]
    assert peak[0] > 0.3
    assert error[:, 0] + size == pytest.approx(flown[:, OUTPUTS.index("theta")], abs=1e-9)


def test_a_closed_speed_loop_is_the_law_that_is_flown(plant):
    gains = SpeedGains(Kp=0.04, Ki=0.002, Kd=-0.02, Tf=0.5, b=1.0, ramp=1e6, Kc=0.004)
    law, state, climb = SpeedLoop(T, gains, FAR), SpeedLoop.START, 0.0

    def fly_law(k, y):
        nonlocal state, climb
        target, hdot_cmd = (2.0, 3.0) if k else (0.0, 0.0)
        command, _, state = law.sample(state, y["vc"], climb, target, 0.0, 0.0, False)
        climb = law.follow(climb, hdot_cmd)
        return command

    expected = law_flown(plant, "throttle", fly_law, 1200)
    closed = outer.with_speed(plant, gains)
    u = np.zeros((1200, len(closed.inputs)))
    u[1:, closed.inputs.index("vc_cmd")] = 2.0
    u[1:, closed.inputs.index("hdot_cmd")] = 3.0
    found = fly(closed, u)
    # the filter of the acceleration starts with the first sample
    assert found[:, : len(OUTPUTS)] == pytest.approx(expected, abs=2e-3)


def test_a_closed_yaw_damper_is_the_law_that_is_flown(plant):
    gains = YawGains(K=0.05, tau=2.0, Kp=0.01, Ki=0.005, Kroll=-0.004, Kbank=-0.003)
    law, state = YawLoop(T, gains, FAR), YawLoop.START
    # small: the law has the sine of the bank
    kick = np.where(np.arange(600) < 60, 0.001, 0.0)

    def fly_law(k, y):
        nonlocal state
        command, state = law.sample(state, y["r"], False, y["beta"], y["p"], y["phi"])
        return command + kick[k]

    expected = law_flown(plant, "rudder", fly_law, 600)
    closed = outer.damped(plant, gains)
    u = np.zeros((600, len(closed.inputs)))
    u[:, closed.inputs.index("rudder")] = kick
    assert fly(closed, u)[:, : len(OUTPUTS)] == pytest.approx(expected, abs=1e-9)


def test_a_closed_altitude_loop_is_the_law_that_is_flown(plant):
    gains = AltitudeGains(Kh=0.15, Kp=0.05, Ki=0.04, hdot_max=1e6)
    held = search.closed(plant, search.PITCH, GAINS, "theta_cmd")
    law, state = AltitudeLoop(T, gains, None, -1e6, 1e6), AltitudeLoop.START
    nudge = np.where(np.arange(1200) < 120, 0.5, 0.0)

    def fly_law(k, y):
        nonlocal state
        found, error = law.error(state, y["h"], (0.0, 0.0))
        command, pid = law.climb(state.law, law.climb_rate(error), y["hdot"], 0.0)
        state = AltitudeState(found, pid)
        return command + nudge[k]

    expected = law_flown(held, "theta_cmd", fly_law, 1200)
    # the same disturbance at the elevator's reference: 0 without it
    assert np.abs(expected[:, OUTPUTS.index("h")]).max() > 1.0
    closed = outer.with_altitude(held, gains)
    assert "theta_cmd" not in closed.inputs
    column = held.column("theta_cmd")
    x, y = np.zeros(len(closed.A)), []
    for k in range(1200):
        y.append(closed.C @ x)
        x = closed.A @ x
        x[: len(column)] += column * nudge[k]
    assert np.array(y)[:, : len(OUTPUTS)] == pytest.approx(expected[:, : len(OUTPUTS)], abs=1e-9)


def test_a_slower_plant_holds_its_inputs(plant):
    n = 6
    u = np.repeat(np.random.default_rng(2).normal(0.0, 0.02, (40, 4)), n, axis=0)
    assert fly(plant.slower(n), u[::n]) == pytest.approx(fly(plant, u)[::n], abs=1e-9)


def test_settling_is_the_last_time_outside():
    error = np.array([[2.0, 0.1, 2.0], [0.5, 0.1, 2.0], [2.0, 0.1, 2.0], [0.5, 0.1, 2.0]])
    assert search.settled(error, 1.0, 0.5).tolist() == [1.5, 0.0, np.inf]


def test_the_quality_of_a_step_is_that_of_python_control():
    t = np.arange(0.0, 40.0, 0.01)
    system = control.tf([1.0], [1.0, 0.8, 1.0])  # damping 0.4
    y = control.step_response(system, t).outputs
    info = control.step_info(y, T=t, yfinal=1.0, SettlingTimeThreshold=0.02)
    settling, overshoot, steady_error = search.step_quality((y - 1.0)[:, None], 0.02, 0.01)
    assert settling[0] == pytest.approx(info["SettlingTime"], abs=1e-9)
    assert 100.0 * overshoot[0] == pytest.approx(info["Overshoot"], abs=1e-9)
    # the envelope of the oscillation 5 s before the end
    assert 0.0 < steady_error[0] < np.exp(-0.4 * 34.9) / np.sqrt(1 - 0.4**2)
