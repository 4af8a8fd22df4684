"""Properties of the whole: in any diagram the aircraft keeps time and a flight can be repeated.

Hypothesis draws diagrams around an aircraft: sample period, substeps, step and solver, what drives
the inputs, continuous states, other sampled blocks, subsystems around the aircraft, the order of
the blocks, the pieces in which it is run, resets. The oracle is a plain JSBSim loop that is fed
with the inputs recorded at the sample instants.
"""

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import HealthCheck, event, given, settings
from hypothesis import strategies as st
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Amplifier, Constant, Integrator, Scope, Source, StepSource
from pathsim.solvers import ESDIRK43, RK4, RKBS32, RKCK54, SSPRK22
from plain_jsbsim import fly, trimmed

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
ADAPTIVE = (RKBS32, RKCK54, ESDIRK43)


@dataclass
class Plan:
    """All that makes a diagram and how it is run."""

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
    pieces: tuple

    @property
    def dt(self):
        return self.T / self.parts

    @property
    def samples(self):
        """Number of sample periods since the last reset."""
        return sum(
            self.pieces[1 + max((i for i, n in enumerate(self.pieces) if n == 0), default=-1) :]
        )


drives = st.sampled_from(
    ["sine", "step", "doublet", "ramp", "constant", "feedback", "pid", "slow pid", "hold"]
)
plans = st.builds(
    Plan,
    aircraft=st.sampled_from(list(AIRCRAFT)),
    T=st.sampled_from([1 / 120, 1 / 100, 1 / 30]),
    substeps=st.integers(1, 4),
    solver=st.sampled_from([SSPRK22, RK4, *ADAPTIVE]),
    parts=st.integers(1, 4),
    drives=st.tuples(drives, drives),
    states=st.integers(0, 2),
    depth=st.integers(0, 2),
    gains=st.booleans(),
    inside=st.booleans(),
    order=st.integers(0, 2**31),
    # sample periods in a piece of the run; 0 is a reset. The last piece is a run
    pieces=st.lists(st.integers(0, 40), max_size=4).flatmap(
        lambda pieces: st.integers(1, 40).map(lambda last: (*pieces, last))
    ),
)


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
            PitchHold(theta_ref=2.0, authority=0.1, T=plan.T)
            if i == 0
            else RollHold(phi_ref=-3.0, authority=0.1, T=plan.T)
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
    limit = {"dt_max": plan.dt} if plan.solver in ADAPTIVE else {}
    sim = Simulation(
        [blocks[i] for i in shuffled], wires, dt=plan.dt, Solver=plan.solver, log=False, **limit
    )
    return fdm, scope, sim


def flown(plan):
    """Time and records of all ports after the plan's runs and resets."""
    fdm, scope, sim = build(plan)
    for piece in plan.pieces:
        if piece:
            sim.run(piece * plan.T, adaptive=plan.solver in ADAPTIVE)
        else:
            sim.reset()
    return fdm, *scope.read()


def at_the_instants(plan, time, data):
    """Records at the sample instants: of several there, which rounding errors set apart, the last.

    An adaptive solver makes its first steps after an event very small. What the diagram says until
    1e-9 of the time, plus 1e-13 s, after an instant is taken for its value there.
    """
    k = np.round(time / plan.T).astype(int)
    late = time - k * plan.T
    slack = 1e-13 + 1e-9 * k * plan.T
    at = np.flatnonzero((late >= -slack) & (late <= slack))
    _, last = np.unique(k[at][::-1], return_index=True)
    at = at[::-1][last]
    assert np.array_equal(k[at], np.arange(plan.samples + 1))
    return data[:, at].T


@settings(
    max_examples=settings().max_examples // 5,
    derandomize=True,
    suppress_health_check=[HealthCheck.too_slow],
)
@given(plans)
def test_any_diagram_keeps_time_and_can_be_repeated(plan):
    event(f"{plan.solver.__name__}, {plan.states} states")
    fdm, time, data = flown(plan)
    assert fdm.samples == plan.samples
    rows = at_the_instants(plan, time, data)
    u, y = rows[:, :2], rows[:, 2:]
    plain = trimmed(plan.aircraft, *AIRCRAFT[plan.aircraft], plan.T / plan.substeps)
    expected = fly(plain, INPUTS, u[:-1], OUTPUTS, plan.substeps)
    if plan.dt == plan.T and plan.solver not in ADAPTIVE:
        assert np.array_equal(y, expected)
    else:
        # deg, rad/s, ft/s and ft, relative to 1 or to the largest value: the inputs move by up to
        # 1e-10 within what counts as the instant; at another instant they differ by 1e-3
        scale = np.maximum(np.abs(expected).max(axis=0), 1.0)
        assert np.max(np.abs(y - expected) / scale) <= 1e-9
    assert np.array_equal(y[:, -1], expected[:, -1])

    _, again, data_again = flown(plan)
    assert np.array_equal(again, time)
    assert np.array_equal(data_again, data)
