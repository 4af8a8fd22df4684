"""Automatic layout: signals from left to right, feedback turned and below, scopes at the right."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field
from statistics import mean, median_low

from .diagram import Graph, Node

GRID = 10  # PathView's grid, px
_PORT = 20  # between ports
_ROW = 60  # free height between blocks
_GAP = 90  # free width between columns, and more for each wire that turns there
_SWEEPS = 12
_BIG = 4  # outputs: a plant, from which the loops of a diagram go back

Edge = tuple[int, int]


@dataclass
class Layout:
    """Centres of the nodes in px, and which of them are turned (inputs at the right)."""

    centres: list[tuple[int, int]]
    turned: set[int] = field(default_factory=set)


def size(node: Node, pinned: int = 0) -> tuple[int, int]:
    """Width and height in px at which PathView draws a node."""
    width = max(80, 6 * len(node.name) + 20, 5 * len(node.type) + 20, 160 if pinned else 0)
    height = max(
        40 + (7 + 24 * pinned if pinned else 0), _PORT * max(len(node.inputs), len(node.outputs), 1)
    )
    return _up(width), _up(height)


def arrange(graph: Graph, sizes: list[tuple[int, int]]) -> Layout:
    """Place the nodes of one level of a diagram."""
    nodes = graph.nodes
    interface = next((i for i, n in enumerate(nodes) if n.type == "Interface"), None)
    sinks = {i for i, n in enumerate(nodes) if not n.outputs and i != interface}
    inner = [i for i in range(len(nodes)) if i not in sinks]
    edges = {(w.source, w.target) for w in graph.wires if w.target not in sinks}
    observed = {w.source for w in graph.wires if w.target in sinks}
    cut = {e for e in edges if e[0] == e[1] or e[1] == interface}
    loops: set[int] = set()
    while components := _loops(inner, edges - cut):
        for component in components:
            loops |= component
            hub = _hub(component, edges, nodes, observed)
            cut |= {(hub, i) for i in component} & edges
    turned = _feedback(nodes, edges, cut, loops)

    layer = _layers(
        [i for i in inner if i not in turned], {e for e in edges - cut if not turned & set(e)}
    )
    last = max(layer.values(), default=-1)
    for i in sinks:
        layer[i] = last + 1
    for i in inner:
        # align a block that only feeds a scope with the other blocks that feed scopes
        if i not in turned and i in observed and not any(i in e for e in edges):
            layer[i] = max(last, 0)
    y = _rows(graph, sizes, layer, cut)
    x = _columns(graph, sizes, layer)
    centres = {i: (_snap(x[layer[i]]), _snap(y[i])) for i in layer}
    _place_turned(graph, sizes, turned, cut, centres)
    return Layout([centres[i] for i in range(len(nodes))], turned)


def _loops(nodes: Iterable[int], edges: Collection[Edge]) -> list[set[int]]:
    """Groups of nodes on common loops: strongly connected components (Tarjan)."""
    after = defaultdict(list)
    for a, b in sorted(edges):
        after[a].append(b)
    index: dict[int, int] = {}
    low: dict[int, int] = {}
    stack: list[int] = []
    found: list[set[int]] = []

    def visit(v: int) -> None:
        index[v] = low[v] = len(index)
        stack.append(v)
        for w in after[v]:
            if w not in index:
                visit(w)
                low[v] = min(low[v], low[w])
            elif w in stack:
                low[v] = min(low[v], index[w])
        if low[v] == index[v]:
            at = stack.index(v)
            if len(stack) > at + 1:
                found.append(set(stack[at:]))
            del stack[at:]

    for v in nodes:
        if v not in index:
            visit(v)
    return found


def _hub(loop: set[int], edges: Collection[Edge], nodes: list[Node], observed: set[int]) -> int:
    """The node after which a loop is opened: the plant, or what is last before a scope."""
    inside = [(a, b) for a, b in edges if a in loop and b in loop]
    entries = {b for a, b in edges if b in loop and a not in loop}
    if not entries:  # a loop on its own begins at its summing junction
        entries = {max(sorted(loop), key=lambda i: sum(b == i for _, b in inside))}
    depth = dict.fromkeys(entries, 0)
    todo = sorted(entries)
    for a in todo:
        for b in sorted(b for s, b in inside if s == a and b not in depth):
            depth[b] = depth[a] + 1
            todo.append(b)

    def rank(i: int) -> tuple:
        outputs = len(nodes[i].outputs)
        return outputs if outputs >= _BIG else 0, i in observed, depth[i], -i

    return max(loop, key=rank)


def _feedback(
    nodes: list[Node], edges: Collection[Edge], cut: Collection[Edge], loops: set[int]
) -> set[int]:
    """Blocks on the way back: fed by one block, which is where a loop was opened or on that way."""
    before = defaultdict(set)
    for a, b in edges:
        before[b].add(a)
    turned: set[int] = set()
    openers = {a for a, _ in cut}
    while True:
        more = {
            i
            for i in loops - turned - openers
            if len(nodes[i].inputs) <= 2
            and len(before[i]) == 1
            and all(a in turned or (a, i) in cut for a in before[i])
        }
        if not more:
            return turned
        turned |= more


def _layers(nodes: list[int], edges: Collection[Edge]) -> dict[int, int]:
    """Column of each node: the longest path to it; a node without inputs is before its target."""
    layer = dict.fromkeys(nodes, 0)
    for _ in nodes:
        moved = False
        for a, b in edges:
            if layer[b] <= layer[a]:
                layer[b] = layer[a] + 1
                moved = True
        if not moved:
            break
    targets = {b for _, b in edges}
    for i in nodes:
        after = [layer[b] for a, b in edges if a == i]
        if i not in targets and after:
            layer[i] = min(after) - 1
    return layer


def _rows(
    graph: Graph, sizes: list[tuple[int, int]], layer: dict[int, int], cut: Collection[Edge]
) -> dict[int, float]:
    """Heights at which the wires between columns are as straight as they can be."""
    columns: dict[int, list[int]] = defaultdict(list)
    for i in sorted(layer):
        columns[layer[i]].append(i)
    y: dict[int, float] = {}
    for column in columns.values():
        y.update(_spread([(0.0, i) for i in column], sizes))
    wires = [
        w
        for w in graph.wires
        if w.source in layer and w.target in layer and (w.source, w.target) not in cut
    ]
    pulls: dict[int, list[tuple[int, float]]] = defaultdict(list)
    for w in wires:
        # where the target's centre is to be above the source's for a straight wire
        shift = _offset(w.output, len(graph.nodes[w.source].outputs)) - _offset(
            w.input, len(graph.nodes[w.target].inputs)
        )
        pulls[w.target].append((w.source, shift))
        pulls[w.source].append((w.target, -shift))
    for sweep in range(_SWEEPS + 1):
        forward = sweep % 2 == 0
        for number in sorted(columns, reverse=not forward):
            wished = []
            for i in columns[number]:
                sides = [y[j] + s for j, s in pulls[i] if (layer[j] < layer[i]) == forward]
                # in the last sweep prefer one straight wire to two that are nearly straight
                middle = mean if sweep < _SWEEPS else median_low
                wished.append((middle(sides) if sides else y[i], i))
            wished.sort(key=None if sweep < _SWEEPS else lambda w: y[w[1]])
            y.update(_spread(wished, sizes))
    return y


def _spread(wished: list[tuple[float, int]], sizes: list[tuple[int, int]]) -> dict[int, float]:
    """Heights close to the wished ones that keep the blocks of a column in this order."""
    # groups of touching blocks, each at the mean of its blocks' wishes
    groups: list[tuple[list[int], list[float], float]] = []  # blocks, offsets, sum of wishes
    for wish, i in wished:
        group = ([i], [0.0], wish)
        while groups:
            blocks, offsets, total = groups[-1]
            gap = (sizes[blocks[-1]][1] + sizes[group[0][0]][1]) / 2 + _ROW
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


def _columns(graph: Graph, sizes: list[tuple[int, int]], layer: dict[int, int]) -> dict[int, float]:
    """Centre of each column, with room for the wires that turn before it."""
    x: dict[int, float] = {}
    right = 0.0
    for number in sorted(set(layer.values())):
        half = max(sizes[i][0] for i in layer if layer[i] == number) / 2
        turning = {
            (w.source, w.output)
            for w in graph.wires
            if layer.get(w.target) == number and w.source in layer
        }
        x[number] = right + half if not x else right + _GAP + GRID * min(len(turning), 10) + half
        right = x[number] + half
    return x


def _place_turned(
    graph: Graph,
    sizes: list[tuple[int, int]],
    turned: set[int],
    cut: Collection[Edge],
    centres: dict[int, tuple[int, int]],
) -> None:
    """Put the blocks on the way back below the others, from right to left."""
    floor = max(
        (y + sizes[i][1] / 2 for i, (_, y) in centres.items() if graph.nodes[i].outputs),
        default=0.0,
    )
    for start in sorted(turned):
        if start in centres:
            continue
        chain = _chain(graph, start, turned - centres.keys())
        source = next(w.source for w in graph.wires if w.target == chain[0])
        goals = [
            centres[w.target][0]
            for w in graph.wires
            if w.source == chain[-1] and w.target in centres and graph.nodes[w.target].outputs
        ]
        from_x = centres[source][0]
        to_x = min(goals, default=from_x)
        needed = sum(sizes[i][0] + _GAP for i in chain)
        if from_x - to_x < needed:
            middle = (from_x + to_x) / 2
            from_x, to_x = round(middle + needed / 2), round(middle - needed / 2)
        for k, i in enumerate(chain, 1):
            x = _snap(from_x + (to_x - from_x) * k / (len(chain) + 1))
            y = _snap(floor + _ROW + sizes[i][1] / 2)
            while any(touch((x, y), sizes[i], at, sizes[j]) for j, at in centres.items()):
                y += GRID
            centres[i] = (x, y)


def _chain(graph: Graph, start: int, turned: Collection[int]) -> list[int]:
    """``start`` with the turned blocks before and after it, in the order of the signal."""
    chain = [start]
    before = {w.target: w.source for w in graph.wires if w.target in turned}
    while (first := before.get(chain[0], start)) in turned and first not in chain:
        chain.insert(0, first)
    while True:
        after = [
            w.target
            for w in graph.wires
            if w.source == chain[-1] and w.target in turned and w.target not in chain
        ]
        if not after:
            return chain
        chain.append(after[0])


def touch(
    a: tuple[int, int], size_a: tuple[int, int], b: tuple[int, int], size_b: tuple[int, int]
) -> bool:
    """Whether two blocks overlap or are too close for a wire between them."""
    return (
        abs(a[0] - b[0]) < (size_a[0] + size_b[0]) / 2 + 2 * GRID
        and abs(a[1] - b[1]) < (size_a[1] + size_b[1]) / 2 + _ROW / 2
    )


def _offset(port: int, ports: int) -> float:
    """Height of a port over the centre of its block."""
    return _PORT * (port - (ports - 1) / 2)


def _snap(value: float) -> int:
    return GRID * round(value / GRID)


def _up(value: float) -> int:
    return 2 * GRID * math.ceil(value / (2 * GRID))
