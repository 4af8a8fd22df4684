"""Servos with hysteresis behind a command, from the XML files of a model."""

from __future__ import annotations

import contextlib
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from pathlib import Path


def hysteresis(folder: Path, commands: Sequence[str]) -> dict[str, float]:
    """Widths of hysteresis downstream of the commands, by property, in its unit."""
    components = list(_components(folder))
    reached, widths, size = set(commands), dict[str, float](), 0
    while len(reached) > size:
        size = len(reached)
        for component in components:
            texts = {(e.text or "").strip().lstrip("-") for e in component.iter()}
            if texts & reached:
                name = component.get("name", "").lower().replace(" ", "-")
                name = name if "/" in name else f"fcs/{name}"
                reached |= {name, *(e.text.strip() for e in component.iter("output") if e.text)}
                with contextlib.suppress(ValueError):
                    widths[name] = float(component.findtext("hysteresis_width", ""))
    return {name: width for name, width in widths.items() if width > 0.0}


def _components(folder: Path) -> Iterator[ET.Element]:
    """The components of all channels."""
    for path in sorted(folder.rglob("*.xml")):
        with contextlib.suppress(ET.ParseError, ValueError, LookupError, OSError):
            for channel in ET.parse(path).iter("channel"):
                yield from channel
