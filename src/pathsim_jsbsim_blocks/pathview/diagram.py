"""A block diagram as plain data: the content of a script, before it becomes a model file."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from .toolboxes import Toolbox

NOTE = "docstring"  # the id of the note that holds the script's docstring


class Wire(NamedTuple):
    """From an output of a node to an input of a node, each by its index in the graph."""

    source: int
    output: int
    target: int
    input: int


@dataclass
class Node:
    """One block. ``params`` are Python expressions; ``graph`` is what is inside a subsystem.

    ``line`` is where the script builds it, ``part`` the ``id`` of the block there.
    """

    name: str
    type: str
    params: dict[str, str] = field(default_factory=dict)
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    graph: Graph | None = None
    line: int | None = None
    part: int | None = None


@dataclass
class Event:
    """One event. ``type`` is the class with its module, as PathView writes it."""

    name: str
    type: str
    params: dict[str, str]


@dataclass
class Graph:
    """The nodes of one level and the wires between them."""

    nodes: list[Node]
    wires: list[Wire]
    events: list[Event]


@dataclass
class Diagram:
    """All of a diagram script that PathView can represent.

    ``log`` tells whether the simulation logs; ``code_values`` has, as texts, what the
    script has under the names that its code needs.
    ``parts`` has, by the variable in PathView's script, each block and event of the script, and of
    each of its parameters whether an expression of the source gives it. ``places`` has lines of
    the script by lines of ``context``.
    """

    path: Path
    docstring: str
    graph: Graph
    context: str
    settings: dict[str, str]
    toolboxes: list[Toolbox]
    log: bool = True
    code_values: dict[str, str] = field(default_factory=dict)
    places: dict[int, int] = field(default_factory=dict)
    parts: dict[str, tuple[Any, dict[str, bool]]] = field(default_factory=dict)
