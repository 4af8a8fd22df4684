"""The time contract: a block's flight is a plain JSBSim loop's, bit for bit.

The loop is fed with the inputs that the diagram itself recorded at t_k, so the comparison holds
whatever the inputs are: random from sample to sample, or moving all the time.
"""

import math

import numpy as np
import pytest
from pathsim import Connection
from pathsim.blocks import Adder, Amplifier, Constant, Integrator, Scope, Source
from pathsim.solvers import ESDIRK43, RK4, RKBS32, RKCK54, SSPRK22
from plain_jsbsim import FLIGHTS, fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import JSBSimFDM

pytestmark = pytest.mark.matrix

T = 1 / 120
INPUTS = ["fcs/elevator-cmd-norm", "fcs/aileron-cmd-norm", "fcs/rudder-cmd-norm"]
OUTPUTS = [
    "aero/alpha-deg",
    "attitude/theta-deg",
    "attitude/phi-deg",
    "attitude/psi-deg",
    "velocities/q-rad_sec",
    "velocities/p-rad_sec",
    "velocities/vt-fps",
    "position/h-sl-ft",
    "position/lat-geod-deg",
    "simulation/sim-time-sec",
]


def noise(seed, amplitude=0.02):
    """Random from sample to sample, constant between."""
    values = np.random.default_rng(seed).uniform(-amplitude, amplitude, 5000)
    return Source(lambda t: values[math.floor(t / T + 1e-6)])


def sine(frequency, phase, amplitude=0.02):
    return Source(lambda t: amplitude * math.sin(2 * math.pi * frequency * t + phase))


def sines():
    return [sine(0.7, 0.1), sine(1.3, 0.7), sine(0.4, 1.9)]


def block(aircraft="c172p", **more):
    altitude, speed = FLIGHTS[aircraft]
    return JSBSimFDM(
        **{
            "T": T,
            "input_properties": INPUTS,
            "output_properties": OUTPUTS,
            "aircraft_model": aircraft,
            "trim_airspeed": speed,
            "trim_altitude": altitude,
            "gear": 1,
            **more,
        }
    )


def wire(fdm, sources, **more):
    return diagram(fdm, OUTPUTS, dict(zip(INPUTS, sources, strict=True)), inputs=True, **more)


def samples(scope, T=T):
    """Inputs and outputs recorded at the sample instants."""
    time, data = scope.read()
    k = np.round(time / T).astype(int)
    at = np.flatnonzero(np.abs(time - k * T) < 1e-9)
    _, first = np.unique(k[at], return_index=True)
    at = at[first]
    assert np.array_equal(k[at], np.arange(len(at)))
    return data[-3:, at].T, data[:-3, at].T


def loop(u, aircraft="c172p", T=T, substeps=1):
    altitude, speed = FLIGHTS[aircraft]
    return fly(trimmed(aircraft, altitude, speed, T / substeps), INPUTS, u[:-1], OUTPUTS, substeps)


@pytest.mark.parametrize("aircraft", FLIGHTS)
def test_bit_for_bit_at_dt_equal_T(aircraft):
    fdm = block(aircraft)
    sim, scope = wire(fdm, [noise(1), noise(2), noise(3)])
    sim.run(2.0)
    u, y = samples(scope)
    assert len(y) == 241
    assert np.ptp(u, axis=0).min() > 0.03
    assert np.array_equal(y, loop(u, aircraft))


@pytest.mark.parametrize(("aircraft", "parts"), [("c172p", 2), ("737", 4)])
def test_a_step_that_divides_T_and_the_same_after_a_reset(aircraft, parts):
    fdm = block(aircraft)
    sim, scope = wire(fdm, sines(), dt=T / parts)
    sim.run(2.0)
    u, y = samples(scope)
    assert len(y) == 241
    # relative to the largest value of each output: the inputs of both loops are the same floats,
    # recorded at the same instants, so nothing but equality is expected
    assert np.max(np.abs(y - loop(u, aircraft)) / np.abs(y).max(axis=0)) <= 1e-12
    sim.reset()
    sim.run(2.0)
    assert np.array_equal(samples(scope)[1], y)


def test_a_step_of_two_T_keeps_the_clock_and_warns():
    fdm = block()
    sim, scope = wire(fdm, sines(), dt=2 * T)
    with pytest.warns(RuntimeWarning, match="jumps over a sample instant"):
        sim.run(2.0)
    assert fdm.samples == 240
    assert fdm.outputs["simulation/sim-time-sec"] == pytest.approx(2.0, abs=1e-12)
    _, data = scope.read()
    u = np.repeat(data[-3:].T, 2, axis=0)[:-1]
    assert np.array_equal(data[:-3].T, loop(u)[::2])


STATES = {
    "no state": (0, SSPRK22),
    "SSPRK22": (1, SSPRK22),
    "RK4": (1, RK4),
    "RKBS32": (1, RKBS32),
    "RKCK54": (1, RKCK54),
    "ESDIRK43": (1, ESDIRK43),
    "RKBS32 without state": (0, RKBS32),
    "three states": (3, RK4),
}


@pytest.mark.parametrize(("states", "solver"), STATES.values(), ids=STATES)
def test_every_solver(states, solver):
    fdm = block()
    # continuous states driven by the aircraft, so that the stages see its outputs
    integrators = [Integrator(0.0) for _ in range(states)]
    options = {"dt_max": T / 3} if solver in (RKBS32, RKCK54, ESDIRK43) else {}
    wires = [Connection(fdm[1], *integrators)] if states else []
    sim, scope = wire(fdm, sines(), others=integrators, wires=wires, Solver=solver, **options)
    sim.run(0.5)
    u, y = samples(scope)
    assert len(y) == 61
    assert np.max(np.abs(y - loop(u)) / np.abs(y).max(axis=0)) <= 1e-12


def test_two_aircraft_at_two_rates():
    slow_T = T * 4
    fast, slow = block(), block("737", T=slow_T, substeps=4)
    sources, slow_scope, n = sines(), Scope(), len(OUTPUTS)
    wires = [Connection(slow[:n], slow_scope[:n])]
    wires += [Connection(s, slow[i], slow_scope[n + i]) for i, s in enumerate(sources)]
    sim, scope = wire(fast, sources, others=[slow, slow_scope], wires=wires)
    sim.run(2.0)
    u, y = samples(scope)
    assert np.array_equal(y, loop(u))
    u, y = samples(slow_scope, slow_T)
    assert np.array_equal(y, loop(u, "737", slow_T, substeps=4))


@pytest.mark.parametrize("substeps", [2, 5])
def test_substeps(substeps):
    long_T = 1 / 30
    fdm = block(T=long_T, substeps=substeps)
    sim, scope = wire(fdm, sines())
    sim.run(2.0)
    u, y = samples(scope, long_T)
    assert len(y) == 61
    assert np.array_equal(y, loop(u, T=long_T, substeps=substeps))


def test_feedback_through_algebraic_blocks_has_no_delay():
    # P control of the pitch angle, summed with a sine: u at t_k uses theta at t_k
    fdm = block()
    gain, total, source = Amplifier(0.02), Adder("++"), sine(0.5, 0.0)
    wires = [
        Connection(fdm["attitude/theta-deg"], gain),
        Connection(gain, total[0]),
        Connection(source, total[1]),
    ]
    sim, scope = wire(
        fdm, [total, Constant(0.0), Constant(0.0)], others=[gain, source], wires=wires
    )
    sim.run(3.0)
    u, y = samples(scope)
    time = np.arange(len(u)) * T
    law = 0.02 * y[:, 1] + 0.02 * np.sin(math.pi * time)
    assert np.allclose(u[:, 0], law, rtol=0, atol=1e-15 * 100)
    assert np.array_equal(y, loop(u))
