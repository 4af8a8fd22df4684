"""Blocks and events of a model that have a name of its code.

PathView's script would bind the name anew: where a parameter means the code's value, it would get a
block.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection
from pathlib import Path
from typing import Any, NoReturn

from ..errors import DiagramError
from .pvm import plain

Json = dict[str, Any]

# what PathView's script binds beside the blocks and the code
_GENERATED = {"np", "plt", "blocks", "connections", "events", "sim"}


def without_clashes(content: Json, assigned: Collection[str], called_later: Collection[str],
                    path: Path) -> Json:
    """A complete model with new names where a block or an event has a name of the code.

    Parameters
    ----------
    content : dict
        the model
    assigned : collection of str
        names that the code binds
    called_later : collection of str
        names that functions refer to, in the code and in parameters
    path : Path
        the model's file, for errors

    Raises
    ------
    DiagramError
        if the name could mean both: one in a function, or one of a subsystem, with which the names
        of its blocks begin
    """
    clashes = _Clashes({*assigned, *_GENERATED}, called_later, path)
    # a model's own events stand beside its graph, those of subsystems in it
    graph = clashes.without({**content["graph"], "events": content["events"]}, "")
    return {**content, "graph": graph, "events": graph["events"]}


class _Clashes:
    def __init__(self, bound: Collection[str], called_later: Collection[str], path: Path):
        self.bound, self.called_later, self.path = bound, called_later, path

    def without(self, graph: Json, prefix: str) -> Json:
        taken = {prefix + plain(part["name"]) for part in (*graph["nodes"], *graph["events"])}
        nodes = [self._subsystem(n, prefix) if n["type"] == "Subsystem" else n
                 if n["type"] == "Interface" else self._renamed(n, "block", prefix, taken)
                 for n in graph["nodes"]]
        events = [self._renamed(e, "event", prefix, taken) for e in graph["events"]]
        return {**graph, "nodes": nodes, "events": events}

    def _subsystem(self, node: Json, prefix: str) -> Json:
        variable = plain(node["name"])  # PathView does not prefix it
        inside = f"{prefix}{variable}_"
        for name in (variable, f"{inside}interface"):
            if name in self.bound:
                self._refuse(f"subsystem {node['name']!r}", name)
        return {**node, "graph": self.without(node["graph"], inside)} if "graph" in node else node

    def _renamed(self, part: Json, kind: str, prefix: str, taken: set[str]) -> Json:
        variable = prefix + plain(part["name"])
        if variable not in self.bound:
            return part
        if variable in self.called_later:
            self._refuse(f"{kind} {part['name']!r}", variable)
        for number in itertools.chain([""], (f" {i}" for i in itertools.count(2))):
            name = f"{part['name']} {kind}{number}"
            variable = prefix + plain(name)
            if variable not in {*self.bound, *taken}:
                taken.add(variable)
                return {**part, "name": name}
        raise AssertionError

    def _refuse(self, what: str, name: str) -> NoReturn:
        raise DiagramError(f"{what}: the model's code uses the name {name!r} for something else; "
                           "rename one of them", path=self.path)
