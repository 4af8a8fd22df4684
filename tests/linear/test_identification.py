"""Identification from pulse responses of a system whose matrices are known."""

import numpy as np
import pytest
from scipy.signal import cont2discrete, dlsim

from pathsim_jsbsim_blocks.linear.identification import realise

T = 1 / 120  # s
# an oscillator of 3 rad/s, an aperiodic mode of 2 s, each in one signal and in the other
A = np.array([[0.0, 1.0, 0.0], [-9.0, -1.8, 0.5], [0.0, 0.0, -0.5]])
B = np.array([[0.0], [1.0], [2.0]])
C = np.array([[1.0, 0.0, 0.3], [0.0, 1.0, 0.0]])


@pytest.mark.parametrize("delay", [0, 3])
def test_a_known_system_with_a_delay_and_noise_is_found(delay):
    width, n = 12, 1200
    pulse = np.zeros((n + 1, 1))
    pulse[delay : delay + width] = 1.0
    _, y, _ = dlsim((*cont2discrete((A, B, C, np.zeros((2, 1))), T)[:4], T), pulse)
    # what a flight's round-off leaves before the response
    y += 1e-7 * np.random.default_rng(8).normal(size=y.shape)
    model = realise(y[None, :n], T, width, rigid=[0, 1], engines=[], integrals=[], abrupt=[])
    assert model.latency == [delay]
    poles = np.linalg.eigvals(A)
    assert np.sort_complex(np.linalg.eigvals(model.A)) == pytest.approx(
        np.sort_complex(poles), rel=1e-3
    )
    # its gain at rest
    assert -model.C @ np.linalg.solve(model.A, model.B) + model.D == pytest.approx(
        -C @ np.linalg.solve(A, B), rel=1e-3, abs=1e-4
    )
