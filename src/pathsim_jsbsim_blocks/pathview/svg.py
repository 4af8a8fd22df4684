"""Block diagrams as pictures: the layout of the models, drawn as SVG."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

from .diagram import Graph, Node
from .layout import GRID, Layout, arrange, bounds, port_offset, size

_MARGIN, _TITLE = 40, 30  # px
_STYLE = """\
text{font:11px sans-serif;text-anchor:middle;fill:#16222e}
.type{font-size:10px;fill:#4a5568}.title{font-size:16px;text-anchor:start}
rect{fill:#e3edf8;stroke:#2a78d6}.end{fill:#fff;stroke:#a0aec0}
path{fill:none;stroke:#718096}.page{fill:#fff;stroke:none}"""


Box = tuple[tuple[int, int], tuple[int, int]]


def picture(parts: Sequence[tuple[str, Graph]]) -> str:
    """Diagrams below each other, each with a title; nodes without a type are ends of signals."""
    drawn, width, top = [], 0.0, 0.0
    for title, graph in parts:
        sizes = [size(Node(n.name, n.type)) for n in graph.nodes]
        sizes = [(w, max(h, size(n)[1])) for (w, h), n in zip(sizes, graph.nodes, strict=True)]
        layout = arrange(graph, sizes, page=math.inf)
        boxes = list(zip(layout.centres, sizes, strict=True))
        edges = bounds(dict(enumerate(layout.centres)), sizes)
        left, above = edges.left - _MARGIN, edges.top - _MARGIN - _TITLE
        wires, below = _wires(graph, boxes, layout, edges.bottom)
        drawn.append(
            f'<g transform="translate({-left:g},{top - above:g})">'
            f'<text class="title" x="{left + _MARGIN:g}" y="{above + _TITLE:g}">'
            f"{html.escape(title)}</text>{wires}{_nodes(graph, boxes)}</g>"
        )
        width, top = max(width, edges.right + _MARGIN - left), top + below - above
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:g}" height="{top:g}" '
        f'viewBox="0 0 {width:g} {top:g}"><style>{_STYLE}</style>'
        f'<rect class="page" width="{width:g}" height="{top:g}"/>\n' + "\n".join(drawn) + "</svg>\n"
    )


def _nodes(graph: Graph, boxes: Sequence[Box]) -> str:
    texts = []
    for node, ((x, y), (w, h)) in zip(graph.nodes, boxes, strict=True):
        end = "" if node.type else ' class="end" rx="10"'
        texts.append(f'<rect x="{x - w / 2:g}" y="{y - h / 2:g}" width="{w}" height="{h}"{end}/>')
        texts.append(
            f'<text x="{x}" y="{y + (-1 if node.type else 4)}">{html.escape(node.name)}</text>'
        )
        if node.type:
            texts.append(f'<text class="type" x="{x}" y="{y + 12}">{html.escape(node.type)}</text>')
    return "".join(texts)


def _wires(graph: Graph, boxes: Sequence[Box], layout: Layout, floor: float) -> tuple[str, float]:
    """Wires that turn between the columns, or run below all where something is in the way.

    Returns how far down they reach, too.
    """
    paths = []
    for wire in graph.wires:
        ((x0, y0), (w0, _)), ((x1, y1), (w1, _)) = boxes[wire.source], boxes[wire.target]
        sides = [-1 if i in layout.turned else 1 for i in (wire.source, wire.target)]
        x0, x1 = x0 + sides[0] * w0 // 2, x1 - sides[1] * w1 // 2
        a = y0 + port_offset(wire.output, len(graph.nodes[wire.source].outputs))
        b = y1 + port_offset(wire.input, len(graph.nodes[wire.target].inputs))
        start, end = (
            x + side * (GRID + GRID * (wire.source % 4))
            for x, side in ((x0, sides[0]), (x1, -sides[1]))
        )
        blocked = any(
            abs(y - a) < h / 2 and min(x0, end) < x < max(x0, end) for (x, y), (_, h) in boxes
        )
        if blocked or (end - x0) * sides[0] < 0:
            floor += GRID
            paths.append(f'<path d="M{x0},{a:g}H{start}V{floor:g}H{end}V{b:g}H{x1}"/>')
        else:
            paths.append(f'<path d="M{x0},{a:g}H{end}V{b:g}H{x1}"/>')
    return "".join(paths), floor + _MARGIN
