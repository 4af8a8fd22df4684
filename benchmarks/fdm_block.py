"""Cost of one step of the c172p pitch loop: our block, pathsim-flight's, and none at all.

    python benchmarks/fdm_block.py

One process flies the same diagram in turn with `JSBSimFDM`, with pathsim-flight's `JSBSimWrapper`,
with a block that does nothing ("empty") and with one that does the least an aircraft can ("bare":
write, run, read), and beside it a plain JSBSim loop without PathSim. The diagram: 4 inputs, 12
outputs, a proportional pitch law, one Scope, 120 Hz. Each figure is the median over the repetitions
of the time per JSBSim step; the ratios are formed within a repetition. The rows under `fly` say so;
the others are under `sim.run`.

The bare block shows what the target against "empty diagram + plain loop" can be: JSBSim and PathSim
evict each other from the processor's caches, so the two together take longer than the sum of both
alone, regardless of the block between them.
"""

import time

import jsbsim
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Constant, Scope
from pathsim.blocks import Block as PathSimBlock
from pathsim.utils.register import Register
from pathsim_flight.jsbsim import JSBSimWrapper
from report import HEADER, row

from pathsim_jsbsim_blocks import JSBSimFDM, fly

T = 1 / 120
STEPS = 12_000
REPETITIONS = 9
INPUTS = [
    "fcs/elevator-cmd-norm",
    "fcs/aileron-cmd-norm",
    "fcs/rudder-cmd-norm",
    "fcs/steer-cmd-norm",
]
OUTPUTS = [
    "attitude/theta-deg",
    "attitude/phi-deg",
    "attitude/psi-deg",
    "velocities/p-rad_sec",
    "velocities/q-rad_sec",
    "velocities/r-rad_sec",
    "aero/alpha-deg",
    "aero/beta-deg",
    "position/h-sl-ft",
    "velocities/h-dot-fps",
    "velocities/vc-kts",
    "velocities/vt-fps",
]
FLIGHT = {"aircraft_model": "c172p", "trim_airspeed": 90, "trim_altitude": 5000}


class Empty(PathSimBlock):
    """As many ports as the aircraft, and nothing behind them."""

    def __init__(self, **_):
        super().__init__()
        self.inputs, self.outputs = Register(len(INPUTS)), Register(len(OUTPUTS))

    def __len__(self):
        return 0

    def update(self, t):
        pass


class Bare(Empty):
    """Fly at every evaluation: no sample clock, no checks, no reset."""

    def __init__(self, **parameters):
        super().__init__()
        self.aircraft = JSBSimFDM(**parameters)
        self.put, self.get = accessors(self.aircraft.fdm)

    def update(self, t):
        for put, value in zip(self.put, self.inputs._data.tolist(), strict=True):
            put(value)
        self.aircraft.fdm.run()
        self.outputs._data[:] = [get() for get in self.get]


def accessors(fdm):
    """Functions that write the inputs and read the outputs."""
    nodes = fdm.get_property_manager()
    return (
        [nodes.get_node(name).set_double_value for name in INPUTS],
        [nodes.get_node(name).get_double_value for name in OUTPUTS],
    )


def diagram(block, T=T, **options):
    fdm = block(T=T, input_properties=INPUTS, output_properties=OUTPUTS, **FLIGHT, **options)
    error, gain = Adder("-+"), Amplifier(-0.02)
    reference, zeros = Constant(1.28), Constant(0.0)
    scope = Scope()
    n = len(OUTPUTS)
    return Simulation(
        [fdm, error, gain, reference, zeros, scope],
        [
            Connection(fdm[0], error[0]),
            Connection(reference, error[1]),
            Connection(error, gain),
            Connection(gain, fdm[0]),
            Connection(zeros, fdm[1], fdm[2], fdm[3]),
            Connection(fdm[:n], scope[:n]),
        ],
        dt=T,
        log=False,
    )


def time_diagram(block, steps=STEPS, run=Simulation.run, **options):
    """Seconds per step."""
    sim = diagram(block, **options)
    start = time.perf_counter()
    run(sim, steps * sim.dt)
    return (time.perf_counter() - start) / steps


def time_plain_loop(steps=STEPS, dt=T):
    """Seconds per JSBSim step of a plain loop with the same inputs, law and outputs."""
    fdm = JSBSimFDM(T=dt, input_properties=INPUTS, output_properties=OUTPUTS, **FLIGHT).fdm
    write, read = accessors(fdm)
    rows = []
    run = fdm.run
    y = [get() for get in read]
    start = time.perf_counter()
    for _ in range(steps):
        u = [-0.02 * (1.28 - y[0]), 0.0, 0.0, 0.0]
        for put, value in zip(write, u, strict=True):
            put(value)
        run()
        y = [get() for get in read]
        rows.append(y)
    return (time.perf_counter() - start) / steps


def rows():
    jsbsim.FGJSBBase().debug_lvl = 0
    ours, wrapper, bare, separate, plain = [], [], [], [], []
    flown, bare_flown, slow = [], [], []
    for _ in range(REPETITIONS):
        ours.append(time_diagram(JSBSimFDM))
        wrapper.append(time_diagram(JSBSimWrapper))
        bare.append(time_diagram(Bare))
        plain.append(time_plain_loop())
        separate.append(time_diagram(Empty) + plain[-1])
        flown.append(time_diagram(JSBSimFDM, run=fly))
        bare_flown.append(time_diagram(Bare, run=fly))
        slow.append(time_diagram(JSBSimFDM, STEPS // 4, run=fly, T=4 * T, substeps=4) / 4)
    step = "FDM block: a step of the pitch loop"
    row(step, "JSBSimWrapper", ours, wrapper, "us", 0.72, "pathsim-flight")
    row(step, "bare block", ours, bare, "us", package="pathsim")
    row(step, "empty diagram + plain loop", ours, separate, "us", 1.15, "pathsim")
    row(
        "bare block: the same step",
        "empty diagram + plain loop",
        bare,
        separate,
        "us",
        None,
        "pathsim",
    )
    row(f"{step}, fly", "bare block, fly", flown, bare_flown, "us", 1.05, "pathsim")
    row(f"{step}, fly", "plain loop", flown, plain, "us", package="jsbsim")
    row(
        "FDM block: 30 Hz, 4 substeps, per JSBSim step, fly",
        "plain loop",
        slow,
        plain,
        "us",
        1.5,
        "jsbsim",
    )


if __name__ == "__main__":
    print(HEADER)
    rows()
