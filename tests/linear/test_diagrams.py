"""Diagrams linearise: PathSim's `to_statespace` with aircraft and sampled laws in it."""

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, StepSource
from pathsim.exceptions import LinearizationError
from scipy import signal

from pathsim_jsbsim_blocks import Actuator, Aircraft, DiscretePID, PitchHold

GAINS = {"Kp": 0.064, "Ki": 0.063, "Kr": 0.0025, "b": 0.52, "ramp": 1e6}


def pitch_loop():
    """A c172p with pitch hold and a step of its reference."""
    aircraft = Aircraft("c172p", altitude=5000, speed=90)
    hold = PitchHold(gains=GAINS)
    source = StepSource([0.0, 0.5], [0.0, 1.0])
    scope = Scope()
    sim = Simulation(
        [aircraft, hold, source, scope],
        [
            Connection(source, hold["theta_ref"]),
            Connection(aircraft["theta"], hold["theta"], scope),
            Connection(aircraft["q"], hold["q"]),
            Connection(hold["elevator"], aircraft["elevator"]),
        ],
        dt=1 / 120,
        log=False,
    )
    return sim, aircraft, hold, scope


def test_the_closed_pitch_loop_predicts_its_step():
    sim, aircraft, hold, scope = pitch_loop()
    system = sim.to_statespace(inputs=[hold["theta_ref"]], outputs=[aircraft["theta"]])
    sim.run(11.0)
    time, (theta,) = scope.read()
    after = time > 1.0 - 1e-6
    matrices = system.A, system.B, system.C, system.D
    _, predicted = signal.step(matrices, T=np.arange(after.sum()) / 120)
    assert np.ptp(theta) > 0.45
    assert np.abs(theta[after] - theta[0] - 0.5 * predicted).max() < 0.01 * 0.5


def test_the_loop_opens_at_a_port():
    # cut at the elevator, the loop gain is minus the law times the aircraft
    sim, aircraft, hold, _ = pitch_loop()
    opened = sim.to_statespace(inputs=[aircraft["elevator"]], outputs=[hold["elevator"]])
    model = aircraft.linear_model(inputs=["elevator"], outputs=["theta", "q"])
    for omega in (0.5, 2.0, 6.0):
        s = 1j * omega
        law = np.array([GAINS["Kp"] + GAINS["Ki"] / s, GAINS["Kr"]])
        wanted = law @ model.frequency_response([omega])[0, :, 0]
        gain = opened.C @ np.linalg.solve(s * np.eye(len(opened.A)) - opened.A, opened.B)
        # a lag in place of the delay, and an integral that is a sample late
        assert (gain + opened.D).item() == pytest.approx(wanted, rel=0.02)


def transfer(block, output, input, omega):
    A, B, C, D = block.to_statespace(0.0)
    i, j = block.output_port_labels[output], block.input_port_labels[input]
    s = 1j * omega
    return (C[i] @ np.linalg.solve(s * np.eye(len(A)) - A, B[:, j])) + D[i, j]


@pytest.mark.parametrize("omega", [0.3, 3.0, 15.0])
def test_a_pid_is_its_textbook_transfer_function(omega):
    Kp, Ki, Kd, Kr, b, Tf = 2.0, 1.5, 0.3, 0.7, 0.6, 0.2
    pid = DiscretePID(Kp=Kp, Ki=Ki, Kd=Kd, Kr=Kr, b=b, Tf=Tf, low=-10, high=10)
    s = 1j * omega
    # differences at 120 Hz are late by half a sample
    assert transfer(pid, "u", "r", omega) == pytest.approx(Kp * b + Ki / s, rel=0.07)
    assert transfer(pid, "u", "y", omega) == pytest.approx(
        -(Kp + Ki / s + Kd * s / (Tf * s + 1)), rel=0.07
    )
    assert transfer(pid, "u", "rate", omega) == pytest.approx(-Kr)
    assert transfer(pid, "u", "off", omega) == 0.0


@pytest.mark.parametrize("omega", [1.0, 10.0, 30.0])
def test_an_actuator_is_its_second_order_system(omega):
    frequency, damping = 30.0, 0.7
    actuator = Actuator(frequency=frequency, damping=damping)
    s = 1j * omega
    wanted = frequency**2 / (s**2 + 2 * damping * frequency * s + frequency**2)
    # exact at the samples; Tustin bends the frequency axis, and the output is a sample late
    assert abs(transfer(actuator, "y", "u", omega)) == pytest.approx(abs(wanted), rel=0.02)


def test_a_law_at_its_limit_has_no_slope():
    pid = DiscretePID(Kp=1.0, low=-1, high=1)
    pid.inputs[0] = 5.0
    with pytest.warns(RuntimeWarning, match="at a limit.* u has no effect"):
        _, _, _, D = pid.to_statespace(0.0)
    assert not D.any()


def test_without_a_model_pathsims_own_error_says_why():
    aircraft = Aircraft("c172p", altitude=0, mode="ground")
    constant = Constant(0.0)
    sim = Simulation(
        [aircraft, constant], [Connection(constant, aircraft["elevator"])], dt=1 / 120, log=False
    )
    with pytest.raises(LinearizationError, match="not in steady flight"):
        sim.to_statespace(inputs=[aircraft["elevator"]], outputs=[aircraft["theta"]])
