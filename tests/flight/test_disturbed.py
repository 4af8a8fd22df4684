"""Random diagrams around an aircraft keep time while they are looked at, ended in mid-run and changed.

Drawn are sample period, substeps, step and solver, what drives the inputs, continuous states, other
sampled blocks, subsystems around the aircraft and the order of the blocks. The oracle is a plain
JSBSim loop that is fed with the inputs of each period.
"""

import contextlib
import functools
import math
import random
from dataclasses import dataclass

import numpy as np
import pytest
from how_many import bounded
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Constant, Integrator, Scope, Source, StepSource
from pathsim.events import ZeroCrossing
from pathsim.exceptions import LinearizationError
from pathsim.solvers import ESDIRK43, RK4, RKBS32, RKDP54, SSPRK22
from plain_jsbsim import fly, trimmed

import pathsim_jsbsim_blocks as blocks
from pathsim_jsbsim_blocks import (
    DiscretePID,
    DoubletSource,
    JSBSimFDM,
    PitchHold,
    RampSource,
    RollHold,
)

INPUTS = ["fcs/elevator-cmd-norm", "fcs/aileron-cmd-norm"]
OUTPUTS = [
    "attitude/theta-deg",
    "attitude/phi-deg",
    "velocities/q-rad_sec",
    "velocities/p-rad_sec",
    "velocities/vt-fps",
    "position/h-sl-ft",
    "simulation/sim-time-sec",
]
AIRCRAFT = {"c172p": (5000.0, 90.0), "737": (10000.0, 280.0), "A4": (10000.0, 300.0)}
ADAPTIVE = (RKBS32, RKDP54, ESDIRK43)


@dataclass
class Plan:
    """All that makes a diagram."""

    aircraft: str
    T: float
    substeps: int
    solver: type
    parts: int
    drives: tuple
    states: int
    depth: int
    gains: bool
    inside: bool
    order: int


def drive(kind, plan, i, system):
    """Blocks and connections that drive input i; the last block's output is the input."""
    # theta is fed back to the elevator, phi to the aileron
    measured = system[i]
    if kind in ("pid", "slow pid"):
        T = plan.T * (3 if kind == "slow pid" else 1)
        pid = DiscretePID(Kp=-0.01, Ki=-0.005, Kd=0.002, low=-0.2, high=0.2, T=T)
        reference = StepSource(amplitude=2.0, tau=7.3 * plan.T)
        return [reference, pid], [Connection(reference, pid["r"]), Connection(measured, pid["y"])]
    if kind == "hold":
        hold = (
            PitchHold(plan.aircraft, theta_ref=2.0, authority=0.1, T=plan.T)
            if i == 0
            else RollHold(plan.aircraft, phi_ref=-3.0, authority=0.1, T=plan.T)
        )
        return [hold], [Connection(measured, hold[0]), Connection(system[2 + i], hold[1])]
    if kind == "feedback":
        gain, offset, total = Amplifier(0.01), Constant(0.005), Adder("++")
        return [gain, offset, total], [
            Connection(measured, gain),
            Connection(gain, total[0]),
            Connection(offset, total[1]),
        ]
    return [
        {
            "sine": lambda: Source(lambda t: 0.03 * math.sin(5.0 * t + i)),
            "step": lambda: StepSource(amplitude=0.03, tau=0.1234),
            # edges on sample instants, and off them
            "doublet": lambda: DoubletSource(amplitude=0.04, start=6 * plan.T, width=0.1111),
            "ramp": lambda: RampSource(final=0.05, start=0.05, rise_time=0.3),
            "constant": lambda: Constant(0.01),
        }[kind]()
    ], []


def around(fdm, plan):
    """The aircraft inside subsystems, maybe with what drives its elevator beside it.

    Inputs and outputs are those of the aircraft; the elevator command is one output more.
    """
    inputs, outputs = list(range(len(INPUTS))), len(OUTPUTS)
    for level in range(plan.depth):
        interface = Interface()
        blocks, wires = [interface, fdm], []
        if plan.inside and level == 0:
            others, wires = drive(plan.drives[0], plan, 0, fdm)
            blocks += others
            wires.append(Connection(others[-1], fdm[0], interface[outputs]))
            inputs.remove(0)
        for i in inputs:
            if plan.gains:
                amplifier = Amplifier(1.0)
                blocks.append(amplifier)
                wires += [Connection(interface[i], amplifier), Connection(amplifier, fdm[i])]
            else:
                wires.append(Connection(interface[i], fdm[i]))
        wires += [Connection(fdm[i], interface[i]) for i in range(outputs)]
        outputs = len(OUTPUTS) + (0 not in inputs)
        fdm = Subsystem(blocks, wires)
    return fdm, inputs


def build(plan):
    altitude, speed = AIRCRAFT[plan.aircraft]
    fdm = JSBSimFDM(
        T=plan.T,
        substeps=plan.substeps,
        input_properties=INPUTS,
        output_properties=OUTPUTS,
        aircraft_model=plan.aircraft,
        trim_altitude=altitude,
        trim_airspeed=speed,
        gear=1,
    )
    (system, inputs), scope = around(fdm, plan), Scope()
    blocks, wires = [system, scope], []
    for i, kind in enumerate(plan.drives):
        if i in inputs:
            others, between = drive(kind, plan, i, system)
            blocks += others
            wires += [*between, Connection(others[-1], system[i], scope[i])]
        else:
            wires.append(Connection(system[len(OUTPUTS)], scope[i]))
    wires += [Connection(system[i], scope[len(INPUTS) + i]) for i in range(len(OUTPUTS))]
    for _ in range(plan.states):
        integrator = Integrator(0.0)
        blocks.append(integrator)
        wires.append(Connection(system[0], integrator))
    shuffled = np.random.default_rng(plan.order).permutation(len(blocks))
    dt = plan.T / plan.parts
    limit = {"dt_max": dt} if plan.solver in ADAPTIVE else {}
    sim = Simulation(
        [blocks[i] for i in shuffled], wires, dt=dt, Solver=plan.solver, log=False, **limit
    )
    return fdm, scope, sim


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
    draw = random.Random(seed)
    plan = Plan(
        draw.choice(list(AIRCRAFT)),
        draw.choice([1 / 120, 1 / 100, 1 / 30]),
        draw.randint(1, 4),
        draw.choice([SSPRK22, RK4, *ADAPTIVE]),
        draw.randint(1, 4),
        (draw.choice(DRIVES), draw.choice(DRIVES)),
        draw.randint(0, 2),
        draw.randint(0, 2),
        draw.random() < 0.5,
        draw.random() < 0.5,
        draw.getrandbits(31),
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
        if plan.solver in ADAPTIVE:
            sim.run(periods * plan.T)
        elif seed % 2:
            blocks.fly(sim, periods * plan.T)
        else:
            sim.run(periods * plan.T, adaptive=False)

    fdm.advance = kept
    # looks in milliseconds
    fdm.linear_model = functools.partial(fdm.linear_model, "algebraic")
    for _ in range(draw.randint(2, 6)):
        fault.chance = draw.choice([0.0, 0.02, 0.05])
        broken = 0
        try:
            go_on(draw.randint(1, 15))
        except (ValueError, KeyboardInterrupt):
            broken = 1
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


@pytest.mark.parametrize("count", [8, pytest.param(bounded(120, 400), marks=pytest.mark.long)])
def test_disturbed_diagrams(count):
    for seed in range(count):
        fly_disturbed(seed)
