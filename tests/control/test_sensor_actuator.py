"""Sensor and actuator against scipy's exact simulations, statistics, limits, bad input."""

import math

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope, Source
from scipy.integrate import solve_ivp
from scipy.signal import lsim

from pathsim_jsbsim_blocks import Actuator, DiscretePID, ParameterError, Sensor

T = 1 / 50


def record(block, signal, duration=4.0, dt=T, **options):
    source, scope = Source(signal), Scope()
    outputs = range(len(block.output_port_labels))
    sim = Simulation(
        [source, block, scope],
        [Connection(source, block), *(Connection(block[i], scope[i]) for i in outputs)],
        dt=dt,
        log=False,
        **options,
    )
    sim.run(duration)
    time, data = scope.read()
    return time, data


def wave(t):
    return 1.3 + 0.6 * math.sin(3.0 * t) - 0.2 * math.cos(11.0 * t)


def test_a_sensor_without_parameters_is_a_sampler():
    time, (y,) = record(Sensor(T=T), wave)
    assert np.array_equal(y, [wave(t) for t in time])
    time, (y,) = record(Sensor(T=T), wave, dt=T / 4)
    assert y == pytest.approx([wave(T * int((t + 1e-9) / T)) for t in time], abs=1e-12)


@pytest.mark.parametrize("lag", [0.001, 0.1, 5.0])
def test_the_lag_is_that_of_scipy_between_samples_joined_by_straight_lines(lag):
    time, (y,) = record(Sensor(lag=lag, T=T), wave)
    u = np.array([wave(t) for t in time])
    # lsim starts at x0 and takes straight lines between the samples
    _, expected, _ = lsim(([1.0], [lag, 1.0]), u, time, X0=[lag * u[0]])
    assert y == pytest.approx(expected, abs=1e-11)


def test_bias_and_quantisation():
    _, (y,) = record(Sensor(bias=0.04, quantum=0.05, T=T), wave)
    _, (x,) = record(Sensor(T=T), wave)
    assert y == pytest.approx(0.05 * np.rint((x + 0.04) / 0.05), abs=1e-12)
    assert abs(y - x - 0.04).max() <= 0.025 + 1e-12
    assert len(set(y)) < 40 < len(set(x))


def test_the_noise_is_white_normal_and_its_own():
    still = lambda t: 2.0  # noqa: E731
    sensor = Sensor(noise=0.3, seed=4, T=T)
    _, (y,) = record(sensor, still, duration=60.0)
    sensor.reset()
    _, (again,) = record(sensor, still, duration=60.0)
    _, (other,) = record(Sensor(noise=0.3, seed=5, T=T), still, duration=60.0)
    assert np.array_equal(y, again)
    n, x, z = len(y), (y - 2.0) / 0.3, (other - 2.0) / 0.3
    assert n == 3001
    # the draws of NumPy in their order, 1024 at once: a seed keeps its noise between versions
    numbers = [np.random.default_rng([4, stretch]).standard_normal(1024) for stretch in range(3)]
    assert x == pytest.approx(np.concatenate(numbers)[:n], abs=1e-12)
    # three standard errors
    assert abs(x.mean()) < 3 / math.sqrt(n)
    assert abs(x.var() - 1.0) < 3 * math.sqrt(2 / n)
    assert abs((x**4).mean() - 3.0) < 3 * math.sqrt(96 / n)
    for lag in (1, 2, 10, 1024):
        assert abs((x[lag:] * x[:-lag]).mean()) < 3 / math.sqrt(n - lag)
    assert abs((x * z).mean()) < 3 / math.sqrt(n)


def test_what_is_not_finite_is_handed_on():
    sensor = Sensor(quantum=0.1)
    assert math.isnan(sensor.law([math.nan], (0,))[0][0])
    assert sensor.law([math.inf], (0,))[0][0] == math.inf
    # steps that are too many to be counted are too small to matter
    assert Sensor(quantum=1e-310).law([1.0], (0,))[0] == [1.0]


@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 2.5])
def test_an_actuator_is_the_second_order_system_of_scipy(damping):
    block = Actuator(frequency=12.0, damping=damping, low=-9.0, high=9.0, initial=0.25, T=T)
    time, (y, rate, sat) = record(block, wave)
    # each command is held over the period that follows it
    held = [wave(t) for t in time]
    motion = [[0, 1], [-144.0, -24.0 * damping]], [[0], [144.0]], np.eye(2), np.zeros((2, 1))
    _, expected, _ = lsim(motion, held, time, X0=[0.25, 0.0], interp=False)
    assert not sat.any()
    both = np.array([y, rate]).T
    assert both == pytest.approx(expected, abs=1e-10)


def limited(duration, omega, zeta, max_rate):
    """Step response with a limit of rate: scipy from event to event, every 0.01 s."""

    def acceleration(x):
        return omega**2 * (1.0 - x[0]) - 2 * zeta * omega * x[1]

    def reached(t, x):
        return x[1] - max_rate

    def left(t, x):
        return acceleration(x)

    def free(t, x):
        return [x[1], acceleration(x)]

    def steady(t, x):
        return [max_rate, 0.0]

    reached.terminal = left.terminal = True
    reached.direction, left.direction = 1.0, -1.0
    t, x, parts = 0.0, [0.0, 0.0], []
    for motion, event in ((free, reached), (steady, left), (free, None)):
        part = solve_ivp(
            motion, (t, duration), x, events=event, rtol=1e-10, atol=1e-12, dense_output=True
        )
        t, x = part.t[-1], part.y[:, -1]
        parts.append((t, part.sol))
    assert t == duration
    times = np.arange(round(duration * 100)) / 100
    return np.array([next(sol(t)[0] for end, sol in parts if t <= end) for t in times])


def test_the_rate_limit_converges_to_the_continuous_one():
    errors = []
    exact = limited(1.0, 20.0, 0.7, 2.5)
    for n in (1, 4, 16):
        block = Actuator(
            frequency=20.0, damping=0.7, max_rate=2.5, low=-2.0, high=2.0, T=1 / (100 * n)
        )
        _, (y, rate, _) = record(block, lambda t: 1.0, duration=1.0, dt=1 / (100 * n))
        assert abs(rate).max() == 2.5
        assert np.diff(y).max() <= 2.5 / (100 * n) + 1e-15
        errors.append(abs(y[::n][: len(exact)] - exact).max())
    # 1 % of the step at 100 Hz; proportional to T, at least
    assert errors[0] < 0.01
    assert errors[1] < errors[0] / 3
    assert errors[2] < errors[1] / 3


def test_the_position_limits_hold_and_say_so():
    time, (y, rate, sat) = record(
        Actuator(frequency=15.0, damping=0.3, low=-0.4, high=1.0, T=T),
        lambda t: 1.5 if t < 2.0 else -1.0,
    )
    assert y.max() == 1.0
    assert y.min() == -0.4
    assert abs(rate[y == 1.0]).max() == 0.0
    assert sat[abs(time - 1.0).argmin()] == pytest.approx(0.5)
    assert sat[abs(time - 3.0).argmin()] == pytest.approx(-0.6)
    # it leaves the stop at once: the first sample after the command's
    leaves = np.flatnonzero((time >= 2.0 - 1e-9) & (y < 1.0))[0]
    assert time[leaves] == pytest.approx(2.0 + T)


@pytest.mark.parametrize("first", [0, 1])
def test_sat_to_a_controller_keeps_its_integral_from_winding_up(first):
    overshoot = {}
    for wired in (False, True):
        pid = DiscretePID(Kp=2.0, Ki=1.0, low=-5.0, high=5.0, T=T)
        block = Actuator(low=-0.2, high=0.2, max_rate=1.0, T=T)
        plant, reference, scope = Integrator(0.0), Constant(1.0), Scope()
        wires = [
            Connection(reference, pid["r"]),
            Connection(plant, pid["y"], scope),
            Connection(pid, block["u"]),
            Connection(block["y"], plant),
            *([Connection(block["sat"], pid["sat"])] if wired else []),
        ]
        blocks = [[pid, block], [block, pid]][first]
        sim = Simulation([*blocks, plant, reference, scope], wires, dt=T, log=False)
        sim.run(20.0)
        y = scope.read()[1][0]
        assert y[-1] == pytest.approx(1.0, abs=1e-3)
        overshoot[wired] = y.max() - 1.0
    # the integral of the error over the 5 s at the stop, or what back-calculation leaves of it
    assert overshoot[False] > 0.5
    assert overshoot[True] < 0.1


@pytest.mark.parametrize("max_rate", [0.5, math.inf])
def test_a_limit_moved_past_the_position_draws_it_back_within_the_rate(max_rate):
    block, source, scope = Actuator(max_rate=max_rate, T=T), Source(lambda t: 1.0), Scope()
    sim = Simulation(
        [source, block, scope],
        [Connection(source, block), Connection(block["y"], scope)],
        dt=T,
        log=False,
    )
    sim.run(4.0)
    block.set(high=0.3)
    sim.run(4.0)
    y = scope.read()[1][0]
    assert y[200] == pytest.approx(1.0)
    assert y[-1] == pytest.approx(0.3)
    # 0.7 in one sample would be a rate of 35
    assert np.diff(y).min() >= -min(max_rate, 15.0) * T - 1e-12


@pytest.mark.parametrize(
    ("make", "parameter"),
    [
        (lambda: Sensor(bias=math.nan), "bias"),
        (lambda: Sensor(noise=-0.1), "noise"),
        (lambda: Sensor(lag=-1.0), "lag"),
        (lambda: Sensor(quantum=-1.0), "quantum"),
        (lambda: Sensor(seed=1.5), "seed"),
        (lambda: Actuator(frequency=0.0), "frequency"),
        (lambda: Actuator(frequency=1e50), "frequency"),
        (lambda: Actuator(damping=-0.1), "damping"),
        (lambda: Actuator(max_rate=0.0), "max_rate"),
        (lambda: Actuator(max_rate=math.nan), "max_rate"),
        (lambda: Actuator(high="up"), "high"),
        (lambda: DiscretePID(Kp="high"), "Kp"),
        (lambda: DiscretePID(Ki=math.nan), "Ki"),
        (lambda: DiscretePID(Tf=-1.0), "Tf"),
        (lambda: DiscretePID(Tt=0.0), "Tt"),
        (lambda: DiscretePID(Te=0.0), "Te"),
    ],
)
def test_bad_parameters_are_refused_by_name(make, parameter):
    with pytest.raises(ParameterError) as error:
        make()
    assert error.value.parameter == parameter
