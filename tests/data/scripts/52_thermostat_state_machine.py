"""A thermostat as a state machine in an object with blocks, changed by events."""

from enum import Enum
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Constant, Integrator, Scope
from pathsim.events import Condition, ZeroCrossingDown, ZeroCrossingUp


class Mode(Enum):
    OFF = 0
    HEAT = 1


class Thermostat:
    LOW, HIGH = 19.0, 21.0

    def __init__(self):
        self.mode, self.switches = Mode.HEAT, 0
        self.heater = Constant(5.0)
        self.room = Integrator(18.0)
        self.events = [
            ZeroCrossingUp(lambda t: self.room.engine.state - self.HIGH, self.off),
            ZeroCrossingDown(lambda t: self.room.engine.state - self.LOW, self.on),
        ]

    def off(self, t):
        self.mode = Mode.OFF
        self.switches += 1
        self.heater.value = 0.0

    def on(self, t):
        self.mode = Mode.HEAT
        self.switches += 1
        self.heater.value = 5.0


th = Thermostat()
loss, total, outside, sc = Amplifier(-0.3), Adder(), Constant(3.0), Scope(labels=["T", "q"])
sim = Simulation(
    [th.heater, th.room, loss, total, outside, sc],
    [
        Connection(th.heater, total[0], sc[1]),
        Connection(th.room, loss, sc[0]),
        Connection(loss, total[1]),
        Connection(outside, total[2]),
        Connection(total, th.room),
    ],
    th.events,
    dt=0.02,
    log=False,
)
sim.run(12)
print(th.switches, th.mode)
