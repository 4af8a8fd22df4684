"""Flights under the autopilot or under single holds, and how to read them."""

from __future__ import annotations

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Scope, Source

from pathsim_jsbsim_blocks import (
    Aircraft,
    AirspeedHold,
    AltitudeHold,
    Autopilot,
    HeadingHold,
    PitchHold,
    RollHold,
    YawDamper,
)
from pathsim_jsbsim_blocks import fly as fly_diagram

T = 1 / 120
POINTS = {
    "c172p": {"altitude": 5000.0, "speed": 90.0, "heading": 90.0},
    "737": {"altitude": 10_000.0, "speed": 280.0, "heading": 90.0, "gear": 0.0},
    "global5000": {"altitude": 15_000.0, "speed": 250.0, "heading": 90.0, "gear": 0.0},
}
STATES = list(Aircraft.output_port_labels)
COMMANDS = list(Autopilot.output_port_labels)
TURBULENCE = {
    "atmosphere/randomseed": 7,
    "atmosphere/turb-type": 3,
    "atmosphere/turbulence/milspec/severity": 4,
    "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 50.0,
}


def start(name, **flight):
    """The aircraft at its point of the table, or off it."""
    return Aircraft(name, **{**POINTS[name], **flight})


class Record(dict):
    """Signals of a flight by their port's name, and ``t`` in s."""

    def before(self, t):
        """The flight up to a time."""
        early = self["t"] < t - T / 2
        return Record({name: y[early] for name, y in self.items()})

    def after(self, t):
        """The flight from a time on, with ``t`` counted from there."""
        late = self["t"] > t - T / 2
        part = Record({name: y[late] for name, y in self.items()})
        part["t"] = part["t"] - t
        return part

    def settled(self, name, reference, tolerance):
        """Time from which the signal stays within the tolerance; inf if it does not."""
        error = self[name] - reference
        if name == "psi":
            error = wrap(error)
        outside = np.flatnonzero(np.abs(error) > tolerance)
        if not len(outside):
            return 0.0
        return self["t"][outside[-1] + 1] if outside[-1] + 1 < len(error) else np.inf


def wrap(angle):
    return (angle + 180.0) % 360.0 - 180.0


PROTECTION = ("alpha", "beta")  # ports of the protection and of coordinated turns


def fly(
    plane,
    seconds,
    ports=None,
    pulse=None,
    events=(),
    sensors=None,
    unwired=PROTECTION,
    **parameters,
):
    """Fly the autopilot; ``ports`` and ``pulse`` (by actuator) are functions of time.

    ``sensors`` is a block between the aircraft's outputs and the autopilot; ``unwired`` are inputs
    of the autopilot that get nothing.
    """
    autopilot = Autopilot(**{"gains": plane.aircraft, **parameters})
    scope, commands = Scope(), Scope()
    seen = plane if sensors is None else sensors
    names = [name for name in autopilot.input_port_labels if name in STATES and name not in unwired]
    blocks = [plane, autopilot, scope, commands]
    connections = [
        Connection(seen[tuple(names)], autopilot[tuple(names)]),
        Connection(plane[: len(STATES)], scope[: len(STATES)]),
        Connection(autopilot[: len(COMMANDS)], commands[: len(COMMANDS)]),
    ]
    if sensors is not None:
        blocks.append(sensors)
        connections.append(Connection(plane[: len(STATES)], sensors[: len(STATES)]))
    for name, signal in (ports or {}).items():
        blocks.append(Source(lambda t, signal=signal: float(signal(t))))
        connections.append(Connection(blocks[-1], autopilot[name]))
    for name in ("elevator", "aileron", "rudder", "throttle"):
        if pulse and name in pulse:
            blocks += [Source(lambda t, signal=pulse[name]: float(signal(t))), Adder("++")]
            connections += [
                Connection(blocks[-2], blocks[-1][0]),
                Connection(autopilot[name], blocks[-1][1]),
                Connection(blocks[-1], plane[name]),
            ]
        else:
            connections.append(Connection(autopilot[name], plane[name]))
    sim = Simulation(blocks, connections, list(events), dt=T, log=False)
    fly_diagram(sim, seconds)
    return record(scope, commands)


def record(scope, commands):
    t, y = scope.read()
    # the last command, hdot_cmd, is missing where no hold has it
    return Record(zip(["t", *STATES, *COMMANDS], [t, *y, *commands.read()[1]], strict=False))


def fly_holds(plane, seconds, vertical="altitude", lateral="heading", ports=None):
    """The same with one block for each hold; ``ports`` are references by their port's name."""
    gains = plane.aircraft
    elevator = AltitudeHold(gains) if vertical == "altitude" else PitchHold(gains)
    aileron = HeadingHold(gains) if lateral == "heading" else RollHold(gains)
    holds = [elevator, aileron, AirspeedHold(gains), YawDamper(gains)]
    scope, commands = Scope(), Scope()
    blocks, connections = [plane, *holds, scope, commands], []
    for hold in holds:
        for name in hold.input_port_labels:
            if name in STATES and name not in PROTECTION:
                connections.append(Connection(plane[name], hold[name]))
            elif name in (ports or {}):
                signal = ports[name]
                blocks.append(Source(lambda t, signal=signal: float(signal(t))))
                connections.append(Connection(blocks[-1], hold[name]))
        for name in hold.output_port_labels:
            to = [commands[COMMANDS.index(name)]]
            if name in plane.input_port_labels:
                to.append(plane[name])
            connections.append(Connection(hold[name], *to))
    connections.append(Connection(plane[: len(STATES)], scope[: len(STATES)]))
    sim = Simulation(blocks, connections, dt=T, log=False)
    fly_diagram(sim, seconds)
    return record(scope, commands)


def step(size, at=0.0):
    """A reference that steps up."""
    return lambda t: size if t > at - T / 2 else 0.0


def until(at):
    """1 before a time, 0 from then on."""
    return lambda t: t < at - T / 2


def on(t):
    """A switch that is always on."""
    return 1.0
