"""Margins of loops against python-control and closed forms."""

import control
import numpy as np
import pytest

from pathsim_jsbsim_blocks.design.margins import EXTRA_DELAY, margins

OMEGA = np.geomspace(0.005, 500.0, 4000)

LOOPS = {
    "third order": ([4.0], [1.0, 3.0, 3.0, 1.0]),
    "integrator with lags": ([3.0], [0.02, 0.3, 1.0, 0.0]),
    # unstable without the loop: the gain may also fall too low
    "unstable": ([6.0, 12.0, 6.0], [0.001, 0.11, 0.89, -1.0, 0.0]),
}


@pytest.mark.parametrize("name", LOOPS)
def test_margins_are_those_of_python_control(name):
    loop = control.tf(*LOOPS[name])
    found = margins(OMEGA, loop(1j * OMEGA)[None])
    gain, phase, _, _, crossover, _ = control.stability_margins(loop, returnall=True)
    if len(gain):
        assert found.gain[0] == pytest.approx(np.abs(20 * np.log10(gain)).min(), abs=0.05)
    else:
        assert found.gain[0] == np.inf
    assert found.phase[0] == pytest.approx(np.abs(phase).min(), abs=0.1)
    assert found.crossover[0] == pytest.approx(crossover.max(), rel=1e-3)


def test_sensitivity_of_a_delayed_integrator():
    # |1 + L| is least near the crossover; a delay of 50 ms turns L by 0.05 omega
    a, b = 2.0, 5.0
    L = np.array([a / (1j * OMEGA), b / (1j * OMEGA)])
    found = margins(OMEGA, L)
    assert found.Ms == pytest.approx([1.0, 1.0], abs=1e-3)
    for i, gain in enumerate((a, b)):
        late = gain * np.exp(-1j * OMEGA * EXTRA_DELAY) / (1j * OMEGA)
        assert found.Ms_delayed[i] == pytest.approx(np.max(1 / np.abs(1 + late)))
        assert found.crossover[i] == pytest.approx(gain, rel=1e-3)
        assert found.phase[i] == pytest.approx(90.0, abs=0.01)


def test_a_loop_without_crossover_has_no_margins():
    found = margins(OMEGA, np.full((1, len(OMEGA)), 0.1 + 0j))
    assert (found.crossover[0], found.gain[0], found.phase[0]) == (0.0, np.inf, np.inf)
