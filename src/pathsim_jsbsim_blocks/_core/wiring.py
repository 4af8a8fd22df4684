"""Mistakes in the wiring of a diagram, named by block and port.

PathSim refuses some without a name, or fails on them elsewhere, and runs on with the others.
"""

from __future__ import annotations

import reprlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any
from weakref import WeakKeyDictionary

from pathsim import Connection, Simulation, Subsystem
from pathsim.blocks import Block
from pathsim.utils.portreference import PortReference
from pathsim.utils.register import Register

from .callers import frames, is_users, warn_user
from .checks import refuse
from .pathsim_internals import before_runs, check_diagrams, port_names

_warned: WeakKeyDictionary[Simulation, set[str]] = WeakKeyDictionary()


def warn_of_wiring(sim: Simulation, reset: bool) -> None:
    """Warn of each mistake once in the life of a diagram, at the user's line."""
    warned = _warned.setdefault(sim, set())
    for message in dict.fromkeys(_mistakes(sim)):
        if message not in warned:
            warned.add(message)
            warn_user(message)


before_runs.append(warn_of_wiring)


def _mistakes(sim: Simulation) -> Iterator[str]:
    blocks, connections = contents(sim)
    known = {id(block) for block in blocks}
    starts: set[tuple[int, int]] = set()
    ends: dict[tuple[int, int], tuple[Block, int]] = {}
    for connection in connections:
        for source, i, target, _, j in _wires(connection):
            starts.add((id(source), i))
            if not (connection and source):
                continue  # switched off: another wire may take its place
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
                yield f"{_conflict(other, k, source, i, target, j)}. One of them has no effect"
    for block in blocks:
        for i in _numbers(getattr(block, "places", ()), block.inputs):
            if (id(block), i) not in ends:
                yield f"{_port(block, i, block.inputs)} is 0: no wire leads to it"
        commands: Mapping[str, str] = getattr(block, "commands", {})
        for command, switch in commands.items():
            (i,), wired = _numbers([command], block.outputs), {j for b, j in ends if b == id(block)}
            if (id(block), i) not in starts and not wired & {*_numbers([switch], block.inputs)}:
                yield f"{_port(block, i, block.outputs)} goes nowhere: no wire leads from it"


def _wires(connection: Connection) -> Iterator[tuple[Block, int, Block, int | str, int]]:
    """Source and output, target and input, as it is written and by number, of each wire."""
    source = connection.source.block
    outputs = _numbers(connection.source.ports, source.outputs)
    for target, ports in ((end.block, end.ports) for end in connection.targets):
        for i, port, j in zip(outputs, ports, _numbers(ports, target.inputs), strict=True):
            yield source, i, target, port, j


def _conflict(one: Block, i: int, other: Block, k: int, target: Block, j: int) -> str:
    return (
        f"two wires lead into {_port(target, j, target.inputs)}, from "
        f"{_port(one, i, one.outputs)} and {_port(other, k, other.outputs)}: use an Adder"
    )


def _check_wires(connections: Sequence[Connection]) -> None:
    """Refuse two wires into one port."""
    ends: dict[tuple[int, int | str], tuple[Block, int]] = {}
    for connection in connections:
        for source, i, target, port, j in _wires(connection):
            if (id(target), port) in ends:
                message = _conflict(*ends[id(target), port], source, i, target, j)
                refuse("connections", connection, message)
            ends[id(target), port] = source, i


def _check_ends(_: Connection, *ends: Any, **named: Any) -> None:
    """Refuse a wire to or from what is no block."""
    for end in (*ends, *named.values()):
        if not isinstance(end, (Block, PortReference)):
            why = f"{_called(end)} is no Block: a connection joins ports of blocks"
            refuse("connections", end, why)


def _check_wire(connection: Connection) -> None:
    """Refuse a wire whose ends have different numbers of ports."""
    for target in connection.targets:
        if len(target) != len(connection.source):
            start, end = connection.source, target
            why = f"{_called(start)} has {len(start)} port{'s' * (len(start) > 1)} and "
            why += f"{_called(end)} has {len(end)}: each target of a connection needs as many "
            refuse("targets", connection, f"{why}ports as its source")


def _check_part(part: Any, kind: type) -> None:
    """Refuse what is no block, or no connection, in the list of them."""
    if isinstance(part, kind):
        return
    parameter = "blocks" if kind is Block else "connections"
    hint = ""
    if isinstance(part, (list, tuple)):
        hint = f": {parameter} are one list, without lists in it"
    elif isinstance(part, type):
        hint = f": build one with {part.__name__}(...)"
    elif isinstance(part, PortReference):
        hint = ": the list has the blocks themselves"
    refuse(parameter, part, f"{_called(part)} among the {parameter} is no {kind.__name__}{hint}")


def _called(part: Any) -> str:
    """What the user calls a part of a diagram."""
    if isinstance(part, (list, tuple)):
        return f"[{', '.join(map(_called, part))}]"
    if isinstance(part, PortReference):
        return f"{name_of(part.block)}[{', '.join(map(repr, part.ports))}]"
    if isinstance(part, Connection):
        return f"Connection({', '.join(map(_called, [part.source, *part.targets]))})"
    if isinstance(part, type):
        return part.__name__
    return name_of(part) if isinstance(part, Block) else reprlib.repr(part)


check_diagrams(_check_part, _check_ends, _check_wire, _check_wires)


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
