"""Mistakes in the connections of a diagram, named by block and port.

PathSim runs diagrams with such mistakes without a warning.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any
from weakref import WeakSet

from pathsim import Connection, Simulation, Subsystem
from pathsim.blocks import Block
from pathsim.utils.graph import Graph
from pathsim.utils.register import Register

from .callers import frames, is_users, warn_user
from .pathsim_internals import is_dirty, port_names

# graphs that were checked already; a changed diagram has a new graph
_checked: WeakSet[Graph] = WeakSet()


def warn_of_wiring(sim: Simulation) -> None:
    """Warn, at the user's line, about probable mistakes in the connections of a diagram.

    These are a connected block that is not in the simulation, a connection outside a subsystem from
    a block inside, two connections to one port, an unconnected input that must not read 0, an
    unconnected command or wind, and commands with the gains of another aircraft. The first sample
    of a run calls this, and `fly` for a diagram without samples; ``load_diagram``, environments and
    the export call it before a run.

    Warns
    -----
    RuntimeWarning
        for each mistake; again only after the diagram was changed
    """
    # a diagram that was changed has its new graph when a run begins
    if is_dirty(sim) or sim.graph in _checked:
        return
    _checked.add(sim.graph)
    for message in dict.fromkeys(_mistakes(sim)):
        warn_user(message)


def _mistakes(sim: Simulation) -> Iterator[str]:
    blocks, connections = contents(sim)
    ids, crossing = {id(block) for block in blocks}, {id(c) for c in _crossing(sim)}
    starts: set[tuple[int, int]] = set()
    ends: dict[tuple[int, int], tuple[Block, int]] = {}
    leads: dict[Block, list[tuple[int, Block, int]]] = defaultdict(list)
    # a subsystem's inputs are its interface's outputs, and the reverse, with the same numbers
    faces = {b: b.interface for b in blocks if isinstance(b, Subsystem)}
    faces |= {face: box for box, face in faces.items()}
    for connection in connections:
        for source, i, target, j in _wires(connection):
            starts.add((id(source), i))
            if not (connection and source):
                continue  # switched off: another connection may replace it
            leads[source].append((i, faces.get(target, target), j))
            if id(connection) in crossing and id(source) in ids:
                yield (
                    f"{name_of(source)} is connected ({_wire(source, i, target, j)}) outside its "
                    "subsystem, not by a port of it: it has no effect"
                )
            for block in (source, target):
                if id(block) not in ids:
                    ids.add(id(block))
                    yield (
                        f"{name_of(block)} is connected ({_wire(source, i, target, j)}), but not "
                        "among the blocks of the simulation: it has no effect"
                    )
            rival, k = ends.setdefault((id(target), j), (source, i))
            if (rival, k) != (source, i):
                # by name and by number; PathSim itself refuses the same key twice
                yield (
                    f"two connections lead to {_port(target, j, target.inputs)}, from "
                    f"{_port(rival, k, rival.outputs)} and {_port(source, i, source.outputs)}: "
                    "use an Adder. One of them has no effect"
                )
    for block in blocks:
        for i in _numbers(getattr(block, "_places", ()), block.inputs):
            if (id(block), i) not in ends:
                yield f"{_port(block, i, block.inputs)} is not connected and reads 0"
        commands: Mapping[str, str] = getattr(block, "commands", {})
        for command, switch in commands.items():
            (i,) = _numbers([command], block.outputs)
            inputs = {j for b, j in ends if b == id(block)}
            if (id(block), i) not in starts and not inputs & {*_numbers([switch], block.inputs)}:
                port = _port(block, i, block.outputs)
                yield f"{port} is not connected: the command has no effect"
        if models := getattr(block, "tuned_for", ()):
            for plane in _flown(leads, faces, block, _numbers(commands, block.outputs)):
                if plane.model_name not in models:
                    whose = f"{name_of(block)} has the gains of {' and '.join(models)}"
                    yield f"{whose}, but flies {name_of(plane)}, which is {plane.model_name}"
        if getattr(block, "is_wind", False) and not any(b == id(block) for b, _ in starts):
            yield f"{name_of(block)} is not connected: the wind has no effect"


def _flown(leads: Any, faces: Any, block: Block, ports: list[int]) -> list[Any]:
    """The aircraft connected to outputs of a block, directly or through blocks without gains."""
    ends = [(target, j) for i, target, j in leads[block] if i in ports]
    for sink, port in ends:  # the list grows in the loop
        if not (hasattr(sink, "model_name") or hasattr(sink, "tuned_for")):
            ways = [(b, j) for i, b, j in leads[sink] if sink not in faces or i == port]
            ends += [way for way in ways if way not in ends]
    return [sink for sink, _ in ends if hasattr(sink, "model_name")]


def _wires(connection: Connection) -> Iterator[tuple[Block, int, Block, int]]:
    """Source and output, target and input, of each signal of a connection."""
    source = connection.source.block
    outputs = _numbers(connection.source.ports, source.outputs)
    for end in connection.targets:
        inputs = _numbers(end.ports, end.block.inputs)
        yield from ((source, i, end.block, j) for i, j in zip(outputs, inputs, strict=True))


def contents(diagram: Simulation | Subsystem) -> tuple[list[Block], list[Connection]]:
    """Blocks and connections, those in subsystems included."""
    blocks, connections = list(diagram.blocks), list(diagram.connections)
    for block in diagram.blocks:
        if isinstance(block, Subsystem):
            inner = contents(block)
            blocks += [block.interface, *inner[0]]
            connections += inner[1]
    return blocks, connections


def _crossing(diagram: Simulation | Subsystem) -> Iterator[Connection]:
    """Connections from a block that is not beside them, but in a subsystem or around it."""
    neighbours = {id(block) for block in [*diagram.blocks, getattr(diagram, "interface", None)]}
    yield from (c for c in diagram.connections if id(c.source.block) not in neighbours)
    for block in diagram.blocks:
        if isinstance(block, Subsystem):
            yield from _crossing(block)


def _numbers(ports: Iterable[Any], register: Register) -> list[Any]:
    # not by the register's own look-up, which would mark the port as connected
    return [port_names(register).get(port, port) for port in ports]


def _port(block: Block, number: int, register: Register) -> str:
    names = {i: name for name, i in port_names(register).items()}
    return f"{name_of(block)}[{names.get(number, number)!r}]"


def _wire(source: Block, i: int, target: Block, j: int) -> str:
    # names are looked up in the frames of callers: only for a message
    return f"{_port(source, i, source.outputs)} to {_port(target, j, target.inputs)}"


def name_of(block: Block) -> str:
    """The user's variable of a block, or else its class."""
    for frame in filter(is_users, frames()):
        for variables in (frame.f_locals, frame.f_globals):
            for name, value in list(variables.items()):
                if value is block and not name.startswith("_"):
                    return name
    return type(block).__name__
