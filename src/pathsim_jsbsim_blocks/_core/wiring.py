"""Mistakes in the wiring of a diagram, named by block and port.

PathSim runs on with these.
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

# those of which nothing has to be said again; a changed diagram has another
_checked: WeakSet[Graph] = WeakSet()


def warn_of_wiring(sim: Simulation) -> None:
    """Warn, at the user's line, of what looks like a mistake in the wiring of a diagram.

    That is a wired block that is not in the simulation, two wires into one port, an input without
    a wire whose 0 is a value of its own, a command or a wind that goes nowhere, and commands with
    the gains of another aircraft. `fly`, the command line, ``load_diagram``, batches, environments
    and the export call this.

    Warns
    -----
    RuntimeWarning
        for each mistake; again only after the diagram was changed
    """
    if sim.graph in _checked and not is_dirty(sim):
        return
    _checked.add(sim.graph)
    for message in dict.fromkeys(_mistakes(sim)):
        warn_user(message)


def _mistakes(sim: Simulation) -> Iterator[str]:
    blocks, connections = contents(sim)
    known = {id(block) for block in blocks}
    starts: set[tuple[int, int]] = set()
    ends: dict[tuple[int, int], tuple[Block, int]] = {}
    leads: dict[Block, list[tuple[int, Block, int]]] = defaultdict(list)
    # what enters a subsystem comes out of its interface, and the reverse, at the same port
    faces = {b: b.interface for b in blocks if isinstance(b, Subsystem)}
    faces |= {inside: box for box, inside in faces.items()}
    for connection in connections:
        for source, i, target, j in _wires(connection):
            starts.add((id(source), i))
            if not (connection and source):
                continue  # switched off: another wire may take its place
            leads[source].append((i, faces.get(target, target), j))
            for block in (source, target):
                if id(block) not in known:
                    known.add(id(block))
                    wire = (
                        f"{_port(source, i, source.outputs)} to {_port(target, j, target.inputs)}"
                    )
                    yield (
                        f"{name_of(block)} is wired ({wire}), but it is not among the blocks of "
                        "the simulation: it does nothing"
                    )
            other, k = ends.setdefault((id(target), j), (source, i))
            if (other, k) != (source, i):
                # by name and by number; the same words twice PathSim refuses
                yield (
                    f"two wires lead into {_port(target, j, target.inputs)}, from "
                    f"{_port(other, k, other.outputs)} and {_port(source, i, source.outputs)}: "
                    "use an Adder. One of them has no effect"
                )
    for block in blocks:
        for i in _numbers(getattr(block, "_places", ()), block.inputs):
            if (id(block), i) not in ends:
                yield f"{_port(block, i, block.inputs)} is 0: no wire leads to it"
        commands: Mapping[str, str] = getattr(block, "commands", {})
        for command, switch in commands.items():
            (i,), wired = _numbers([command], block.outputs), {j for b, j in ends if b == id(block)}
            if (id(block), i) not in starts and not wired & {*_numbers([switch], block.inputs)}:
                yield f"{_port(block, i, block.outputs)} goes nowhere: no wire leads from it"
        if models := getattr(block, "tuned_for", ()):
            for plane in _flown(leads, faces, block, _numbers(commands, block.outputs)):
                if plane.model_name not in models:
                    whose = f"{name_of(block)} has the gains of {' and '.join(models)}"
                    yield f"{whose}, but flies {name_of(plane)}, which is {plane.model_name}"
        if getattr(block, "is_wind", False) and not any(b == id(block) for b, _ in starts):
            yield f"{name_of(block)} blows nowhere: no wire leads from it"


def _flown(leads: Any, faces: Any, block: Block, ports: list[int]) -> list[Any]:
    """The aircraft that outputs of a block lead to, through others without gains."""
    reached = [(target, j) for i, target, j in leads[block] if i in ports]
    for other, port in reached:  # it grows
        if not (hasattr(other, "model_name") or hasattr(other, "tuned_for")):
            ways = [(b, j) for i, b, j in leads[other] if other not in faces or i == port]
            reached += [way for way in ways if way not in reached]
    return [other for other, _ in reached if hasattr(other, "model_name")]


def _wires(connection: Connection) -> Iterator[tuple[Block, int, Block, int]]:
    """Source and output, target and input, of each wire."""
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


def _numbers(ports: Iterable[Any], register: Register) -> list[Any]:
    # a look-up by the register itself would mark the port as wired
    return [port_names(register).get(port, port) for port in ports]


def _port(block: Block, number: int, register: Register) -> str:
    names = {i: name for name, i in port_names(register).items()}
    return f"{name_of(block)}[{names.get(number, number)!r}]"


def name_of(block: Block) -> str:
    """The user's variable of a block; its class where there is none."""
    for frame in filter(is_users, frames()):
        for variables in (frame.f_locals, frame.f_globals):
            for name, value in list(variables.items()):
                if value is block and not name.startswith("_"):
                    return name
    return type(block).__name__
