"""When a sampled block acts: instants met by adaptive steps, clocks that round, far from 0."""

from dataclasses import dataclass

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Integrator, Scope, Source
from pathsim.solvers import RKBS32, RKDP54

from pathsim_jsbsim_blocks._core.sampling import SampledLaw

pytestmark = pytest.mark.matrix


@dataclass(eq=False)
class Count(SampledLaw):
    """y[k] = k + 1, whatever comes in."""

    T: float

    def initial_state(self):
        return 0.0

    def law(self, u, state):
        return [state + 1.0], state + 1.0


def diagram(count, dt, start=0.0, **solver):
    """A law beside a state whose derivative is constant: an adaptive step is as long as it may."""
    constant, state, scope = Constant(1.0), Integrator(0.0), Scope()
    sim = Simulation(
        [constant, state, count, scope],
        [Connection(constant, state), Connection(count, scope)],
        dt=dt,
        log=False,
        **solver,
    )
    sim.reset(start)
    return sim, scope


@pytest.mark.parametrize("solver", [RKBS32, RKDP54])
@pytest.mark.parametrize("T", [0.1, 0.03])
@pytest.mark.parametrize("start", [0.0, 2.5])
def test_an_adaptive_step_is_cut_to_end_at_the_instant(solver, T, start):
    sim, scope = diagram(Count(T), 0.25, start, Solver=solver, dt_max=10.0)
    sim.run(12 * T)
    time, (y,) = scope.read()
    # no step ends anywhere else: a cut is right at once
    assert time == pytest.approx(start + T * np.arange(13), abs=1e-9)
    assert y.tolist() == list(range(1, 14))


@pytest.mark.parametrize("start", [0.0, 2.5])
def test_a_step_beyond_the_instant_is_refused_with_the_part_up_to_it(start):
    # `run` never tries it, it asks for the next instant first; a diagram stepped by hand does
    sim, _ = diagram(Count(0.1), 0.25, start, Solver=RKDP54)
    for dt, part in ((0.07, None), (0.12, 0.25), (0.03, None), (0.3, 1 / 3)):
        success, _, scale, *_ = sim.timestep(dt)
        assert success is (part is None)
        assert part is None or scale == pytest.approx(part, rel=1e-9)


@pytest.mark.parametrize(("T", "start"), [(1e-5, 2e4), (1e-6, 5e3), (0.01, 1e6), (0.1, 0.0)])
@pytest.mark.parametrize("parts", [1, 3])
def test_far_from_0_instants_are_still_told_apart(T, start, parts):
    # there the diagram's own clock is off by more than a short period's share
    count = Count(T)
    sim, _ = diagram(count, T / parts, start)
    for _ in range(40 * parts):
        sim.timestep(T / parts)
    assert count.outputs[0] == 41.0


@pytest.mark.parametrize("parts", [3, 7])
def test_a_period_in_parts_that_round_is_met_once(parts):
    T = 0.1
    seen = []
    law, source = Count(T), Source(lambda t: seen.append(t) or 0.0)
    sim = Simulation([source, law], [Connection(source, law)], dt=T / parts, log=False)
    sim.run(50.0)
    assert law.outputs[0] == 501.0
    assert len(seen) > 500 * parts
