"""Types of a model's engines, from its XML: JSBSim's Python has no engine objects."""

from __future__ import annotations

import functools
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

from .references import model_file

# types by the root elements of the files of engines and thrusters
_KINDS = {
    "piston_engine": "piston",
    "turbine_engine": "turbine",
    "turboprop_engine": "turboprop",
    "rocket_engine": "rocket",
    "electric_engine": "electric",
    "brushless_dc_motor": "electric",
    **{name: name for name in ("propeller", "nozzle", "direct", "rotor")},
}


class Engine(NamedTuple):
    """One engine of a model.

    Attributes
    ----------
    number : int
        its number, from 0
    type : str
        "piston", "turbine", "turboprop", "rocket", "electric", or "unknown" if its file cannot be
        read
    thruster : str
        "propeller", "nozzle", "direct", "rotor" or "unknown"
    tanks : tuple[int, ...]
        numbers of the tanks that feed it
    """

    number: int
    type: str
    thruster: str
    tanks: tuple[int, ...]

    @property
    def burns(self) -> bool:
        """Whether it needs fuel."""
        return self.type in ("piston", "turbine", "turboprop", "rocket")

    @property
    def is_marked(self) -> bool:
        """Whether JSBSim marks it as running, ``propulsion/engine[i]/set-running``, or stopped."""
        return self.type in ("piston", "turbine", "turboprop")

    @property
    def follows_throttle(self) -> bool:
        """Whether only its throttle can stop it."""
        return self.type in ("electric", "rocket")


class _Part(NamedTuple):
    """An engine or a thruster as an element: the elements in it, and the file it names."""

    tags: tuple[str, ...]
    file: str | None

    @classmethod
    def of(cls, element: ET.Element | None) -> _Part:
        if element is None:
            return cls((), None)
        return cls(tuple(child.tag for child in element), element.get("file"))


def engines_of(model: Path, number: int) -> tuple[Engine, ...]:
    """The engines in a model's file, of which JSBSim has loaded ``number``."""
    try:
        parts, file = _parts(model, model.stat().st_mtime_ns)
        if file:
            other = _with_suffix(model.parent / file)
            parts, _ = _parts(other, other.stat().st_mtime_ns)
        kind = functools.cache(functools.partial(_kind, model))  # most engines are alike
        engines = [Engine(i, kind(e), kind(t), tanks) for i, (e, t, tanks) in enumerate(parts)]
    except (ET.ParseError, ValueError, LookupError, OSError):
        engines = []  # JSBSim has read what Python cannot
    if len(engines) != number:
        engines = [Engine(i, "unknown", "unknown", ()) for i in range(number)]
    return tuple(engines)


# by the time of change: many aircraft of one model are loaded
@functools.lru_cache(maxsize=128)
def _parts(path: Path, changed: int) -> tuple[list[tuple[_Part, _Part, tuple[int, ...]]], str]:
    """Engine, thruster and tanks of each engine in a file, or else the file of its propulsion."""
    root = ET.parse(path).getroot()
    propulsion = root if root.tag == "propulsion" else root.find("propulsion")
    if propulsion is None:
        return [], ""
    tanks, parts = len(propulsion.findall("tank")), []
    for element in propulsion.findall("engine"):
        feeds = (int(float(feed.text or 0)) for feed in element.findall("feed"))
        of = tuple(tank for tank in feeds if 0 <= tank < tanks)
        parts.append((_Part.of(element), _Part.of(element.find("thruster")), of))
    return parts, propulsion.get("file", "")


def _kind(model: Path, part: _Part) -> str:
    """The type of an engine or thruster, from an element in it or the root of its file."""
    tags = part.tags
    if part.file:
        file = model_file("engine", part.file, model.parent, model.parents[2])
        if file.is_file():
            tags = *tags, _tag(file, file.stat().st_mtime_ns)
    return next((_KINDS[tag] for tag in tags if tag in _KINDS), "unknown")


@functools.lru_cache(maxsize=256)
def _tag(path: Path, changed: int) -> str:
    """The name of a file's root element."""
    with path.open("rb") as file:
        _, root = next(iter(ET.iterparse(file, events=("start",))))
    return str(root.tag)


def _with_suffix(path: Path) -> Path:
    return path if path.suffix == ".xml" else path.with_name(f"{path.name}.xml")
