"""The autopilot block as a block: order, reset, checkpoints, subsystems, life without jsbsim."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from flights import T, fly, start, step
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Integrator, Scope, Source

from pathsim_jsbsim_blocks import Autopilot, PitchHold

SEEN = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "elev_sat", "ail_sat", "thr_sat")
DRIVEN = ("elevator", "aileron", "rudder", "throttle")


def diagram(order=1, states=0, **options):
    plane, autopilot = start("737", **options), Autopilot("737")
    climb, turn = Source(step(300.0, 1.0)), Source(step(20.0, 2.0))
    scope = Scope()
    integrators = [Integrator() for _ in range(states)]
    sim = Simulation(
        [autopilot, plane, climb, turn, scope, *integrators][::order],
        [
            Connection(plane[SEEN], autopilot[SEEN]),
            Connection(autopilot[DRIVEN], plane[DRIVEN]),
            Connection(climb, autopilot["h_ref"]),
            Connection(turn, autopilot["psi_ref"]),
            Connection(plane[:4], scope[:4]),
            Connection(autopilot[DRIVEN], scope[4:8]),
            *(Connection(plane["theta"], i) for i in integrators),
        ],
        dt=T,
        log=False,
    )
    return sim, scope


def flown(sim, scope, seconds=10.0, **options):
    sim.run(seconds, **options)
    return scope.read()[1]


def test_order_of_blocks_and_continuous_states_do_not_matter():
    reference = flown(*diagram())
    assert np.ptp(reference[4]) > 0.01  # it flies
    assert np.array_equal(flown(*diagram(order=-1)), reference)
    assert np.array_equal(flown(*diagram(states=1)), reference)


def test_reset_flies_the_same_flight_again():
    sim, scope = diagram()
    first = flown(sim, scope)
    assert np.array_equal(flown(sim, scope, reset=True), first)


@pytest.mark.filterwarnings("ignore:Autopilot.*(increment|far below)")
@pytest.mark.parametrize("seed", [1, 2])
def test_any_inputs_keep_the_commands_within_their_authority(seed):
    rng = np.random.default_rng(seed)
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


def test_a_step_of_the_law_is_pure():
    autopilot = Autopilot("c172p")
    u = [float(i) for i in range(len(autopilot.input_port_labels))]
    state = autopilot.initial_state()
    assert autopilot.law(u, state) == autopilot.law(u, state)
    assert state == autopilot.initial_state()


def test_unwired_everything_is_quiet():
    # inputs of 0.0 are what PathSim gives to a port that is not wired
    for block in (Autopilot(), PitchHold()):
        y, state = block.law([0.0] * len(block.input_port_labels), block.initial_state())
        y, _ = block.law([0.0] * len(block.input_port_labels), state)
        assert y == [0.0] * len(y)


def test_turn_and_climb_at_once():
    flight = fly(
        start("737"), 120.0, {"h_ref": step(1000.0), "psi_ref": step(90.0), "vc_ref": step(10.0)}
    )
    assert flight["h"][-1] - flight["h"][0] == pytest.approx(1000.0, abs=10.0)
    assert flight["psi"][-1] == pytest.approx(180.0, abs=0.5)
    assert flight["vc"][-1] - flight["vc"][0] == pytest.approx(10.0, abs=0.5)


@pytest.mark.parametrize("nested", [False, True])
def test_a_measurement_without_a_wire_is_named(nested):
    hold, theta, interface, integrator = PitchHold(), Source(math.sin), Interface(), Integrator()
    inner = [Connection(theta, hold[0]), Connection(hold, interface[0])]
    if nested:
        part = Subsystem([interface, hold, theta], inner)
        sim = Simulation([part, integrator], [Connection(part, integrator)], dt=T, log=False)
    else:
        sim = Simulation(
            [hold, theta, integrator], [inner[0], Connection(hold, integrator)], dt=T, log=False
        )
    with pytest.warns(RuntimeWarning, match=r"PitchHold measures 0 where no wire comes in: q$"):
        sim.run(0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.run(0.1)
