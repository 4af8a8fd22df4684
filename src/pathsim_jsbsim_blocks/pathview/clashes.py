"""Rename blocks and events whose variables collide in PathView's script.

Otherwise the script rebinds the name: a parameter that refers to a value of the code would get a
block, and a subsystem or the simulation that lists a block would get another one.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection
from pathlib import Path
from typing import NoReturn

from ..errors import DiagramError
from .shape import Json
from .variables import plain, prefix_inside

# names that PathView's script binds in addition to the blocks and the code
_GENERATED = {"np", "plt", "blocks", "connections", "events", "sim"}
_NAMELESS = {"Interface", "BusCreator", "BusSelector"}  # have no variable of their own name


def without_clashes(
    content: Json, assigned: Collection[str], called_later: Collection[str], path: Path
) -> Json:
    """A complete model with new names where a variable would be bound twice.

    The outer block or event keeps its name; within one level, the first does. ``assigned`` are
    names that the code binds, and built-in functions that it uses; ``called_later`` are names to
    which functions refer.

    Raises
    ------
    DiagramError
        if renaming would be ambiguous: a name used in a function, or the name of a subsystem, which
        is the prefix of the names of its blocks
    """
    clashes = _Clashes({*assigned, *_GENERATED}, called_later, path)
    # a model's own events stand beside its graph, those of subsystems in it
    graph = clashes.without({**content["graph"], "events": content["events"]}, "")
    return {**content, "graph": graph, "events": graph["events"]}


class _Clashes:
    def __init__(self, bound: Collection[str], called_later: Collection[str], path: Path):
        self.bound, self.called_later, self.path = bound, called_later, path
        self.taken: set[str] = set()  # variables of the levels done so far

    def without(self, graph: Json, prefix: str) -> Json:
        wishes = {_variable(part, prefix) for part in (*graph["nodes"], *graph["events"])}
        nodes = [self._renamed(n, "block", prefix, wishes) for n in graph["nodes"]]
        events = [self._renamed(e, "event", prefix, wishes) for e in graph["events"]]
        return {**graph, "nodes": [self._inside(n, prefix) for n in nodes], "events": events}

    def _inside(self, node: Json, prefix: str) -> Json:
        if node["type"] != "Subsystem" or "graph" not in node:
            return node
        return {**node, "graph": self.without(node["graph"], _inner(node, prefix))}

    def _renamed(self, part: Json, kind: str, prefix: str, wishes: Collection[str]) -> Json:
        if part["type"] in _NAMELESS:
            return part
        if part["type"] == "Subsystem":
            # its name is the prefix of its blocks' names, so it is refused instead of renamed
            for name in sorted(self._variables(part, prefix) & {*self.bound}):
                self._refuse(f"subsystem {part['name']!r}", name)
        name = _variable(part, prefix)
        if name in self.bound and name in self.called_later:
            self._refuse(f"{kind} {part['name']!r}", name)
        if (
            not plain(part["name"])
            or name in self.bound
            or (self._variables(part, prefix) & self.taken)
        ):
            wish = f"{part['name']} {kind}" if plain(part["name"]) else kind
            names = itertools.chain([wish], (f"{wish} {i}" for i in itertools.count(2)))
            used = {*self.bound, *self.taken, *wishes}
            part = next(
                p
                for p in ({**part, "name": n} for n in names)
                if not self._variables(p, prefix) & used
            )
        self.taken |= self._variables(part, prefix)
        return part

    @staticmethod
    def _variables(part: Json, prefix: str) -> set[str]:
        if part["type"] != "Subsystem":
            return {_variable(part, prefix)}
        return {_variable(part, prefix), f"{_inner(part, prefix)}interface"}

    def _refuse(self, what: str, name: str) -> NoReturn:
        raise DiagramError(
            f"{what}: the model's code uses the name {name!r} for something else; "
            "rename one of them",
            path=self.path,
        )


def _variable(part: Json, prefix: str) -> str:
    # PathView puts nothing before a subsystem in a subsystem
    return ("" if part["type"] == "Subsystem" else prefix) + plain(part["name"])


def _inner(subsystem: Json, prefix: str) -> str:
    return prefix_inside(subsystem["name"], prefix)
