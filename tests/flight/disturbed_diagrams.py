"""Random diagrams around an aircraft that are looked at, interrupted and changed while they run."""

import contextlib
import functools
import random

import numpy as np
from pathsim.blocks import Integrator, Source
from pathsim.events import ZeroCrossing
from pathsim.exceptions import LinearizationError
from pathsim.solvers import ESDIRK43, RK4, RKBS32, RKDP54, SSPRK22
from plain_jsbsim import fly, trimmed
from test_properties import ADAPTIVE, AIRCRAFT, INPUTS, OUTPUTS, Plan, build

import pathsim_jsbsim_blocks as blocks

DRIVES = ["sine", "step", "doublet", "ramp", "constant", "feedback", "pid", "slow pid", "hold"]


class Fault(Source):
    """Raises at drawn calls of PathSim's: in an evaluation or where a step is recorded."""

    def __init__(self, draw):
        super().__init__(lambda t: t)
        self.draw, self.chance = draw, 0.0

    def _maybe(self):
        if self.draw.random() < self.chance:
            raise self.draw.choice([ValueError, KeyboardInterrupt])("on purpose")

    def update(self, t):
        self._maybe()
        super().update(t)

    def sample(self, t, dt):
        self._maybe()


def fly_disturbed(seed):
    """Fly one diagram; returns how often its run was ended."""
    draw = random.Random(seed)
    plan = Plan(
        draw.choice(list(AIRCRAFT)),
        draw.choice([1 / 120, 1 / 100, 1 / 30]),
        draw.randint(1, 4),
        draw.choice([SSPRK22, RK4, RKBS32, RKDP54, ESDIRK43]),
        draw.randint(1, 4),
        (draw.choice(DRIVES), draw.choice(DRIVES)),
        draw.randint(0, 2),
        draw.randint(0, 2),
        draw.random() < 0.5,
        draw.random() < 0.5,
        draw.getrandbits(31),
        (1,),
    )
    fdm, _, sim = build(plan)
    fault = Fault(draw)
    sim.add_block(fault)
    if draw.random() < 0.5:
        frequency = draw.uniform(5.0, 60.0)
        sim.add_event(ZeroCrossing(lambda t: np.sin(frequency * t + 1.0)))
    flown, advance = {}, fdm.advance

    def kept(index, u):
        y = advance(index, u)
        assert index not in flown, f"seed {seed}: period {index} was flown twice"
        flown[index] = u, y
        return y

    def go_on(periods):
        if plan.solver in (*ADAPTIVE, RKDP54):
            sim.run(periods * plan.T)
        elif seed % 2:
            blocks.fly(sim, periods * plan.T)
        else:
            sim.run(periods * plan.T, adaptive=False)

    fdm.advance = kept
    # looks in milliseconds
    fdm.linear_model = functools.partial(fdm.linear_model, "algebraic")
    ended = 0
    for _ in range(draw.randint(2, 6)):
        fault.chance = draw.choice([0.0, 0.02, 0.05])
        broken = 0
        try:
            go_on(draw.randint(1, 15))
        except (ValueError, KeyboardInterrupt):
            broken = 1
        ended += broken
        fault.chance, before = 0.0, len(flown)
        # PathSim does not find the ports of a block in a subsystem
        not_found = (KeyError,) if plan.depth else ()
        with contextlib.suppress(LinearizationError, *not_found):
            sim.to_statespace([fdm[0]], [fdm[0]], t=sim.time + draw.choice([0, plan.T, 9.0]))
        # a look at the end of a step that was interrupted may make that step's period
        assert len(flown) - before in (0, broken), f"seed {seed}: a look has flown"
        if draw.random() < 0.3:
            sim.add_block(Integrator())
    go_on(3)
    assert fdm.samples == int(sim.time / plan.T + 1e-6), f"seed {seed}: {fdm.samples} samples"
    assert len(flown) - fdm.samples in (0, 1), f"seed {seed}: {len(flown)} periods"
    rows = [flown[k] for k in range(1, len(flown) + 1)]
    plain = trimmed(plan.aircraft, *AIRCRAFT[plan.aircraft], plan.T / plan.substeps)
    expected = fly(plain, INPUTS, [u for u, _ in rows], OUTPUTS, plan.substeps)
    assert np.array_equal([y for _, y in rows], expected[1:]), f"seed {seed}"
    return ended
