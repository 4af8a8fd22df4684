"""The states of a linear model as JSBSim properties, and their kinds."""

from __future__ import annotations

import math
import re

from .._core.aircraft_ports import ALMOST_NORTH
from ..flight.airframe import Airframe
from ..flight.channels import Channel, port_channel

# the states of a rigid aircraft
_STATES = ("vt", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi", "h")
RIGID = tuple(map(port_channel, _STATES))

# engine states with a JSBSim property
_ENGINE = {"propeller-rpm": "rpm", "map-inhg": "inHg", "thrust-lbs": "lbf"}

# ignorable coordinates: the dynamics do not depend on them
_IGNORABLE = re.compile(
    r"attitude/(psi|heading)|position/(lat|long|distance|ecef|eci|from-start|vrp-.*(lat|long))"
)


def engine_channels(airframe: Airframe) -> list[Channel]:
    """The engine states of an aircraft."""
    channels = []
    for i in range(airframe.engines):
        for quantity, unit in _ENGINE.items():
            name = f"propulsion/engine[{i}]/{quantity}"
            if airframe.has(name):
                channels.append(Channel(f"{quantity.partition('-')[0]}[{i}]", (name,), 1.0, unit))
    return channels


def ignorable(channel: Channel) -> bool:
    """Whether a quantity is an ignorable coordinate."""
    return any(_IGNORABLE.match(name) for name in channel.properties)


def acceleration(channel: Channel) -> bool:
    """Whether a quantity may jump with an input."""
    return any(name.startswith("accelerations/") for name in channel.properties)


def port_value(channel: Channel, value: float) -> float:
    """A property's value in the channel's unit, as at the ports: a heading of 360 is 0."""
    value = channel.factor * value
    return 0.0 if channel.unit == "deg" and value > ALMOST_NORTH else value


def full_circle(channel: Channel) -> float:
    """The period of an angle in its unit; 0 for other quantities."""
    return {"deg": 360.0, "rad": 2.0 * math.pi}.get(channel.unit, 0.0)
