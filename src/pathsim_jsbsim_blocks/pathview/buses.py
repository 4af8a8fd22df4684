"""Check that each wire of a model with buses is in the model without them, which PathView runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from .._core.checks import did_you_mean, nearest
from .shape import Json

BUSES = {"BusCreator", "BusSelector"}


def check_buses(graph: Json, refuse: Callable[[str], Any]) -> None:
    """Refuse, by ``refuse(reason)``, what PathView's expansion of buses leaves out."""
    from pathview.buses import BusModel, expand_buses

    model = BusModel(graph["nodes"], graph["connections"])
    nodes, connections = expand_buses(graph["nodes"], graph["connections"])
    _level(model, model.root, nodes, connections, refuse)


def _level(
    model: Any,
    level: Any,
    nodes: Sequence[Json],
    connections: Sequence[Json],
    refuse: Callable[[str], Any],
) -> None:
    for node in level.node_list:
        if node["type"] == "BusSelector":
            _selector(node, model.structure_in(level, node["id"], 0), refuse)
    names = {connection["id"] for connection in connections}
    ends = {(x["targetNodeId"], x["targetPortIndex"]) for x in connections}
    for connection in level.connections:
        target, port = level.nodes[connection["targetNodeId"]], connection["targetPortIndex"]
        if target["type"] in BUSES:
            continue
        # PathView numbers the ports of subsystems anew, and the wires of a bus: "id.0", "id.1"
        bears_numbers = target["type"] in ("Subsystem", "Interface")
        remains = {connection["id"], f"{connection['id']}.0"} & names
        if not (remains if bears_numbers else (target["id"], port) in ends):
            source, output = connection["sourceNodeId"], connection["sourcePortIndex"]
            bus = model.structure_out(level, source, output)
            why = "does not reach a signal"
            if bus:
                why = f"is a bus: select one of {', '.join(name for name, _ in bus)}"
            what = f"connection from {level.nodes[source]['name']!r} to {target['name']!r}"
            refuse(f"{what}, input {port}, {why}")
    for node in nodes:
        if inner := level.children.get(node["id"]):
            graph = node["graph"]
            _level(model, inner, graph["nodes"], graph["connections"], refuse)
            interface = next((n["id"] for n in inner.node_list if n["type"] == "Interface"), None)
            for side, outer, into, entering, leaving in (
                ("inputs", level, node["id"], connections, graph["connections"]),
                ("outputs", inner, interface, graph["connections"], connections),
            ):
                # a signal that its bus creator lacks is used on the other side of the border
                count = sum(x["targetNodeId"] == into for x in outer.connections)
                sources = {node["id"], interface} - {into}
                outputs = {x["sourcePortIndex"] for x in leaving if x["sourceNodeId"] in sources}
                inputs = {x["targetPortIndex"] for x in entering if x["targetNodeId"] == into}
                if count == len(node[side]) and outputs - inputs:
                    refuse(
                        f"subsystem {node['name']!r}: a bus of its {side} has an unconnected signal"
                    )


def _selector(selector: Json, bus: Any, refuse: Callable[[str], Any]) -> None:
    from pathview.buses import element_at, selected_signals, signal_leaves

    for path in selected_signals(selector):
        if path and not element_at(bus, path)[0]:
            what = f"bus selector {selector['name']!r}: its bus has no signal {path!r}"
            refuse(what + did_you_mean(nearest(path, signal_leaves(bus))))
