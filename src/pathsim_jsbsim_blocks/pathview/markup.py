"""Text of a model that PathView's page would take for HTML."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import DiagramError

# the page escapes a name without a formula; beside a formula it escapes nothing
_FORMULA = re.compile(r"\$[^$\n]+\$")
_TAG = re.compile(r"<[A-Za-z/!?]")
# the page escapes a note, but not the quotes in its links' addresses
_LINK = re.compile(r"\[[^\]]+\]\(([^)]+)\)")
_ADDRESS = re.compile(r"(https?://|mailto:)[^\s\"']*", re.IGNORECASE)


def refuse_markup(content: dict[str, Any], path: Path) -> None:
    """Refuse a model with a text that the page does not show as text.

    Raises
    ------
    DiagramError
        if a name holds HTML beside a formula, or a note's link is not a web address
    """
    for text in _names(content):
        if _FORMULA.search(text) and _TAG.search(_FORMULA.sub("", text)):
            raise DiagramError(f"the name {text!r} holds HTML beside a formula", path=path)
    for note in _graphs(content.get("graph"), "annotations"):
        for address in _LINK.findall(str(note.get("content", ""))):
            if not _ADDRESS.fullmatch(address):
                raise DiagramError(
                    f"an annotation's link is not a web address: {address!r}", path=path
                )


def _names(content: dict[str, Any]) -> Iterator[str]:
    """Everything in a model that the page may show as a name or a label."""
    for node in _graphs(content.get("graph"), "nodes"):
        yield str(node.get("name", ""))
        for port in (*_dicts(node.get("inputs")), *_dicts(node.get("outputs"))):
            yield str(port.get("name", ""))
    for event in (*_dicts(content.get("events")), *_graphs(content.get("graph"), "events")):
        yield str(event.get("name", ""))


def _graphs(graph: Any, key: str) -> Iterator[dict[str, Any]]:
    """The items under ``key`` in a graph and in the graphs of its subsystems."""
    waiting = [graph]
    while waiting:
        graph = waiting.pop()
        if isinstance(graph, dict):
            yield from _dicts(graph.get(key))
            waiting += [node.get("graph") for node in _dicts(graph.get("nodes"))]


def _dicts(items: Any) -> list[dict[str, Any]]:
    return [i for i in items if isinstance(i, dict)] if isinstance(items, list) else []
