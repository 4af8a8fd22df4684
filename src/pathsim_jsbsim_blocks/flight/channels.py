"""Inputs, outputs and states of linear models as JSBSim properties with units."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from .._core.aircraft_ports import ALMOST_NORTH, OUTPUTS
from .airframe import Airframe


@dataclass(frozen=True)
class Channel:
    """A quantity by name: the properties behind it, and the factor from theirs to its unit.

    An input writes all its properties, any other channel reads the first; without one it is
    constant.
    """

    name: str
    properties: tuple[str, ...]
    factor: float = 1.0
    unit: str = ""


def port_channel(port: str) -> Channel:
    """An output of `Aircraft`."""
    name, factor, unit = OUTPUTS[port]
    return Channel(port, () if name is None else (name,), factor, unit)


# the states of a rigid aircraft
_STATES = ("vt", "alpha", "beta", "p", "q", "r", "phi", "theta", "psi", "h")
RIGID = tuple(map(port_channel, _STATES))

# engine states that JSBSim shows
_ENGINE = {"propeller-rpm": "rpm", "map-inhg": "inHg", "thrust-lbs": "lbf"}

# ignorable coordinates: the dynamics do not depend on them
_IGNORABLE = re.compile(
    r"attitude/(psi|heading)|position/(lat|long|distance|ecef|eci|from-start|vrp-.*(lat|long))"
)

_UNITS = {
    "-fps": "ft/s",
    "-ft": "ft",
    "-deg": "deg",
    "-rad": "rad",
    "-rad_sec": "rad/s",
    "-rad_sec2": "rad/s2",
    "-ft_sec2": "ft/s2",
    "-deg_sec": "deg/s",
    "-kts": "kt",
    "-lbs": "lbf",
    "-norm": "norm",
    "-sec": "s",
    "-inhg": "inHg",
    "-rpm": "rpm",
    "-psf": "lbf/ft2",
}


def unit_of(name: str) -> str:
    """The unit in JSBSim's name of a property; "" if it has none."""
    base = re.sub(r"\[\d+\]$", "", name)
    suffixes = sorted((s for s in _UNITS if base.endswith(s)), key=len)
    return _UNITS[suffixes[-1]] if suffixes else ""


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
    """Whether a quantity is an ignorable coordinate, on which the dynamics do not depend."""
    return any(_IGNORABLE.match(name) for name in channel.properties)


def acceleration(channel: Channel) -> bool:
    """Whether a quantity may jump with an input."""
    return any(name.startswith("accelerations/") for name in channel.properties)


def as_shown(channel: Channel, value: float) -> float:
    """A property's value in the channel's unit, as at the ports: a heading of 360 is 0."""
    value = channel.factor * value
    return 0.0 if channel.unit == "deg" and value > ALMOST_NORTH else value


def full_circle(channel: Channel) -> float:
    """The period of an angle in its unit; 0 for other quantities."""
    return {"deg": 360.0, "rad": 2.0 * math.pi}.get(channel.unit, 0.0)
