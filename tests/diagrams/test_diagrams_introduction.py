"""The introductory diagrams against analytic solutions and scipy's DOP853."""

import numpy as np
from scipy.integrate import solve_ivp
from test_diagrams_flight import flown

from pathsim_jsbsim_blocks.plots import signal


def test_damped_oscillator():
    # RK4 at 0.01 s reaches 1e-8
    module = flown("damped_oscillator")
    time, x = signal(module.scope, "position x")
    _, v = signal(module.scope, "velocity v")
    wn, zeta = 2.0, 0.25
    wd = wn * np.sqrt(1 - zeta**2)
    decay = np.exp(-zeta * wn * time)
    exact_x = decay * (np.cos(wd * time) + zeta * wn / wd * np.sin(wd * time))
    exact_v = -decay * wn**2 / wd * np.sin(wd * time)
    # swapped labels would show here: the two differ by up to 1.3
    assert np.abs(x - exact_x).max() < 1e-8
    assert np.abs(v - exact_v).max() < 1e-8
    # the values in the docstring: the period, and the decay from swing to swing
    assert abs(2 * np.pi / wd - 3.245) < 5e-4
    assert abs(np.exp(-zeta * np.pi / np.sqrt(1 - zeta**2)) - 0.4443) < 5e-5


def test_step_response():
    module = flown("step_response")
    time, y = signal(module.scope, "response y")
    exact = 1 - np.exp(-time / 2.0)
    assert np.abs(y - exact).max() < 1e-10
    assert np.abs(signal(module.scope, "analytic")[1] - exact).max() < 1e-15
    assert np.array_equal(signal(module.scope, "step u")[1], np.ones_like(time))


def test_van_der_pol():
    # a fixed step of 0.01 s reaches 5e-6 of the amplitude of 2
    module = flown("van_der_pol")
    time, (x, v) = module.scope.read()
    exact = solve_ivp(
        lambda t, s: [s[1], 1.5 * (1 - s[0] ** 2) * s[1] - s[0]],
        (0, time[-1]),
        [2.0, 0.5],
        method="DOP853",
        t_eval=time,
        rtol=1e-13,
        atol=1e-13,
    ).y
    assert np.abs(x - exact[0]).max() < 5e-6
    assert np.abs(v - exact[1]).max() < 5e-6
