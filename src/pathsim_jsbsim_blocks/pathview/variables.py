"""PathView's names for the variables of a script, and how to avoid clashes between them."""

from __future__ import annotations

import itertools
import keyword
import re
from collections.abc import Callable, Collection
from pathlib import Path

from ..errors import DiagramError
from .shape import Json

# names that PathView's own script binds, and those that Python does not allow
TAKEN = re.compile(
    r"np|plt|blocks|connections|events|sim|conn_\d+|json|gc|sys|traceback|base64|"
    + "|".join(keyword.kwlist)
)
_NAMELESS = {"Interface", "BusCreator", "BusSelector"}  # get no variable


def plain(name: str) -> str:
    """The variable that PathView derives from a name."""
    variable = re.sub(r"[^a-zA-Z0-9_]", "", name.replace(" ", "_"))
    return ("n_" + variable if variable[:1].isdigit() else variable).lower()


def prefix_inside(subsystem: str, prefix: str) -> str:
    """PathView's prefix for the variables of blocks in a subsystem of this name."""
    return f"{prefix}{plain(subsystem)}_"


def printable(name: str) -> str:
    """A name on one line, without line separators, control characters or direction marks.

    Its variable is the same.
    """
    return "".join(c if c.isprintable() else "\N{REPLACEMENT CHARACTER}" for c in name)


def unique(wish: str, is_taken: Callable[[str], bool], mark: str = "_") -> str:
    """A name that is not taken: ``wish``, with a number appended if needed."""
    candidates = (f"{wish}{mark}{i}" for i in itertools.count(2))
    return next(name for name in itertools.chain([wish], candidates) if not is_taken(name))


def without_clashes(
    content: Json, assigned: Collection[str], called_later: Collection[str], path: Path
) -> Json:
    """A complete model in which blocks and events are renamed if a variable would be bound twice.

    Otherwise a parameter that refers to a value of the code would get a block, or a list of blocks
    would contain the wrong one.

    The outer block or event keeps its name; within one level, the first does. ``assigned`` are
    names that the code binds, and built-in functions that it uses; ``called_later`` are names to
    which functions refer. A `DiagramError` names a part that must not be renamed: one to which a
    function refers, or a subsystem, whose name is the prefix of its blocks' variables.
    """
    taken: set[str] = set()  # variables of the levels done so far

    def is_bound(variable: str) -> bool:
        return variable in assigned or bool(TAKEN.fullmatch(variable))

    def renamed(part: Json, kind: str, prefix: str) -> Json:
        if part["type"] in _NAMELESS:
            return part
        subsystem = part["type"] == "Subsystem"
        for name in filter(is_bound, sorted(_variables(part, prefix))):
            if subsystem or name in called_later:
                raise DiagramError(
                    f"{'subsystem' if subsystem else kind} {part['name']!r}: Python, PathView or "
                    f"the model's code uses the name {name!r} for something else; rename it",
                    path=path,
                )

        def is_taken(name: str) -> bool:
            variables = _variables({**part, "name": name}, prefix)
            return not plain(name) or bool(variables & taken) or any(map(is_bound, variables))

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
                inner = level(node["graph"], prefix_inside(node["name"], prefix))
                nodes[i] = {**node, "graph": inner}
        return {**graph, "nodes": nodes, "events": events}

    # a model's own events are beside its graph, a subsystem's events in its graph
    graph = level({**content["graph"], "events": content["events"]}, "")
    return {**content, "graph": {**graph, "events": []}, "events": graph["events"]}


def _variables(part: Json, prefix: str) -> set[str]:
    # PathView does not prefix a subsystem in a subsystem
    if part["type"] == "Subsystem":
        return {plain(part["name"]), f"{prefix_inside(part['name'], prefix)}interface"}
    return {prefix + plain(part["name"])}
