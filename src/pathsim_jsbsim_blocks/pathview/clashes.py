"""Rename blocks and events whose variables collide in PathView's script.

Otherwise the script rebinds the name: a parameter that refers to a value of the code would get a
block, and a subsystem or the simulation that lists a block would get another one.
"""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from ..errors import DiagramError
from .shape import Json
from .variables import plain, prefix_inside, unique

# names that PathView's script binds in addition to the blocks and the code
_GENERATED = {"np", "plt", "blocks", "connections", "events", "sim"}
_NAMELESS = {"Interface", "BusCreator", "BusSelector"}  # have no variable of their own name


def without_clashes(
    content: Json, assigned: Collection[str], called_later: Collection[str], path: Path
) -> Json:
    """A complete model with new names where a variable would be bound twice.

    The outer block or event keeps its name; within one level, the first does. ``assigned`` are
    names that the code binds, and built-in functions that it uses; ``called_later`` are names to
    which functions refer. A `DiagramError` names what must not be renamed: what functions refer to,
    and a subsystem, whose name is the prefix of the names of its blocks.
    """
    bound = {*assigned, *_GENERATED}
    taken: set[str] = set()  # variables of the levels done so far

    def renamed(part: Json, kind: str, prefix: str) -> Json:
        if part["type"] in _NAMELESS:
            return part
        whole = part["type"] == "Subsystem"
        for name in sorted(_variables(part, prefix) & bound):
            if whole or name in called_later:
                raise DiagramError(
                    f"{'subsystem' if whole else kind} {part['name']!r}: the model's code uses the "
                    f"name {name!r} for something else; rename one of them",
                    path=path,
                )

        def is_taken(name: str) -> bool:
            own = _variables({**part, "name": name}, prefix)
            return not plain(name) or bool(own & (bound | taken))

        if is_taken(part["name"]):
            wish = f"{part['name']} {kind}" if plain(part["name"]) else kind
            part = {**part, "name": unique(wish, is_taken, " ")}
        taken.update(_variables(part, prefix))
        return part

    def level(graph: Json, prefix: str) -> Json:
        nodes = [renamed(n, "block", prefix) for n in graph["nodes"]]
        events = [renamed(e, "event", prefix) for e in graph["events"]]
        for i, node in enumerate(nodes):
            if node["type"] == "Subsystem" and "graph" in node:
                inside = level(node["graph"], prefix_inside(node["name"], prefix))
                nodes[i] = {**node, "graph": inside}
        return {**graph, "nodes": nodes, "events": events}

    # a model's own events stand beside its graph, those of subsystems in it
    graph = level({**content["graph"], "events": content["events"]}, "")
    return {**content, "graph": graph, "events": graph["events"]}


def _variables(part: Json, prefix: str) -> set[str]:
    # PathView puts nothing before a subsystem in a subsystem
    if part["type"] == "Subsystem":
        return {plain(part["name"]), f"{prefix_inside(part['name'], prefix)}interface"}
    return {prefix + plain(part["name"])}
