"""The elements of a DAVE-ML file with their lines. Only the file itself is read."""

from __future__ import annotations

import itertools
import math
import os
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat

from .._core.checks import did_you_mean, nearest
from .._core.files import as_path
from ..errors import DaveMLError, FileError

# beyond any published model: a malformed file is refused instead of filling the memory
_MOST_BYTES = 32_000_000
_MOST_ELEMENTS = 500_000
_MOST_DEPTH = 64

_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")

# models that come with the package, found by their names alone
_MODELS = Path(__file__).resolve().parent / "models"


@dataclass
class Element:
    """An element: its name without prefix, attributes, line, children and the text in between."""

    tag: str
    attributes: dict[str, str]
    line: int
    path: Path
    children: list[Element] = field(default_factory=list)
    text: str = ""

    def error(self, reason: str, variable: str = "", name: str = "", of: Iterable[str] = ()) -> Any:
        """The error at this element; it suggests the entries of ``of`` nearest to ``name``."""
        close = did_you_mean(nearest(name, of)) if name else ""
        return DaveMLError(reason + close, path=self.path, line=self.line, variable=variable)

    def all(self, *tags: str) -> Iterator[Element]:
        return (child for child in self.children if child.tag in tags)

    def has(self, *tags: str) -> bool:
        return any(self.all(*tags))

    def one(self, *tags: str) -> Element:
        """The only child with one of these names."""
        matches = [*self.all(*tags)]
        if len(matches) != 1:
            raise self.error(f"{self.tag} needs one {' or '.join(tags)}, not {len(matches)}")
        return matches[0]

    def only(self, *tags: str) -> None:
        """Refuse children of other names."""
        for child in self.children:
            if child.tag not in tags:
                reason = f"{self.tag} has no element {child.tag!r}"
                raise child.error(reason, name=child.tag, of=tags)

    def get(self, name: str, *choices: str) -> str:
        """An attribute, by default the first of the ``choices``; without these it is required."""
        value = self.attributes.get(name, choices[0] if choices else "")
        if not value or (choices and value not in choices):
            hint = f"; it must be one of {', '.join(choices)}" if choices else ""
            raise self.error(f"{self.tag} has {name}={value!r}{hint}", name=value, of=choices)
        return value

    def number(self, name: str, default: Any) -> Any:
        """The number in an attribute."""
        return self.parse(self.attributes[name]) if name in self.attributes else default

    def numbers(self) -> list[float]:
        """The numbers in the text, between commas and blanks."""
        return [self.parse(part) for part in re.split(r"[\s,]+", self.text) if part]

    def parse(self, text: str) -> float:
        x = float(text) if _NUMBER.fullmatch(text.strip()) else math.nan
        if not math.isfinite(x):
            raise self.error(f"{self.tag}: {text.strip()[:40]!r} is not a number")
        return x


def read_elements(file: Any) -> Element:
    """The root element of a file. Its DTD is never fetched, and entities are refused."""
    path = as_path("file", file)
    if path.name == str(path) and not os.path.exists(path) and os.path.exists(_MODELS / path):
        path = _MODELS / path
    try:
        if os.path.exists(path) and not os.path.isfile(path):  # reading a pipe would wait
            raise OSError("not a file")
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
    except OSError as error:
        close = ""
        if isinstance(error, FileNotFoundError):
            close = did_you_mean(nearest(path.name, sorted(os.listdir(_MODELS))))
        raise FileError("read", path, error, close) from None
    if len(content) > _MOST_BYTES:
        raise DaveMLError(f"larger than {_MOST_BYTES / 1e6:g} MB", path=path)
    return _parsed(content, path)


def _parsed(content: bytes, path: Path) -> Element:
    document = Element("", {}, 0, path)
    open_elements, count = [document], itertools.count(1)
    # joined at an element's end: appending to its text would take quadratic time
    texts: list[list[str]] = [[]]
    parser = expat.ParserCreate()
    parser.buffer_text = True

    def refuse(reason: str) -> None:
        raise DaveMLError(reason, path=path, line=parser.CurrentLineNumber)

    def start(tag: str, attributes: dict[str, str]) -> None:
        if next(count) > _MOST_ELEMENTS or len(open_elements) > _MOST_DEPTH:
            refuse(f"more than {_MOST_ELEMENTS} elements, or nested deeper than {_MOST_DEPTH}")
        element = Element(tag.rpartition(":")[2], attributes, parser.CurrentLineNumber, path)
        open_elements[-1].children.append(element)
        texts[-1].append(" ")
        open_elements.append(element)
        texts.append([])

    def end(tag: str) -> None:
        open_elements.pop().text = "".join(texts.pop())

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = lambda data: texts[-1].append(data)
    # entities of the file's own DOCTYPE, and of a DTD, which is not fetched
    parser.EntityDeclHandler = lambda *_: refuse("entities are not allowed: write their text")
    parser.SkippedEntityHandler = lambda name, _: refuse(f"the entity {name!r} is not known")
    try:
        parser.Parse(content, True)
    except DaveMLError:
        raise
    except (expat.ExpatError, LookupError, ValueError) as error:  # LookupError: the encoding
        line = getattr(error, "lineno", 1)
        raise DaveMLError(f"not XML: {error}", path=path, line=line) from None
    return document.children[0]
