"""The sampled PI-D law, alone and as a block."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope, StepSource
from scipy.signal import lfilter

from pathsim_jsbsim_blocks import DiscretePID
from pathsim_jsbsim_blocks.control.pid import PID, PIDState

pytestmark = pytest.mark.matrix

T = 1 / 120


def run(pid, r, y, rate=None, state=PID.START, **signals):
    """Outputs and the last state of a law over whole signals."""
    rate = np.zeros(len(r)) if rate is None else rate
    out = []
    for k in range(len(r)):
        u, state = pid.sample(
            state,
            float(r[k]),
            float(y[k]),
            float(rate[k]),
            **{name: s[k] for name, s in signals.items()},
        )
        out.append(u)
    return np.array(out), state


def by_transfer_functions(r, y, rate, Kp, Ki, Kd, Kr, b, Tf):
    """The same law as a sum of scipy's discrete transfer functions, for signals that start at 0.

    Forward Euler for the integral; the derivative is the zero-order-hold equivalent of s/(1 + s Tf)
    """
    pole = math.exp(-T / Tf) if Tf else 0.0
    integral = lfilter([0.0, Ki * T], [1.0, -1.0], r - y)
    derivative = lfilter([(1 - pole) / T, -(1 - pole) / T], [1.0, -pole], y)
    return Kp * (b * r - y) + integral - Kd * derivative - Kr * rate


@pytest.mark.parametrize("Tf", [0.0, 0.02, 0.5])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_unsaturated_law_is_its_transfer_function(Tf, sign):
    rng = np.random.default_rng(4)
    r, y, rate = np.cumsum(rng.normal(size=(3, 2000)), axis=1)
    r[0] = y[0] = rate[0] = 0.0
    gains = {"Kp": 0.7, "Ki": 0.4, "Kd": 0.05, "Kr": 0.3}
    gains = {name: sign * gain for name, gain in gains.items()} | {"b": 0.6, "Tf": Tf}
    u, _ = run(PID(T, **gains), r, y, rate)
    # rounding: sums of 2000 numbers of size 1e2, divided by T in the derivative
    assert np.max(np.abs(u - by_transfer_functions(r, y, rate, **gains))) < 1e-10


@pytest.mark.parametrize("b", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("carry", [False, True])
def test_a_pushed_reference_acts_at_full_weight(b, carry):
    # r moves from 3 to 1: by Kp b (1 - 3) by itself, and by Kp (1 - b) (1 - 3) in the integral
    pid = PID(T, Kp=0.5, Ki=0.3, b=b, carry=carry)
    _, state = run(pid, np.full(9, 3.0), np.zeros(9), r_last=np.full(9, 3.0))
    expected, _ = pid.sample(state, 3.0, 0.0, r_last=3.0)
    u, _ = pid.sample(state, 1.0, 0.0, r_last=3.0, push=-2.0)
    assert u == pytest.approx(expected - 0.5 * 2.0, abs=1e-15)


@pytest.mark.parametrize("size", [1e-2, 1.0, 1e2, 1e4, 1e8])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_no_wind_up_for_any_step_size(size, sign):
    n = 2400
    r = np.concatenate([np.full(n, size), np.full(n, -1e-6 * size)])
    y = np.zeros(2 * n)
    r[0] = 0.0
    limits = {"low": -1e-3, "high": 1e-3}
    gains = {"Kp": sign * 0.5, "Ki": sign * 0.5}
    u, _ = run(PID(T, **gains, **limits), r, y)
    assert np.all(u[240:n] == sign * 1e-3)  # pinned while the demand is on
    assert abs(u[n]) < 1e-3 or u[n] * sign < 0  # and free with the first sample after it
    plain, _ = run(PID(T, **gains, **limits, Tt=1e12), r, y)
    assert np.all(plain[n:] == sign * 1e-3)  # without back-calculation: pinned over 20 s more


def test_shortfall_of_the_actuator_unwinds_the_integral():
    pid = PID(T, Kp=0.1, Ki=0.1)
    u, state, short = 0.0, PID.START, 0.0
    for _ in range(2400):
        u, state = pid.sample(state, 10.0, 0.0, 0.0, short)
        short = u - min(u, 0.2)  # the actuator stops at 0.2
    # at rest the back-calculation balances Ki e: short = Ki Tt e = 1, the sample delay shifts it
    # by no more than one sample's worth
    assert short == pytest.approx(1.0, rel=0.02)
    u, _ = pid.sample(state, -1e-3, 0.0, 0.0, short)
    assert u < 0.25


def test_engagement_goes_on_from_the_output_held():
    pid = PID(T, Kp=0.3, Ki=0.2, Kd=0.1, Kr=0.4, b=0.5, Tf=0.1)
    rng = np.random.default_rng(7)
    y = 5.0 + 0.01 * np.cumsum(rng.normal(size=500))
    rate = np.gradient(y, T)
    off = np.zeros(500)
    off[:100] = off[200:300] = 1
    track = np.where(np.arange(500) < 100, 0.25, 0.0)
    u, _ = run(pid, np.full(500, 9.0), y, rate, off=off, track=track)
    assert np.all(u[:100] == 0.25)
    assert abs(u[100] - u[99]) < 1e-12
    assert np.all(u[200:300] == u[199])
    assert abs(u[300] - u[299]) < 1e-12
    assert np.ptp(u[100:200]) > 0.1  # it does act


def test_track_moves_the_output_while_off():
    pid = PID(T, Kp=1.0, Ki=1.0)
    state = pid.holding(0.5)
    u = []
    for track in (0.0, 0.1, -0.2):
        out, state = pid.sample(state, 0.0, 0.0, off=True, track=track)
        u.append(out)
    assert u == pytest.approx([0.5, 0.6, 0.3], abs=1e-15)
    engaged, state = pid.sample(state, 0.0, 0.0, track=-0.2)
    released, _ = pid.sample(state, 0.0, 0.0, off=True, track=-0.2)
    assert engaged == pytest.approx(0.3, abs=1e-15)
    assert released == pytest.approx(0.3, abs=1e-15)


def test_nan_is_passed_on_and_not_hidden_by_the_limits():
    u, _ = PID(T, Kp=1.0, low=-1.0, high=1.0).sample(PID.START, 0.0, math.nan)
    assert math.isnan(u)


def test_block_is_the_law():
    # in a loop with an integrator
    pid, step = DiscretePID(Kp=2.0, Ki=3.0, low=-5.0, high=1.2), StepSource(1.0, 0.1)
    plant, scope = Integrator(0.0), Scope()
    wires = [
        Connection(step, pid["r"]),
        Connection(plant, pid["y"], scope[1]),
        Connection(pid, plant, scope[0]),
    ]
    sim = Simulation([step, pid, plant, scope], wires, dt=T, log=False)
    sim.run(5.0)
    t, (u, y) = scope.read()
    law = PID(T, Kp=2.0, Ki=3.0, low=-5.0, high=1.2)
    expected, _ = run(law, np.where(t > 0.1 - 1e-9, 1.0, 0.0), y)
    assert len(t) == 601
    assert np.array_equal(u, expected)
    assert u.max() == 1.2
    assert y[-1] == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("gains", [{"Kp": 2.0}, {"Kp": 2.0, "Ki": 0.5}, {"Kp": 2.0, "b": 0.5}])
def test_the_block_starts_as_the_textbook_says(gains):
    # a constant error of 1 - 0.25: proportional part at once, integral from 0 on
    block = DiscretePID(**gains, low=-10.0, high=10.0, T=T)
    out = [block.law([1.0, 0.25, 0, 0, 0, 0, 0], state := block.initial_state())]
    for _ in range(240):
        out.append(block.law([1.0, 0.25, 0, 0, 0, 0, 0], out[-1][1]))
    u = np.array([y[0] for y, _ in out])
    k = np.arange(len(u))
    expected = 2.0 * (gains.get("b", 1.0) - 0.25) + gains.get("Ki", 0.0) * 0.75 * T * k
    assert state == block.initial_state()
    # rounding of a sum over 240 samples
    assert np.abs(u - expected).max() < 1e-12


def test_without_integral_action_what_was_held_fades():
    pid = PID(T, Kp=2.0, Kd=0.3, Kr=0.4, Te=0.3)
    u, state = pid.sample(pid.holding(0.7), 0.0, 1.0, 0.5, off=True)
    assert u == 0.7
    course = []
    for _ in range(int(3.0 / T)):
        u, state = pid.sample(state, 1.0, 1.01, 0.5)
        course.append(u)
    # neither the reference nor the rates make a jump
    assert course[0] == pytest.approx(0.7, abs=1e-12)
    # 10 time constants later only the law without an integral remains
    assert course[-1] == pytest.approx(2.0 * (1.0 - 1.01) - 0.4 * 0.5, abs=1e-4)


@pytest.mark.parametrize(
    "gains", [{"Ki": 0.2, "Kd": 0.7}, {"Kd": 0.7, "Tf": 0.1}, {"Ki": 0.2, "Kd": 0.7, "Tf": 0.1}]
)
@pytest.mark.parametrize("state", [PID.START, PID.FROM_REST, PID.holding(0.25)])
def test_at_rest_the_output_stays_where_it_begins(gains, state):
    # nothing is known of y before the first sample, so its rate is 0 there
    u, _ = run(PID(T, Kp=0.4, Te=1e9, **gains), np.full(200, 3.0), np.full(200, 3.0), state=state)
    assert u == pytest.approx(state.u, abs=1e-9)


def test_the_integral_is_led_back_in_two_samples_at_the_quickest():
    # a proportional part of almost nothing: Kp / Ki would be shorter than a sample
    pid = PID(T, Kp=1e-9, Ki=1.0, high=1.0)
    _, state = pid.sample(PIDState(True, True, integral=3.0), 0.0, 0.0)
    assert state.integral == pytest.approx(2.0, abs=1e-6)  # half of the 2 above the limit


def test_gains_not_given_are_0():
    for state in (PID.START, PID.FROM_REST, PID.holding(0.0)):
        u, _ = run(PID(T), np.ones(50), np.full(50, 3.0), np.ones(50), state)
        assert not u.any()
    u, _ = run(PID(T, Ki=0.6), np.full(50, 3.0), np.ones(50), np.ones(50))
    assert u == pytest.approx(0.6 * 2.0 * T * np.arange(50), abs=1e-12)
