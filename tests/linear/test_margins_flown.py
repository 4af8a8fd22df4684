"""Margins of loops against JSBSim: a sine at the crossover, flown through the closed loop."""

import math

import numpy as np
import pytest

from pathsim_jsbsim_blocks import Aircraft, HeadingHold, PitchHold, RollHold
from pathsim_jsbsim_blocks.linear import margins

CONDITIONS = {
    "c172p": dict(altitude=5000, speed=90, heading=90),
    "737": dict(altitude=5000, speed=260, heading=90, gear=0.0),
    "f16": dict(altitude=10000, speed=300, heading=90, gear=0.0),
}
# where the sine is added, and its height: of full travel, deg; below half a degree of bank, where the
# hold follows the bank of straight flight
LOOPS = {PitchHold: ("elevator", 2e-3), RollHold: ("aileron", 2e-3), HeadingHold: ("psi", 0.02)}
T = 1 / 120


def flown(plane, hold, port, height, omega):
    """L at a frequency: minus what comes back over what goes in, at the port that has the sine."""
    period = round(2 * math.pi / (omega * T))
    count = 4
    # the transient has gone, the phugoid hardly moves a quick loop
    start = math.ceil(40.0 / (period * T)) * period
    inputs, outputs = plane.input_port_labels, plane.output_port_labels
    wires = [(outputs[x], i) for x, i in hold.input_port_labels.items() if x in outputs]
    (command,) = hold.commands
    y, u = plane.outputs.to_array().tolist(), [0.0] * len(inputs)
    state = hold.initial_state()
    seen = np.empty((start + count * period, 2))
    for k in range(len(seen)):
        sine = height * math.sin(2 * math.pi * k / period)
        measured = [0.0] * len(hold.input_port_labels)
        for source, target in wires:
            measured[target] = y[source]
        if port in hold.input_port_labels:
            back = y[outputs[port]]
            measured[hold.input_port_labels[port]] = into = back + sine
            commands, state = hold.law(measured, state)
            u[inputs[command]] = commands[0]
        else:
            commands, state = hold.law(measured, state)
            back, into = commands[0], commands[0] + sine
            u[inputs[command]] = into
        seen[k] = back, into
        y = plane.advance(k + 1, u)
    last = seen[start:]
    # what drifts slowly is straight over some periods
    last = last - np.linspace(0, 1, len(last))[:, None] * (last[-1] - last[-1 - period]) * count
    back, into = np.exp(-2j * math.pi * np.arange(len(last)) / period) @ last
    return 2 * math.pi / (period * T), -back / into


# the f16 is not quite linear, which its model warns of
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.long
@pytest.mark.parametrize("Hold", LOOPS)
@pytest.mark.parametrize("aircraft", CONDITIONS)
def test_a_loop_at_its_crossover_is_as_flown(aircraft, Hold):
    plane, hold = Aircraft(aircraft, **CONDITIONS[aircraft]), Hold(aircraft)
    loop = margins(plane, hold)
    omega, L = flown(plane, hold, *LOOPS[Hold], loop.crossover)
    predicted = np.interp(omega, loop.omega, loop.response)
    ratio = L / predicted
    assert abs(20 * np.log10(abs(ratio))) < 0.2
    assert abs(np.degrees(np.angle(ratio))) < 0.5
