"""A block diagram as plain data: the content of a script, before it becomes a model file."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pathsim import Connection
from pathsim.blocks import Block

from .._core.pathsim_internals import port_number
from .toolboxes import Toolbox

NOTE = "docstring"  # the id of the note that holds the script's docstring


class Wire(NamedTuple):
    """From an output of a node to an input of a node, each by its index in the graph."""

    source: int
    output: int
    target: int
    input: int


def ends(connection: Connection) -> Iterator[tuple[Block, int, Block, int]]:
    """The wires of a connection: block and output, block and input."""
    source = connection.source
    for target in connection.targets:
        for out, into in zip(source.ports, target.ports, strict=True):
            numbers = port_number(source.block.outputs, out), port_number(target.block.inputs, into)
            yield source.block, numbers[0], target.block, numbers[1]


@dataclass
class Node:
    """One block. ``params`` are Python expressions; ``graph`` is what is inside a subsystem."""

    name: str
    type: str
    params: dict[str, str] = field(default_factory=dict)
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    graph: Graph | None = None


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
class Part:
    """A block or an event of the script on its way to a node."""

    target: Node | Event
    value: Any
    kind: type  # PathView's class
    parent: Part | None = None  # the subsystem around it
    arguments: dict[str, Any] = field(default_factory=dict)  # values with which it is built
    variable: str = ""  # in PathView's script


@dataclass
class Diagram:
    """All of a diagram script that PathView can represent."""

    path: Path
    docstring: str
    graph: Graph
    context: str  # the model's code
    settings: dict[str, str]
    duration: float  # of the run, s
    toolboxes: list[Toolbox]
    log: bool = True  # whether the simulation logs
    unseeded: list[str] = field(default_factory=list)  # blocks that draw without a seed
    parts: dict[str, Part] = field(default_factory=dict)  # by their variables
