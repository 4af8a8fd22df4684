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
_NAMELESS = {"Interface", "BusCreator", "BusSelector"}  # of no variable of their own name


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
        return {**graph, "nodes": [self._node(n, prefix, taken) for n in graph["nodes"]],
                "events": [self._renamed(e, "event", prefix, taken) for e in graph["events"]]}

    def _node(self, node: Json, prefix: str, taken: set[str]) -> Json:
        if node["type"] == "Subsystem":
            return self._subsystem(node, prefix)
        if node["type"] in _NAMELESS:
            return node
        return self._renamed(node, "block", prefix, taken)

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
        wish = f"{part['name']} {kind}"
        names = itertools.chain([wish], (f"{wish} {i}" for i in itertools.count(2)))
        name = next(n for n in names if prefix + plain(n) not in {*self.bound, *taken})
        taken.add(prefix + plain(name))
        return {**part, "name": name}

    def _refuse(self, what: str, name: str) -> NoReturn:
        raise DiagramError(f"{what}: the model's code uses the name {name!r} for something else; "
                           "rename one of them", path=self.path)
