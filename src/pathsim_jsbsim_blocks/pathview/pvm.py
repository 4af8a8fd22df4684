"""Write a diagram as a PathView model file (.pvm)."""

from __future__ import annotations

import ast
import json
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .._core.files import write_whole
from ..errors import DiagramError, FileError
from ..scripts.names import bound
from .diagram import NOTE, Diagram, Event, Graph, Node
from .layout import GRID, RECORDERS, Box, arrange, bounds, labelled, size, touch
from .shape import check_shape, graphs
from .variables import plain

VERSION = "1.0.0"
# a fixed time, so that the same script always gives the same file
_TIME = "1970-01-01T00:00:00.000Z"
_PINNED = 3  # fields shown on a block
_EVENT = 80  # px
_NOTE_WIDTH = (420, 760)  # px
# px at PathView's default font size: character, line, space after a paragraph, title and margins
_NOTE_CHARACTER, _NOTE_LINE, _NOTE_SPACE, _NOTE_TITLE = 6.2, 16, 10, 50

Existing = Mapping[str, Any]


def model(diagram: Diagram, existing: Existing | None = None) -> dict[str, Any]:
    """The content of a model file; positions in an existing one are kept by name."""
    old = existing or {}
    graph, box = _graph(diagram.graph, "", old.get("graph") or {})
    events = _events(diagram.graph.events, "", box, old.get("events") or [])
    toolboxes = [t.requirement() for t in diagram.toolboxes]
    notes = _annotations(diagram.docstring, box, (old.get("graph") or {}).get("annotations") or [])
    content: dict[str, Any] = {
        "version": VERSION,
        "metadata": {"created": _TIME, "modified": _TIME, "name": diagram.path.stem},
        "graph": {**graph, "annotations": notes},
        "events": events,
        "codeContext": {"code": diagram.context},
        "simulationSettings": {
            **diagram.settings,
            "adaptive": True,
            "ghostTraces": 0,
            "plotResults": True,
            **({} if diagram.log else {"log": False}),
        },
        **({"requiredToolboxes": toolboxes} if toolboxes else {}),
    }
    return with_event_imports(content)


def with_event_imports(content: dict[str, Any]) -> dict[str, Any]:
    """A model whose code imports event classes of subsystems: PathView imports only outer ones."""
    inner = [event for graph in graphs(content) for event in graph.get("events") or []]
    lacks, has = ({e["type"].rpartition(".")[2] for e in x} for x in (inner, content["events"]))
    code = content["codeContext"]["code"]
    if not (names := sorted(lacks - has - bound(ast.iter_child_nodes(ast.parse(code))))):
        return content
    text = f"from pathsim.events import {', '.join(names)}\n\n{code}".rstrip("\n")
    return {**content, "codeContext": {"code": text}}


def text(content: Mapping[str, Any]) -> str:
    """A model file's text."""
    return json.dumps(content, indent=2, ensure_ascii=False) + "\n"


def read(path: Path) -> dict[str, Any]:
    """The content of a model file; `DiagramError` if it is damaged or of an unknown version."""
    try:
        # Notepad puts a byte order mark first
        content = json.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise DiagramError(f"cannot be read ({error.strerror})", path=path) from error
    except (ValueError, RecursionError) as error:
        raise DiagramError(f"not a PathView model: {error}", path=path) from error
    if reason := _no_model(content):
        raise DiagramError(reason, path=path)
    check_shape(content, path)
    try:
        # Python's JSON allows NaN and lone surrogates, which the page cannot read
        json.dumps(content, allow_nan=False, ensure_ascii=False).encode()
    except ValueError as error:
        raise DiagramError(f"not a PathView model: {error}", path=path) from error
    return content


def _no_model(content: Any) -> str:
    """Why a file's content is not a model of a version that this package reads; else empty."""
    if not isinstance(content, dict):
        return "not a PathView model: not a JSON object"
    if content.get("type") in ("block", "subsystem"):
        return f"a PathView {content['type']}, not a model; open it in PathView and save the model"
    if "nodes" in content and "edges" in content:
        why = "which PathView no longer opens; redraw it"
        return f"a file of PathView's first version, of 2025, {why}"
    graph, version = content.get("graph"), content.get("version")
    if not isinstance(graph, dict) or not isinstance(graph.get("nodes"), list):
        return "not a PathView model: it has no graph"
    if not isinstance(version, str) or version.split(".")[0] != VERSION.split(".")[0]:
        return f"a model of version {version!r}; this package reads {VERSION}"
    return ""


def write(path: Path, content: str) -> None:
    """Write a file; on failure raise `DiagramError` and leave an existing file unchanged."""
    try:
        write_whole(path, content)
    except FileError as error:
        raise DiagramError(f"cannot be written ({error.reason})", path=path) from error


def _graph(graph: Graph, prefix: str, old: Existing) -> tuple[dict[str, Any], Box]:
    pins = [_pinned(n) for n in graph.nodes]
    sizes = [size(n, len(p)) for n, p in zip(graph.nodes, pins, strict=True)]
    layout = arrange(graph, sizes)
    existing = {plain(str(n.get("name", ""))): n for n in reversed(old.get("nodes") or [])}
    olds = [existing.get(plain(n.name), {}) for n in graph.nodes]
    centres = _kept_centres(layout.centres, sizes, olds)
    ids = [prefix + plain(n.name) for n in graph.nodes]
    nodes = []
    for i, node in enumerate(graph.nodes):
        half_turn = 2 if i in layout.turned else 0
        rotation = (olds[i].get("params") or {}).get("_rotation", 0) if olds[i] else half_turn
        nodes.append(_node(node, ids[i], centres[i], rotation, pins[i], olds[i]))
    # PathView routes feedback wires around the blocks, mostly above them
    first = min((y + sizes[i][1] / 2 for i, (_, y) in enumerate(centres)), default=0.0)
    feedback = {
        (w.source, w.output)
        for w in graph.wires
        if centres[w.source][0] >= centres[w.target][0]
        and centres[w.target][1] - sizes[w.target][1] / 2 < first
    }
    box = bounds(dict(enumerate(centres)), sizes)
    box = box._replace(top=box.top - GRID * len(feedback))
    connections = [
        {
            "id": f"{ids[w.source]}-{w.output}-to-{ids[w.target]}-{w.input}",
            "sourceNodeId": ids[w.source],
            "sourcePortIndex": w.output,
            "targetNodeId": ids[w.target],
            "targetPortIndex": w.input,
        }
        for w in graph.wires
    ]
    return {"nodes": nodes, "connections": connections}, box


def _kept_centres(
    auto: Sequence[tuple[int, int]], sizes: Sequence[tuple[int, int]], olds: Sequence[Existing]
) -> list[tuple[int, int]]:
    """Positions of an existing model; new blocks are placed relative to them."""
    positions = {
        i: (o["position"]["x"], o["position"]["y"])
        for i, o in enumerate(olds)
        if isinstance(o.get("position"), dict)
    }
    if not positions:
        return list(auto)
    dx, dy = (
        GRID * round(sum(positions[i][k] - auto[i][k] for i in positions) / len(positions) / GRID)
        for k in (0, 1)
    )
    centres = [positions.get(i, (x + dx, y + dy)) for i, (x, y) in enumerate(auto)]
    for i, (x, y) in enumerate(centres):
        while i not in positions and any(
            touch((x, y), sizes[i], centres[j], sizes[j]) for j in range(len(centres)) if j != i
        ):
            y += GRID
            centres[i] = (x, y)
    return centres


def _node(
    node: Node, name: str, centre: tuple[int, int], rotation: int, pins: list[str], old: Existing
) -> dict[str, Any]:
    params: dict[str, Any] = dict(node.params)
    if rotation:
        params["_rotation"] = rotation
    for side, ports in (("Input", node.inputs), ("Output", node.outputs)):
        if labelled(node, ports):
            params[f"_show{side}Labels"] = True
    out: dict[str, Any] = {
        "id": name,
        "type": node.type,
        "name": node.name,
        "position": {"x": centre[0], "y": centre[1]},
        "inputs": _ports(name, "input", node.inputs),
        "outputs": _ports(name, "output", node.outputs),
        "params": params,
    }
    if pins:
        out["pinnedParams"] = pins
    if node.graph is not None:
        level = old.get("graph") or {}
        graph, box = _graph(node.graph, f"{name}.", level)
        out["graph"] = {
            **graph,
            "annotations": [],
            "events": _events(node.graph.events, f"{name}.", box, level.get("events") or []),
        }
    return out


def _ports(node: str, direction: str, names: Sequence[str]) -> list[dict[str, Any]]:
    return [
        {
            "id": f"{node}-{direction}-{i}",
            "nodeId": node,
            "name": name,
            "direction": direction,
            "index": i,
            "color": "#969696",
        }
        for i, name in enumerate(names)
    ]


def _pinned(node: Node) -> list[str]:
    """Parameters to show on the block: the first ones set; PathView shortens their values."""
    return [] if node.type in RECORDERS else list(node.params)[:_PINNED]


def _events(
    events: Sequence[Event], prefix: str, box: Box, old: Sequence[Existing]
) -> list[dict[str, Any]]:
    positions = {plain(str(e.get("name", ""))): e.get("position") for e in old}
    out = []
    for i, event in enumerate(events):
        x = GRID * round((box.left + (1.5 * i + 0.5) * _EVENT) / GRID)
        y = GRID * round((box.bottom + 1.5 * _EVENT) / GRID)
        out.append(
            {
                "id": prefix + plain(event.name),
                "type": event.type,
                "name": event.name,
                "position": positions.get(plain(event.name)) or {"x": x, "y": y},
                "params": dict(event.params),
            }
        )
    return out


def _annotations(docstring: str, box: Box, old: Sequence[Existing]) -> list[dict[str, Any]]:
    """The script's docstring, above the diagram, and the notes of an existing model."""
    notes = [dict(a) for a in old if a.get("id") != NOTE]
    content = _markdown(docstring)
    if not content:
        return notes
    previous = next((a for a in old if a.get("id") == NOTE), {})
    span = box.right - box.left
    width = GRID * round(min(max(span, _NOTE_WIDTH[0]), _NOTE_WIDTH[1]) / GRID)
    paragraphs = content.split("\n\n")[1:]
    lines = (math.ceil(len(p) * _NOTE_CHARACTER / (width - 20)) for p in paragraphs)
    text_height = _NOTE_TITLE + sum(_NOTE_SPACE + _NOTE_LINE * n for n in lines)
    height = GRID * math.ceil(text_height / GRID)
    x, y = GRID * round(box.left / GRID), GRID * round((box.top - height) / GRID) - 3 * GRID
    note = {"position": {"x": x, "y": y}, "content": content, "width": width, "height": height}
    note.update({k: previous[k] for k in ("position", "width", "height") if k in previous})
    return [{"id": NOTE, **note}, *notes]


def _markdown(docstring: str) -> str:
    """A docstring as Markdown: its first line as a title, each paragraph on one line."""
    docstring = re.sub(r"(\.\. math::)\s*\n", r"\1 ", docstring.strip())
    paragraphs = [p for p in map(_paragraph, re.split(r"\n\s*\n", docstring)) if p]
    if not paragraphs:
        return ""
    head, colon, tail = paragraphs[0].lstrip("# ").rstrip(".").partition(": ")
    return "\n\n".join(
        [f"# {head}", *([f"{tail[0].upper()}{tail[1:]}."] if colon else []), *paragraphs[1:]]
    )


def _paragraph(text: str) -> str:
    """A paragraph of reST as Markdown: formulas, literals, lists, no lines under titles."""
    lines = [
        line.strip()
        for line in text.splitlines()
        if not re.fullmatch(r"[=~\-^\"]{3,}", line.strip())
    ]
    out = lines[0] if lines else ""
    for line in lines[1:]:
        out += ("\n" if re.match(r"[-*] ", line) else " ") + line
    if out.startswith(".. math::"):
        return f"$$ {out.removeprefix('.. math::').strip()} $$"
    return re.sub(r":math:`([^`]*)`", r"$\1$", out).replace("``", "`")
