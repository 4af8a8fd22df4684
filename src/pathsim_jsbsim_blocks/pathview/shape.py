"""The shape of a model file: required members and their types, checked before use."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NoReturn

from ..errors import DiagramError

Json = dict[str, Any]

# A specification is a kind, a list of one specification, or the members of an object. A "?" marks
# members that may be missing or null; members that are not listed may be anything.
_POSITION = {"x": float, "y": float}
_PORTS = [{"name?": str}]
_EVENTS = [{"type": str, "name": str, "params?": dict, "position?": _POSITION}]
_CONNECTIONS = [
    {
        "id": str,
        "label?": str,
        "sourceNodeId": str,
        "sourcePortIndex": int,
        "targetNodeId": str,
        "targetPortIndex": int,
    }
]
_NODE: dict[str, Any] = {
    "id": str,
    "type": str,
    "name": str,
    "position?": _POSITION,
    "params?": dict,
    "inputs": _PORTS,
    "outputs": _PORTS,
}
_GRAPH = {
    "nodes?": [_NODE],
    "connections?": _CONNECTIONS,
    "events?": _EVENTS,
    "annotations?": [{"id?": str, "position?": _POSITION}],
}
_NODE["graph?"] = _GRAPH
_MODEL = {
    "graph": _GRAPH,
    "events?": _EVENTS,
    "codeContext?": {"code?": str},
    "simulationSettings?": {"solver?": str},
    "requiredToolboxes?": [dict],
}

_KINDS = {str: "text", int: "a whole number", float: "a coordinate", list: "a list"}
_FAR = 1e9  # px
_DEEP = 100  # levels of lists and objects: 30 nested subsystems


def with_parts(content: Json, part: Callable[[Json], Json]) -> Json:
    """A model in which ``part(old)`` replaces each block and event, on all levels."""

    def node(old: Json) -> Json:
        new = dict(part(old))
        inner = new.pop("graph", None)
        return {**new, "graph": graph(inner)} if inner else new

    def events(old: Json) -> list[Json]:
        return [part(event) for event in old.get("events") or []]

    def graph(old: Json) -> Json:
        return {
            **old,
            "nodes": [node(n) for n in old.get("nodes") or []],
            "connections": old.get("connections") or [],
            "events": events(old),
        }

    return {**content, "graph": graph(content["graph"]), "events": events(content)}


def graphs(content: Json) -> Iterator[Json]:
    """The graph of a model, and those of its subsystems."""
    waiting = [content["graph"]]
    while waiting:
        graph = waiting.pop()
        yield graph
        waiting += [node["graph"] for node in graph.get("nodes") or [] if node.get("graph")]


def check_shape(content: Any, path: Path) -> None:
    """Refuse a model without PathView's structure: the error names ``graph.nodes[2].params``."""
    _check_depth(content, path)
    _check(content, _MODEL, "", path)


def _check_depth(content: Any, path: Path) -> None:
    """Refuse deep nesting: the checks are recursive, and Python limits recursion."""
    todo: list[tuple[Any, tuple[str, ...]]] = [(content, ())]
    for value, place in todo:
        if len(place) > _DEEP:
            where = "".join(place).lstrip(".")[:60]
            _refuse(f"{where}... is nested deeper than {_DEEP} levels", path)
        if isinstance(value, dict):
            todo += [(v, (*place, f".{k}")) for k, v in value.items()]
        elif isinstance(value, list):
            todo += [(v, (*place, f"[{i}]")) for i, v in enumerate(value)]


def _check(value: Any, spec: Any, place: str, path: Path) -> None:
    kind = spec if isinstance(spec, type) else type(spec)
    if not _is(value, kind):
        kind_name = _KINDS.get(kind, "an object")
        _refuse(f"{place} must be {kind_name}, not {shortened(repr(value))}", path)
    if isinstance(spec, list):
        for i, item in enumerate(value):
            _check(item, spec[0], f"{place}[{i}]", path)
    elif isinstance(spec, dict):
        for key, inner in spec.items():
            name = key.rstrip("?")
            at = f"{place}.{name}".lstrip(".")
            if value.get(name) is not None:
                _check(value[name], inner, at, path)
            elif not key.endswith("?"):
                _refuse(f"{at} is missing", path)


def _is(value: Any, kind: type) -> bool:
    if kind is float:  # a coordinate: Python's JSON also reads NaN, which is refused
        return (_is(value, int) or isinstance(value, float)) and -_FAR < value < _FAR
    return isinstance(value, kind) and not isinstance(value, bool)


def shortened(text: str) -> str:
    """A text of at most 60 characters."""
    return text if len(text) <= 60 else f"{text[:57]}..."


def _refuse(reason: str, path: Path) -> NoReturn:
    raise DiagramError(f"damaged: {reason}", path=path)
