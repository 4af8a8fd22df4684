"""Random diagrams of sampled blocks: `sim.run` and `fly` give what a plain loop gives, bit for bit."""

import math
import random

import numpy as np
import pytest
from how_many import bounded
from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Integrator, Scope, Source
from pathsim.events import ZeroCrossing
from pathsim.solvers import ESDIRK43, EUB, RK4, RKBS32, RKCK54, SSPRK22
from sampled_blocks import Integral, Mass, nested

from pathsim_jsbsim_blocks import fly

BASE = 0.025  # s; periods are multiples of it
STEPS = 60


def wave(rate):
    # of the grid, because PathSim adds up dt and the plain loop counts
    return lambda t: math.sin(rate * round(t / BASE))


def diagram(seed):
    """A simulation, its scope, and whether its steps are adaptive; the periods in grid steps."""
    draw = random.Random(seed)
    periods = [draw.choice([1, 1, 2, 3, 4]) for _ in range(3)]
    mass, one, two = (
        kind(BASE * n) for kind, n in zip((Mass, Integral, Integral), periods, strict=True)
    )
    rates = draw.uniform(0.05, 0.4), draw.uniform(0.05, 0.4)
    r, d, scope = Source(wave(rates[0])), Source(wave(rates[1])), Scope()
    gain = draw.uniform(0.2, 0.9)
    amplifier = Amplifier(gain)
    depths = [draw.choice([0, 0, 0, 1, 2]) for _ in range(3)]
    plant, first, second = (nested(b, 2, n) for b, n in zip((mass, one, two), depths, strict=True))
    states = draw.choice([0, 0, 1])
    solver = draw.choice([SSPRK22, SSPRK22, RK4, EUB, RKBS32, RKCK54, ESDIRK43])
    adaptive = solver in (RKBS32, RKCK54, ESDIRK43)
    blocks = [plant, first, second, r, d, scope, amplifier, *(Integrator() for _ in range(states))]
    draw.shuffle(blocks)
    wires = [
        Connection(r, first[0]),
        Connection(plant[0], first[1], second[1], scope[0]),
        Connection(first[0], second[0], scope[1]),
        Connection(second[0], amplifier, scope[2]),
        Connection(amplifier, plant[0]),
        Connection(d, plant[1], *(b for b in blocks if isinstance(b, Integrator))),
    ]
    draw.shuffle(wires)
    events = [ZeroCrossing(lambda t: math.sin(7.0 * t + 1.0))] * draw.choice([0, 0, 1])
    dt = BASE / draw.choice([1, 1, 2, 4])
    limits = {"dt_max": BASE} if adaptive else {}
    sim = Simulation(blocks, wires, events, dt=dt, Solver=solver, log=False, **limits)
    return sim, scope, adaptive, (periods, rates, gain)


def plain(plan):
    """Rows of the mass and both laws at each step of the grid."""
    periods, rates, gain = plan
    mass, one, two = (
        kind(BASE * n) for kind, n in zip((Mass, Integral, Integral), periods, strict=True)
    )
    y, held, outputs, states, rows = 0.0, None, [0.0, 0.0], [0.0, 0.0], []
    for n in range(STEPS + 1):
        if n and n % periods[0] == 0:
            (y,) = mass.advance(n // periods[0], held)
        for i, law in enumerate((one, two)):
            if n % periods[1 + i] == 0:
                reference = outputs[0] if i else math.sin(rates[0] * n)
                (outputs[i],), states[i] = law.law([reference, y], states[i])
        if n % periods[0] == 0:
            held = [gain * outputs[1], math.sin(rates[1] * n)]
        rows.append((y, *outputs))
    return np.array(rows).T


def flown(seed, run):
    sim, scope, adaptive, plan = diagram(seed)
    for part in (0.4, 0.6):
        run(sim, part * STEPS * BASE)
    time, rows = scope.read()
    n = np.rint(time / BASE).astype(int)
    on_grid = np.abs(time - n * BASE) < 1e-9
    assert set(n[on_grid]) >= set(range(STEPS + 1)) or adaptive
    return time, rows, n, on_grid, plan


def check(seed):
    time, rows, n, on_grid, plan = flown(seed, Simulation.run)
    expected = plain(plan)
    within = on_grid & (n <= STEPS)
    # adaptive steps end at the instants of the blocks
    assert within.sum() > STEPS // min(plan[0])
    assert np.array_equal(rows[:, within], expected[:, n[within]]), f"seed {seed}"
    again = flown(seed, fly)
    both = min(len(time), len(again[0]))  # run may make a step too many
    assert np.array_equal(again[0][:both], time[:both]), f"seed {seed}"
    assert np.array_equal(again[1][:, :both], rows[:, :both]), f"seed {seed}"
    assert len(time) - both <= 2


@pytest.mark.parametrize("count", [6, pytest.param(bounded(100, 300), marks=pytest.mark.long)])
def test_random_diagrams(count):
    for seed in range(count):
        check(seed)
