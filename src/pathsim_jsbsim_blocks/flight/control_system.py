"""An aircraft's own control system: channels, components, inputs and outputs, as its XML says."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

import jsbsim

from .model_files import ModelFile

_SECTIONS = ("system", "autopilot", "flight_control")  # in the order in which JSBSim loads them
_PROPERTY = re.compile(r"-?(/?[A-Za-z_][\w.-]*(?:\[\d+\])?(?:/[\w.-]+(?:\[\d+\])?)+)")
_PARTS = {"property", "documentation", "description", "function"}  # of a channel: no components


class Component(NamedTuple):
    """A component of a channel: its type is the XML's."""

    type: str
    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


class ControlChannel(NamedTuple):
    """A channel of a section, which is "flight_control", "autopilot" or "system"."""

    section: str
    name: str
    components: tuple[Component, ...]


def control_system(aircraft: str, root: str | None = None) -> list[ControlChannel]:
    """The channels of an aircraft's control system, in the order in which they run."""
    file = ModelFile(aircraft, root)
    model = file.parsed()
    return [
        ControlChannel(tag, channel.get("name", ""), _components(channel))
        for tag in _SECTIONS
        for element in model.findall(tag)
        for section in [_section(file, element, root)]
        for channel in section.findall("channel")
    ]


def _section(file: ModelFile, element: ET.Element, root: str | None) -> ET.Element:
    """A section, from its own file if it has one."""
    name = element.get("file")
    if name is None:
        return element
    systems = Path(jsbsim.get_default_root_dir() if root is None else root, "systems")
    folder = file.path.parent
    for place in (folder, folder / "Systems", systems):
        path = place / name
        for found in (path, path.with_name(f"{path.name}.xml")):
            if found.is_file():
                return file.parsed(found)
    raise file.error(f"aircraft {file.aircraft!r} has no file {name!r} of its control system")


def _components(channel: ET.Element) -> tuple[Component, ...]:
    return tuple(_component(part) for part in channel if part.tag not in _PARTS)


def _component(part: ET.Element) -> Component:
    name = part.get("name", "").strip()
    # as JSBSim makes a property of it
    own = name if "/" in name else f"fcs/{name.lower().replace(' ', '-')}"
    written = [(x.text or "").strip() for x in part.iter("output")]
    read: list[str] = []
    for x in part.iter():
        if x.tag not in ("output", "description"):
            for text in (x.text, x.get("value")):
                read += _PROPERTY.findall(text or "")
    outputs = dict.fromkeys([own, *filter(None, written)])
    return Component(part.tag, name, tuple(dict.fromkeys(read)), tuple(outputs))
