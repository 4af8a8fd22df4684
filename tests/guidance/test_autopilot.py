"""The autopilot's law: its authority, its state, and inputs without a wire."""

from __future__ import annotations

import numpy as np
import pytest

from pathsim_jsbsim_blocks import Autopilot, PitchHold


@pytest.mark.filterwarnings("ignore:Autopilot.*(increment|far below)")
def test_any_inputs_keep_the_commands_within_their_authority():
    rng = np.random.default_rng(1)
    autopilot = Autopilot(
        "c172p",
        elevator_authority=0.3,
        aileron_authority=(-0.2, 0.4),
        rudder_authority=0.1,
        throttle_authority=(-0.5, 0.25),
    )
    limits = [(-0.3, 0.3), (-0.2, 0.4), (-0.1, 0.1), (-0.5, 0.25)]
    state = autopilot.initial_state()
    n = len(autopilot.input_port_labels)
    for _ in range(5000):
        u = rng.normal(size=n) * 10.0 ** rng.uniform(-2, 3)
        u[14:20] = rng.random(6) < 0.3
        y, state = autopilot.law(u.tolist(), state)
        for (low, high), command in zip(limits, y, strict=False):
            assert low <= command <= high
        assert np.all(np.isfinite(y))


def test_unwired_everything_is_quiet():
    # inputs of 0.0 are what PathSim gives to a port that is not wired
    for block in (Autopilot(), PitchHold()):
        y, state = block.law([0.0] * len(block.input_port_labels), block.initial_state())
        y, _ = block.law([0.0] * len(block.input_port_labels), state)
        assert y == [0.0] * len(y)
