"""Properties to which the XML files of a model refer, whether they exist or not."""

from __future__ import annotations

import functools
import itertools
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

# "#" stands for the number of the engine
_STEP = r"[A-Za-z_][\w.-]*(?:\[(?:\d+|#)\])?"
_PATH = re.compile(rf"-?(/?{_STEP}(?:/{_STEP})+)")
_NAME = re.compile(rf"-?({_STEP})")
_TEST = re.compile(r"(\S+)\s+(?:[!=]=|[<>]=?|EQ|NE|[LG][ET]|eq|ne|[lg][et])\s+(\S+)")

# elements whose text is a property, even without a slash
_PROPERTIES = ("property", "p", "input", "independentVar")

# sections of a model that have no effect on its flight
_UNUSED = ("fileheader", "input", "output")

# folders of engine files, the model's own first (FGPropulsion)
_ENGINES = ("Engines", "engines", "Engine", "engine")


class _File(NamedTuple):
    """References of a file, each with the number of the enclosing engine element, or ""."""

    properties: list[tuple[str, str]]
    files: list[tuple[str, str, str]]  # element, file, engine


def references(model: Path, root: Path) -> list[str]:
    """Properties to which the files of a model below a JSBSim root refer, in order."""
    names: dict[str, None] = {}
    files = [(model, "")]
    for path, engine in files:
        stat = path.stat()
        content = _read(path, stat.st_mtime_ns, stat.st_size)
        for name, number in content.properties:
            names[name.replace("#", number or engine)] = None
        for element, file, number in content.files:
            included = model_file(element, file, model.parent, root), number or engine
            if included[0].is_file() and included not in files:
                files.append(included)
    return [name for name in names if "[]" not in name]


@functools.lru_cache(maxsize=256)
def _read(path: Path, changed: int, size: int) -> _File:
    """References of a file with this modification time and size; empty if it cannot be parsed."""
    content = _File([], [])
    try:
        root = ET.parse(path).getroot()
    except (ET.ParseError, ValueError, LookupError, OSError):
        return content
    for unused in [section for section in root if section.tag in _UNUSED]:
        root.remove(unused)
    for element, engine in _elements(root):
        content.properties.extend((name, engine) for name in _names(element))
        if file := element.get("file"):
            content.files.append((element.tag, file, engine))
    return content


def _elements(element: ET.Element, engine: str = "") -> Iterator[tuple[ET.Element, str]]:
    """An element and all below it, each with the number of the enclosing engine element."""
    yield element, engine
    number = itertools.count()
    for child in element:
        yield from _elements(child, str(next(number)) if child.tag == "engine" else engine)


def _names(element: ET.Element) -> Iterator[str]:
    """Properties in an element's text, tests and attributes."""
    texts = [element.text, *(child.tail for child in element)]
    lines = [line.strip() for text in texts if text for line in text.splitlines()]
    words = [word for line in lines if (test := _TEST.fullmatch(line)) for word in test.groups()]
    words += [(element.text or "").strip(), element.get("execute", ""), element.get("value", "")]
    pattern = _NAME if element.tag in _PROPERTIES else _PATH
    for word in words:
        if name := _PATH.fullmatch(word) or pattern.fullmatch(word):
            yield name[1]


def model_file(element: str, file: str, folder: Path, root: Path) -> Path:
    """The path at which JSBSim finds a file named by an element; it need not exist."""
    name = file if file.endswith(".xml") else f"{file}.xml"
    folders = [folder]
    if element in ("engine", "thruster"):
        folders = [*(folder / part for part in _ENGINES), root / "engine"]
    elif element == "system":
        folders = [folder, folder / "Systems", folder / "systems", root / "systems"]
    paths = [place / name for place in folders]
    return next(filter(Path.is_file, paths), paths[-1])
