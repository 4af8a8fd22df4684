"""Check that every part of a model reaches its script: PathView drops unknown parts."""

from __future__ import annotations

import ast
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NoReturn

import pathsim.solvers

from .._core.checks import did_you_mean, nearest
from ..errors import DiagramError
from ..scripts.names import bound, used
from .buses import BUSES, check_buses
from .shape import Json, graphs, with_parts
from .toolboxes import unknown_block

NUMBERS = ("duration", "dt", "atol", "rtol", "ftol", "dt_min", "dt_max")
_EDITOR_BLOCKS = {"Subsystem", "Interface", *BUSES}


@contextmanager
def compiling() -> Iterator[None]:
    """Suppress Python's warnings about code style, which concern the code's author."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


def complete(content: Json) -> Json:
    """A model with all of its optional parts filled in.

    Types of old files are shortened as PathView does: "pathsim.sources.StepSource" becomes
    ``StepSource``.
    """

    def part(old: Json) -> Json:
        kind = old["type"]
        if kind.startswith("pathsim.") and not kind.startswith("pathsim.events."):
            kind = kind.rpartition(".")[2]
        return {**old, "type": kind, "params": old.get("params") or {}}

    return {
        **with_parts(content, part),
        "codeContext": {"code": (content.get("codeContext") or {}).get("code") or ""},
        "simulationSettings": content.get("simulationSettings") or {},
    }


class ModelCheck:
    """Checks that every part of a model reaches its script."""

    def __init__(self, content: Json, registry: Json, path: Path):
        self.content, self.registry, self.path = content, registry, path
        self.assigned: set[str] = set()  # names that the model's code binds
        self.used: set[str] = set()  # names that the code and parameters refer to
        self.called_later: set[str] = set()  # names to which functions refer

    def all(self) -> None:
        settings = self.content["simulationSettings"]
        code = self._parsed("the code", self.content["codeContext"]["code"], "exec")
        self.assigned.update(bound(ast.iter_child_nodes(code)))
        for name in NUMBERS:
            if settings.get(name) not in (None, ""):
                self._parsed(f"setting {name!r}", settings[name])
        solver = settings.get("solver")
        if solver and not isinstance(getattr(pathsim.solvers, solver, None), type):
            solvers = [n for n, v in vars(pathsim.solvers).items() if isinstance(v, type)]
            self._refuse(f"unknown solver {solver!r}" + did_you_mean(nearest(solver, solvers)))
        self._ids()
        self._graph(self.content["graph"], None)
        check_buses(self.content["graph"], self._refuse)
        for event in self.content["events"]:
            self._event(event)

    def _refuse(self, reason: str) -> NoReturn:
        raise DiagramError(reason, path=self.path)

    def _ids(self) -> None:
        """Require unique ids: PathView's converter looks them up in one table for all levels."""
        names: dict[str, str] = {}
        for node in (n for graph in graphs(self.content) for n in graph["nodes"]):
            if node["id"] in names:
                what = f"blocks {names[node['id']]!r} and {node['name']!r} have the same id"
                self._refuse(f"{what} {node['id']!r}, so their connections are ambiguous")
            names[node["id"]] = node["name"]

    def _graph(self, graph: Json, parent: Json | None) -> None:
        if parent is None and graph["events"]:
            what = f"event {graph['events'][0]['name']!r} is in the graph"
            self._refuse(f"{what}; events of the top level belong in the model's 'events'")
        interfaces = [n["name"] for n in graph["nodes"] if n["type"] == "Interface"]
        if parent is None and interfaces:
            what = f"block {interfaces[0]!r} is an Interface outside a subsystem"
            self._refuse(f"{what}; PathView drops it and its connections")
        if len(interfaces) > 1 and parent is not None:
            what = f"subsystem {parent['name']!r} has {len(interfaces)} interfaces"
            self._refuse(f"{what}, {' and '.join(map(repr, interfaces))}; it can have one")
        for node in graph["nodes"]:
            self._node(node)
        for event in graph["events"]:
            self._event(event)
        ends = set()
        for connection in graph["connections"]:
            self._end(graph, parent, connection, "source", "output")
            self._end(graph, parent, connection, "target", "input")
            end = connection["targetNodeId"], connection["targetPortIndex"]
            if end in ends:
                what = f"connection {connection['id']!r}: input {end[1]} of its target"
                self._refuse(f"{what} is already connected")
            ends.add(end)

    def _node(self, node: Json) -> None:
        what, kind, blocks = f"block {node['name']!r}", node["type"], self.registry["blocks"]
        if kind != "Subsystem" and node.get("graph"):
            self._refuse(f"{what} has blocks inside but is not a Subsystem: {kind!r}")
        if node.get("graph"):
            self._graph(node["graph"], node)
        elif kind not in _EDITOR_BLOCKS:
            if kind not in blocks:
                self._refuse(f"{what}: {unknown_block(kind, self.registry)}")
            self._parameters(what, node["params"], blocks[kind]["params"])

    def _end(self, graph: Json, parent: Json | None, connection: Json, end: str, side: str) -> None:
        what = f"connection {connection['id']!r}"
        name, port = connection[f"{end}NodeId"], connection[f"{end}PortIndex"]
        node = next((n for n in graph["nodes"] if n["id"] == name), None)
        if node is None:
            self._refuse(f"{what}: no block {name!r}")
        ports = node[f"{side}s"]
        if node["type"] == "Interface" and parent is not None:
            # inside, the subsystem's inputs are outputs of its interface
            ports = parent["inputs" if side == "output" else "outputs"]
        if not isinstance(port, int) or not 0 <= port < len(ports):
            self._refuse(f"{what}: {node['name']!r} has no {side} {port!r}")

    def _event(self, event: Json) -> None:
        what, kind, events = f"event {event['name']!r}", event["type"], self.registry["events"]
        name = kind.rpartition(".")[2]
        if name not in events:
            hint = did_you_mean(nearest(name, events))
            self._refuse(f"{what}: PathView does not know {kind!r}{hint}")
        self._parameters(what, event["params"], events[name]["params"])

    def _parameters(self, what: str, params: Json, names: Sequence[str]) -> None:
        for name, value in params.items():
            if value in (None, "") or name.startswith("_"):
                continue
            if name not in names:
                # left over from older versions; PathView drops them too
                warnings.warn(
                    f"{self.path}: {what}: no parameter {name!r}, left out"
                    + did_you_mean(nearest(name, names, 1)),
                    stacklevel=2,
                )
            else:
                self._parsed(f"{what}: parameter {name!r}", value)

    def _parsed(self, what: str, value: Any, mode: str = "eval") -> ast.AST:
        source = str(value).strip() if mode == "eval" else value
        try:
            with compiling():
                # compile first: in Python 3.10 ast.parse has no depth limit and may crash
                compile(source, what, mode, dont_inherit=True)
                tree = ast.parse(source, mode=mode)
            self.used.update(used(tree))
        except (SyntaxError, ValueError) as error:
            kind = "expression" if mode == "eval" else "code"
            self._refuse(
                f"{what} is not a Python {kind}: {str(value)!r} ({getattr(error, 'msg', error)})"
            )
        except (RecursionError, MemoryError):
            self._refuse(f"{what} is nested too deep for Python: {str(value)[:60]!r}...")
        functions = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)
        for node in ast.walk(tree):
            if isinstance(node, functions):
                self.called_later.update(used(node))
        return tree
