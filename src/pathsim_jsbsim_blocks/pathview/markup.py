"""Text of a model that PathView's page would take for HTML."""

from __future__ import annotations

import re
from pathlib import Path

from ..errors import DiagramError
from .shape import Json, graphs

# the page escapes a name without a formula; beside a formula it escapes nothing
_FORMULA = re.compile(r"\$[^$\n]+\$")
_TAG = re.compile(r"<[A-Za-z/!?]")
# the page escapes a note, but not the quotes in its links' addresses
_LINK = re.compile(r"\[[^\]]+\]\(([^)]+)\)")
_ADDRESS = re.compile(r"(https?://|mailto:)[^\s\"']*", re.IGNORECASE)


def refuse_markup(content: Json, path: Path) -> None:
    """Refuse a name with HTML beside a formula, and a note with a link to anything but the web."""
    parts, addresses = [*(content.get("events") or [])], []
    for graph in graphs(content):
        parts += [*(graph.get("nodes") or []), *(graph.get("events") or [])]
        for note in graph.get("annotations") or []:
            addresses += _LINK.findall(str(note.get("content", "")))
    for part in parts:
        ports = [*part.get("inputs", []), *part.get("outputs", [])]
        for text in [part["name"], *(port.get("name") or "" for port in ports)]:
            if _FORMULA.search(text) and _TAG.search(_FORMULA.sub("", text)):
                raise DiagramError(f"the name {text!r} has HTML beside a formula", path=path)
    for address in addresses:
        if not _ADDRESS.fullmatch(address):
            raise DiagramError(f"an annotation's link is not a web address: {address!r}", path=path)
