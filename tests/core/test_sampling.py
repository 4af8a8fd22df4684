"""Sampled laws: what a rejected step leaves, and instants that a step jumps over."""

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Integrator, Scope, Source
from pathsim.events import Event
from pathsim.solvers import RKBS32

from pathsim_jsbsim_blocks._core.sampling import SampledLaw

pytestmark = pytest.mark.matrix

T = 0.1


class Total(SampledLaw):
    """y[k] = u[0] + ... + u[k]"""

    def initial_state(self):
        return 0.0

    def law(self, u, state):
        return [state + u[0]], state + u[0]


class Rejection(Event):
    """Refuses a step to ``time`` once, and acts before it is taken anew."""

    def __init__(self, time, action):
        super().__init__()
        self.time, self.action = time, action
        self.rejected = 0

    def detect(self, t):
        rejects = not self.rejected and abs(t - self.time) < 1e-9
        self.rejected += rejects
        return rejects, False, 1.0

    def buffer(self, t):
        if self.rejected == 1:
            self.rejected = 2
            self.action()


def flown(law, source, dt, states=0, events=(), **more):
    scope = Scope()
    integrators = [Integrator(0.0) for _ in range(states)]
    sim = Simulation([source, law, scope, *integrators],
                     [Connection(source, law), Connection(law, scope, *integrators)],
                     list(events), dt=dt, log=False, **more)
    sim.run(1.0)
    time, (y,) = scope.read()
    at = {round(t / T): value for t, value in zip(time, y, strict=True)
          if abs(t / T - round(t / T)) < 1e-6}
    return law, at


def test_a_law_acts_once_at_an_instant_whose_step_was_rejected():
    # what the law computed in the rejected step is forgotten, and computed again in the next one
    value = [1.0]
    rejection = Rejection(0.5, lambda: value.__setitem__(0, 10.0))
    _, at = flown(Total(T), Source(lambda t: value[0]), T / 2, states=1, events=[rejection],
                    Solver=RKBS32, dt_max=T / 2)
    assert rejection.rejected == 2
    assert [at[k] for k in range(11)] == [1, 2, 3, 4, 5, 15, 25, 35, 45, 55, 65]


@pytest.mark.parametrize("states", [0, 1])
def test_a_law_counts_the_instants_that_a_step_jumps_over_and_warns(states):
    with pytest.warns(RuntimeWarning, match=r"Total samples every 0.1 s, .* jumps over") as said:
        _, at = flown(Total(T), Source(lambda t: 1.0), 2 * T, states)
    assert len([w for w in said if "jumps over" in str(w.message)]) == 1
    # the samples 2 k - 1 and 2 k both act at 2 k
    assert np.allclose([at[k] for k in (0, 2, 4, 6, 8, 10)], [1, 3, 5, 7, 9, 11])


def test_a_step_that_divides_T_does_not_warn(recwarn):
    _, at = flown(Total(T), Source(lambda t: 1.0), T / 4)
    assert [at[k] for k in range(11)] == list(range(1, 12))
    assert not [w for w in recwarn if "jumps over" in str(w.message)]
