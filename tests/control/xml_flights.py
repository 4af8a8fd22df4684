"""Flights of a block in PathSim, and of its XML in JSBSim alone."""

from __future__ import annotations

import numpy as np
from flights import TURBULENCE
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import Aircraft, fly

# of JSBSim, read as they are
STATES = {
    "theta": "attitude/theta-deg",
    "phi": "attitude/phi-deg",
    "h": "position/h-sl-ft",
    "vc": "velocities/vc-kts",
    "alpha": "aero/alpha-deg",
    "beta": "aero/beta-deg",
    "vt": "velocities/vt-fps",
    "nz": "accelerations/Nz",
    "lat": "position/lat-geod-deg",
}
UNITS = {"h": "ft", "vc": "kts"}


def step(size, at):
    return lambda t: size if t > at - 1e-6 else 0.0


def during(begin, end):
    return lambda t: float(begin - 1e-6 < t < end - 1e-6)


def property_of(port):
    """Of a reference, a switch or a command."""
    name = port.replace("_", "-")
    if port.endswith("_ref"):
        return f"{name}-{UNITS.get(port[:-4], 'deg')}"
    return name if port.endswith(("_mode", "off")) else f"{name}-norm"


def in_pathsim(block, start, seconds, ports):
    """States and increments at each sample of the aircraft, in rows."""
    plane, scope = Aircraft(**start), Scope()
    seen = [name for name in block.input_port_labels if name in plane.output_port_labels]
    driven = [name for name in block.output_port_labels if name in plane.input_port_labels]
    sources = [Source(signal) for signal in ports.values()]
    connections = [
        Connection(plane[tuple(seen)], block[tuple(seen)]),
        Connection(block[tuple(driven)], plane[tuple(driven)]),
        *(Connection(source, block[port]) for source, port in zip(sources, ports, strict=True)),
        *(Connection(plane[name], scope[i]) for i, name in enumerate(STATES)),
        *(Connection(block[name], scope[len(STATES) + i]) for i, name in enumerate(driven)),
    ]
    sim = Simulation([plane, block, *sources, scope], connections, dt=plane.T, log=False)
    fly(sim, seconds)
    return scope.read()[1].T


def in_jsbsim(block, start, seconds, ports, folder):
    """The same, flown by JSBSim with the block's XML."""
    plane = Aircraft(**start)
    file = folder / "law.xml"
    file.write_text(block.to_jsbsim_xml("law", engines=plane.airframe.engines), encoding="utf-8")
    driven = [name for name in block.output_port_labels if name in plane.input_port_labels]
    plane = Aircraft(**start, systems=[str(file)])
    fdm, rows = plane.fdm, []
    fdm["ap/pathsim/law/engaged"] = 1.0
    for k in range(round(seconds / plane.T) + 1):
        for port, signal in ports.items():
            fdm[f"ap/pathsim/law/{property_of(port)}"] = signal(k * plane.T)
        states = [fdm[name] for name in STATES.values()]
        for _ in range(plane.substeps):
            fdm.run()
        rows.append([*states, *(fdm[f"ap/pathsim/law/{property_of(name)}"] for name in driven)])
    return np.array(rows)


def both(make, start, seconds, ports, folder, turbulent=True):
    """Rows of both flights."""
    if turbulent:
        start = {**start, "properties": {**TURBULENCE, **start.get("properties", {})}}
    flown = in_pathsim(make(), start, seconds, ports)
    return flown, in_jsbsim(make(), start, seconds, ports, folder)
