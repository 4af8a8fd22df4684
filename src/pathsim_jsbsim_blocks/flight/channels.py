"""The ports of an aircraft as JSBSim properties with units."""

from __future__ import annotations

import re
from dataclasses import dataclass

from .._core.aircraft_ports import OUTPUTS


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
