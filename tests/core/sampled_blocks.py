"""A plant and a law of two lines each, and blocks in subsystems, for diagrams with known samples."""

from dataclasses import dataclass

from pathsim import Connection, Interface, Subsystem
from pathsim.blocks import Amplifier

from pathsim_jsbsim_blocks._core.sampling import SampledLaw, SampledPlant


class Mass(SampledPlant):
    """A damped mass in Euler's steps, which may be asked again for the latest of them."""

    input_port_labels = {"u": 0, "d": 1}

    def __init__(self, T):
        super().__init__(T)
        self.begin()

    def begin(self):
        self.states = {0: (0.0, 1.0)}
        self.start_from([0.0])

    def reset(self):
        super().reset()
        self.begin()

    def advance(self, index, u):
        s, v = self.states[index - 1]
        v += self.clock.period * (u[0] + u[1] - 0.3 * v - s)
        self.states[index] = s + self.clock.period * v, v
        return [s + self.clock.period * v]


@dataclass(eq=False)
class Integral(SampledLaw):
    """PI on the difference of two inputs."""

    T: float

    input_port_labels = {"r": 0, "y": 1}

    def initial_state(self):
        return 0.0

    def law(self, u, state):
        error = u[0] - u[1]
        state = state + self.clock.period * error
        return [0.8 * error + 0.5 * state], state


def nested(block, inputs, depth):
    """The block in so many subsystems, behind a gain of 1 at each of its inputs in each."""
    for _ in range(depth):
        inside, gains = Interface(), [Amplifier(1.0) for _ in range(inputs)]
        wires = [Connection(inside[i], gain) for i, gain in enumerate(gains)]
        wires += [Connection(gain, block[i]) for i, gain in enumerate(gains)]
        block = Subsystem([inside, *gains, block], [*wires, Connection(block, inside)])
    return block
