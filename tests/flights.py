"""Flights under the autopilot, and how to read them."""

from __future__ import annotations

import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Scope, Source
from pymap3d import Ellipsoid

from pathsim_jsbsim_blocks import Aircraft, Autopilot, Sensor
from pathsim_jsbsim_blocks import fly as fly_diagram

T = 1 / 120
WGS84 = Ellipsoid(6_378_137.0 / 0.3048, 6_356_752.3142 / 0.3048)  # ft
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
    plane, seconds, ports=None, pulse=None, events=(), noise=None, unwired=PROTECTION, **parameters
):
    """Fly the autopilot; ``ports`` and ``pulse`` (by actuator) are functions of time.

    ``noise`` is the rms of what sensors add to the outputs of those names; ``unwired`` are inputs
    of the autopilot that get nothing.
    """
    autopilot, noise = Autopilot(**{"gains": plane.aircraft, **parameters}), noise or {}
    scope, commands = Scope(), Scope()
    names = [name for name in autopilot.input_port_labels if name in STATES and name not in unwired]
    direct = tuple(name for name in names if name not in noise)
    blocks = [plane, autopilot, scope, commands]
    connections = [
        Connection(plane[direct], autopilot[direct]),
        Connection(plane[: len(STATES)], scope[: len(STATES)]),
        Connection(autopilot[: len(COMMANDS)], commands[: len(COMMANDS)]),
    ]
    for seed, (name, sigma) in enumerate(noise.items()):
        blocks.append(Sensor(noise=sigma, seed=seed, T=T))
        connections.append(Connection(plane[name], blocks[-1]))
        connections.append(Connection(blocks[-1], autopilot[name]))
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
    t, y = scope.read()
    return Record(zip(["t", *STATES, *COMMANDS], [t, *y, *commands.read()[1]], strict=True))


def step(size, at=0.0):
    """A reference that steps up."""
    return lambda t: size if t > at - T / 2 else 0.0


def until(at):
    """1 before a time, 0 from then on."""
    return lambda t: t < at - T / 2


def on(t):
    """A switch that is always on."""
    return 1.0


def samples(block, rows):
    """Outputs of a block's law by port, for inputs by port; what is not given is 0."""
    state, ports = block.initial_state(), block.input_port_labels
    for given in rows:
        y, state = block.law([float(given.get(name, 0.0)) for name in ports], state)
        yield dict(zip(block.output_port_labels, y, strict=True))
