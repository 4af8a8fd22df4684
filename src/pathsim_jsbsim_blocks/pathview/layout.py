"""Automatic layout: signals from left to right, feedback turned and below, scopes at the right."""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from statistics import mean, median_low
from typing import NamedTuple

from .diagram import Graph, Node

GRID = 10  # PathView's grid, px
PAGE = 800  # px, width at which a diagram is readable on a page; a longer chain is wrapped
_PORT = 20  # px between ports
_ROW = 60  # px, free height between blocks
_GAP = 50  # px, free width between columns, plus GRID for each wire that turns there
_SWEEPS = 12  # of the heights; with 4 or 48 the wires of the catalogue bend by 0.2 % less or more
RECORDERS = {"Scope", "Spectrum"}
_BIG = 4  # outputs of a block that is taken for the plant, after which loops are opened

Edge = tuple[int, int]


@dataclass
class Layout:
    """Centres of the nodes in px, and which of them are turned (inputs at the right)."""

    centres: list[tuple[int, int]]
    turned: set[int]


class Box(NamedTuple):
    """Edges of a rectangle, px."""

    left: float
    top: float
    right: float
    bottom: float


def labelled(node: Node, ports: list[str]) -> bool:
    """Whether to show the names of ports: not of recorders, and not mere numbers."""
    return node.type not in RECORDERS and any(
        not re.fullmatch(r"(in|out) \d+|in|out|y|\W", p) for p in ports
    )


def size(node: Node, pins: int = 0) -> tuple[int, int]:
    """Width and height in px at which PathView draws a node, with the names of its ports."""
    width = max(80, 6 * len(node.name) + 20, 5 * len(node.type) + 20, 160 if pins else 0)
    for ports in (node.inputs, node.outputs):
        if labelled(node, ports):  # beside the ports in PathView, inside the block in our page
            width += _up(8 + 4 * max(map(len, ports)))
    height = max(
        40 + (7 + 24 * pins if pins else 0), _PORT * max(len(node.inputs), len(node.outputs), 1)
    )
    return _up(width), _up(height)


def arrange(graph: Graph, sizes: list[tuple[int, int]], page: float = PAGE) -> Layout:
    """Place the nodes of one level of a diagram; ``page`` is the width of its rows, px."""
    nodes = graph.nodes
    interface = next((i for i, n in enumerate(nodes) if n.type == "Interface"), None)
    # after a loop, the interface of a subsystem without inputs would widen the row beyond the page
    wires = {(w.source, w.target) for w in graph.wires}
    loop = _loops(range(len(nodes)), wires)
    sinks = {i for i, n in enumerate(nodes) if not n.outputs and not (loop and i == interface)}
    inner = [i for i in range(len(nodes)) if i not in sinks]
    edges = {(source, target) for source, target in wires if target not in sinks}
    probes = {w.source for w in graph.wires if w.target in sinks}
    cut = {e for e in edges if e[0] == e[1] or e[1] == interface}
    loops: set[int] = set()
    while components := _loops(inner, edges - cut):
        for component in components:
            loops |= component
            hub = _hub(component, edges, nodes, probes)
            cut |= {(hub, i) for i in component} & edges
    chains = _feedback(nodes, edges, cut, loops)
    mirror = {i for chain in chains for i in chain}

    layer = _layers(
        [i for i in inner if i not in mirror], {e for e in edges - cut if not mirror & set(e)}
    )
    last = max(layer.values(), default=-1)
    for i in sinks:
        layer[i] = last + 1
    for i in inner:
        # align a block that only feeds a scope with the other blocks that feed scopes
        if i not in mirror and i in probes and not any(i in e for e in edges):
            layer[i] = max(last, 0)
    bands = _bands(graph, sizes, layer, cut, sinks, page)
    x = {i: at for band in bands for i, at in _columns(graph, sizes, band, cut).items()}
    centres: dict[int, tuple[int, int]] = {}
    for band in bands:
        y = _rows(graph, sizes, band, cut, sinks)
        if centres:
            between = {
                (w.source, w.output) for w in graph.wires if (w.source in y) != (w.target in y)
            }
            top = bounds(centres, sizes).bottom + _ROW + GRID * len(between)
            shift = top - min(y[i] - sizes[i][1] / 2 for i in y)
            y = {i: at + shift for i, at in y.items()}
        centres.update({i: (x[i], _snap(at)) for i, at in y.items()})
        sources = {i: at for i, at in centres.items() if nodes[i].outputs}
        floor = bounds(sources, sizes).bottom
        for chain in [c for c in chains if band is bands[-1] or _goals(graph, c) & centres.keys()]:
            _place_turned(graph, sizes, chain, floor, x, centres)
            chains.remove(chain)
    return Layout([centres[i] for i in range(len(nodes))], mirror)


def bounds(centres: Mapping[int, tuple[int, int]], sizes: Sequence[tuple[int, int]]) -> Box:
    """The rectangle around blocks."""
    edges = [
        (x - sizes[i][0] / 2, y - sizes[i][1] / 2, x + sizes[i][0] / 2, y + sizes[i][1] / 2)
        for i, (x, y) in centres.items()
    ]
    left, top, right, bottom = zip(*edges or [(0.0,) * 4], strict=True)
    return Box(min(left), min(top), max(right), max(bottom))


def _bands(
    graph: Graph,
    sizes: list[tuple[int, int]],
    layer: dict[int, int],
    cut: Collection[Edge],
    sinks: set[int],
    page: float,
) -> list[dict[int, int]]:
    """The columns in rows that fit on a page: few rows first, then few wires between them."""
    column = {i: n for i, n in layer.items() if i not in sinks}
    last = max(column.values(), default=0)
    for i in sinks:  # a scope stands at the end of its last source's row
        column[i] = max(
            (column[w.source] for w in graph.wires if w.target == i and w.source in column),
            default=last,
        )
    # best layout of the first n columns: number of rows, wires between, sum of widths^2, rows
    best: dict[int, tuple[int, int, float, list[dict[int, int]]]] = {0: (0, 0, 0.0, [])}
    for end in range(1, last + 2):
        ways = []
        for start in range(end - 1, -1, -1):
            band = {i: n for i, n in layer.items() if start <= column[i] < end}
            at = _columns(graph, sizes, band, cut)
            width = max((x + sizes[i][0] / 2 for i, x in at.items()), default=0.0)
            if width > page and start < end - 1:
                break
            count, wires, unequal, bands = best[start]
            crossing = {
                (w.source, w.output)
                for w in graph.wires
                if w.source in column
                and w.target in column
                and start
                and (column[w.source] < start) != (column[w.target] < start)
            }
            ways.append((count + 1, wires + len(crossing), unequal + width**2, [*bands, band]))
        best[end] = min(ways, key=lambda way: way[:3])
    return [band for band in best[last + 1][3] if band]


def _loops(nodes: Iterable[int], edges: Collection[Edge]) -> list[set[int]]:
    """Groups of nodes on common loops, from what each of them reaches (Warshall)."""
    reach = {i: {b for a, b in edges if a == i} for i in nodes}
    for middle, beyond_middle in reach.items():
        for targets in reach.values():
            if middle in targets:
                targets |= beyond_middle
    groups = {frozenset(j for j in reach[i] if i in reach[j]) for i in reach}
    return [set(group) for group in sorted(map(sorted, groups)) if group]


def _hub(loop: set[int], edges: Collection[Edge], nodes: list[Node], probes: set[int]) -> int:
    """The node after which a loop is opened: the plant, or else the last block before a scope."""
    links = [(a, b) for a, b in edges if a in loop and b in loop]
    entries = {b for a, b in edges if b in loop and a not in loop}
    if not entries:  # an isolated loop starts at its summing junction
        entries = {max(sorted(loop), key=lambda i: sum(b == i for _, b in links))}
    depth = dict.fromkeys(entries, 0)
    todo = sorted(entries)
    for a in todo:
        for b in sorted(b for s, b in links if s == a and b not in depth):
            depth[b] = depth[a] + 1
            todo.append(b)

    def rank(i: int) -> tuple:
        outputs = len(nodes[i].outputs)
        return outputs if outputs >= _BIG else 0, i in probes, depth[i], -i

    return max(loop, key=rank)


def _feedback(
    nodes: list[Node], edges: Collection[Edge], cut: Collection[Edge], loops: set[int]
) -> list[list[int]]:
    """Chains of blocks on feedback paths, each fed by one block, starting after an opened loop."""
    sources = defaultdict(list)
    for a, b in edges:
        sources[b].append(a)
    openers = {a for a, _ in cut}
    feeds = {
        i: sources[i][0]
        for i in sorted(loops - openers)
        if len(nodes[i].inputs) <= 2 and len(sources[i]) == 1
    }
    chains: list[list[int]] = []
    todo = [i for i, source in feeds.items() if (source, i) in cut]
    for i in todo:
        # a second branch is a separate chain
        chain = next((c for c in chains if c[-1] == feeds[i]), None)
        if chain:
            chain.append(i)
        else:
            chains.append([i])
        todo += [j for j, source in feeds.items() if source == i]
    return chains


def _layers(nodes: list[int], edges: Collection[Edge]) -> dict[int, int]:
    """Column of each node: the longest path to it; a node without inputs is before its target."""
    layer = dict.fromkeys(nodes, 0)
    for _ in nodes:
        changes = False
        for a, b in edges:
            if layer[b] <= layer[a]:
                layer[b] = layer[a] + 1
                changes = True
        if not changes:
            break
    targets = {b for _, b in edges}
    for i in nodes:
        columns = [layer[b] for a, b in edges if a == i]
        if i not in targets and columns:
            layer[i] = min(columns) - 1
    return layer


def _rows(
    graph: Graph,
    sizes: list[tuple[int, int]],
    layer: dict[int, int],
    cut: Collection[Edge],
    sinks: set[int],
) -> dict[int, float]:
    """Heights that make the wires between columns as straight as possible."""
    back = {(w.source, w.output, w.target) for w in graph.wires if (w.source, w.target) in cut}
    # wires that run back pass above and below their blocks
    heights = [
        size[1] + GRID * len({b[:2] for b in back if i in (b[0], b[2])})
        for i, size in enumerate(sizes)
    ]
    columns: dict[int, list[int]] = defaultdict(list)
    for i in sorted(layer):
        columns[layer[i]].append(i)
    y: dict[int, float] = {}
    for column in columns.values():
        y.update(_spread([(0.0, i) for i in column], heights))
    wires = [
        w
        for w in graph.wires
        if w.source in layer and w.target in layer and (w.source, w.target) not in cut
    ]
    pulls: dict[int, list[tuple[int, float]]] = defaultdict(list)
    links = {i for w in wires if w.target not in sinks for i in (w.source, w.target)}
    for w in wires:
        # offset of the target's centre from the source's for a straight wire
        shift = port_offset(w.output, len(graph.nodes[w.source].outputs)) - port_offset(
            w.input, len(graph.nodes[w.target].inputs)
        )
        pulls[w.target].append((w.source, shift))
        if w.target not in sinks or w.source not in links:  # a scope follows its sources
            pulls[w.source].append((w.target, -shift))
    for sweep in range(_SWEEPS + 1):
        forward = sweep % 2 == 0
        for number in sorted(columns, reverse=not forward):
            wishes = []
            for i in columns[number]:
                sides = [y[j] + s for j, s in pulls[i] if (layer[j] < layer[i]) == forward]
                # in the last sweep prefer one straight wire to two that are nearly straight
                middle = mean if sweep < _SWEEPS else median_low
                wishes.append((middle(sides) if sides else y[i], i))
            wishes.sort(key=None if sweep < _SWEEPS else lambda w: y[w[1]])
            y.update(_spread(wishes, heights))
    return y


def _spread(wishes: list[tuple[float, int]], heights: list[int]) -> dict[int, float]:
    """Heights close to the wished ones that keep the blocks of a column in this order."""
    # groups of touching blocks, each at the mean of its blocks' wishes
    groups: list[tuple[list[int], list[float], float]] = []  # blocks, offsets, sum of wishes
    for wish, i in wishes:
        group = ([i], [0.0], wish)
        while groups:
            blocks, offsets, total = groups[-1]
            gap = (heights[blocks[-1]] + heights[group[0][0]]) / 2 + _ROW
            start = total / len(blocks)
            shift = offsets[-1] + gap
            if start + shift <= group[2] / len(group[0]):
                break
            groups.pop()
            group = (
                blocks + group[0],
                offsets + [o + shift for o in group[1]],
                total + group[2] - shift * len(group[0]),
            )
        groups.append(group)
    return {
        i: total / len(blocks) + offset
        for blocks, offsets, total in groups
        for i, offset in zip(blocks, offsets, strict=True)
    }


def _columns(
    graph: Graph, sizes: list[tuple[int, int]], layer: dict[int, int], cut: Collection[Edge]
) -> dict[int, int]:
    """Horizontal centre of each node, with room for the wires that turn between columns."""
    x: dict[int, int] = {}
    right = 0.0
    previous = None
    for number in sorted(set(layer.values())):
        half = max(sizes[i][0] for i in layer if layer[i] == number) / 2
        turning = {
            (w.source, w.output)
            for w in graph.wires
            if (layer.get(w.target) == number and w.source in layer)
            or ((w.source, w.target) in cut and layer.get(w.source) == previous)
        }
        if previous is not None:
            right += _GAP + GRID * min(len(turning), 10)
        x.update({i: _snap(right + half) for i in layer if layer[i] == number})
        right += 2 * half
        previous = number
    return x


def _goals(graph: Graph, chain: list[int]) -> set[int]:
    """The blocks at the end of a feedback path."""
    return {
        w.target for w in graph.wires if w.source == chain[-1] and graph.nodes[w.target].outputs
    }


def _place_turned(
    graph: Graph,
    sizes: list[tuple[int, int]],
    chain: list[int],
    floor: float,
    x: dict[int, int],
    centres: dict[int, tuple[int, int]],
) -> None:
    """Put the blocks of a feedback path below the others, from right to left."""
    from_x = x.get(next(w.source for w in graph.wires if w.target == chain[0]), 0)
    to_x = min((x[i] for i in _goals(graph, chain) & centres.keys()), default=from_x)
    length = sum(sizes[i][0] + _GAP for i in chain)
    if from_x - to_x < length:
        middle = (from_x + to_x) / 2
        from_x, to_x = round(middle + length / 2), round(middle - length / 2)
    for k, i in enumerate(chain, 1):
        x[i] = _snap(from_x + (to_x - from_x) * k / (len(chain) + 1))
        y = _snap(floor + _ROW + sizes[i][1] / 2)
        while any(touch((x[i], y), sizes[i], at, sizes[j]) for j, at in centres.items()):
            y += GRID
        centres[i] = (x[i], y)


def touch(
    a: tuple[int, int], size_a: tuple[int, int], b: tuple[int, int], size_b: tuple[int, int]
) -> bool:
    """Whether two blocks overlap or are too close for a wire between them."""
    return (
        abs(a[0] - b[0]) < (size_a[0] + size_b[0]) / 2 + 2 * GRID
        and abs(a[1] - b[1]) < (size_a[1] + size_b[1]) / 2 + _ROW / 2
    )


def port_offset(port: int, ports: int) -> float:
    """Height of a port over the centre of its block."""
    return _PORT * (port - (ports - 1) / 2)


def _snap(value: float) -> int:
    return GRID * round(value / GRID)


def _up(value: float) -> int:
    return 2 * GRID * math.ceil(value / (2 * GRID))
