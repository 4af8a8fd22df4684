"""What a model file says of blocks, ports, events and the note: positions in pixels, numbers."""

import json
import runpy
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.pathview import convert_model, export_script
from pathsim_jsbsim_blocks.pathview.diagram import Diagram, Event, Graph, Node, Wire
from pathsim_jsbsim_blocks.pathview.pvm import model

pytest.importorskip("pathview")

A, B = Node("a", "Block", {}, [], ["out"]), Node("b", "Block", {}, ["in"], ["out"])
A_TO_B = Wire(0, 0, 1, 0)
EVENTS = [Event("first", "pathsim.events.Event", {}), Event("second", "pathsim.events.Event", {})]
WORDS = "0123456789 " * 9 + "1"  # 100 characters


def written(nodes, wires=(), events=(), docstring="", existing=None):
    graph = Graph(list(nodes), list(wires), list(events))
    return model(Diagram(Path("diagram.py"), docstring, graph, "", {}, 1.0, []), existing)


def positions(items):
    return {item["name"]: (item["position"]["x"], item["position"]["y"]) for item in items}


def test_events_stand_in_a_row_below_the_blocks():
    # the blocks are 80 by 40: from 0 to 220 and from -20 to 20; an event is 80 wide
    new = written([A, B], [A_TO_B], EVENTS)
    assert positions(new["graph"]["nodes"]) == {"a": (40, 0), "b": (180, 0)}
    assert positions(new["events"]) == {"first": (40, 140), "second": (160, 140)}
    old = {"events": [{"name": "second", "position": {"x": 7, "y": 8}}]}
    assert positions(written([A, B], [A_TO_B], EVENTS, existing=old)["events"]) == {
        "first": (40, 140),
        "second": (7, 8),
    }


def test_the_note_stands_above_the_blocks():
    (note,) = written([A, B], [A_TO_B], docstring="Title.")["graph"]["annotations"]
    # at least 420 wide; 50 high without text, and 30 of air
    assert (note["width"], note["height"], note["position"]) == (420, 50, {"x": 0, "y": -100})
    (note,) = written([A, B], [A_TO_B], docstring=f"Title.\n\n{WORDS}")["graph"]["annotations"]
    # 100 characters of 6.2 px in 400: two lines of 16, and 10 after them; up to the next 10
    assert (note["height"], note["position"]["y"]) == (100, -20 - 100 - 30)
    back = [A_TO_B, Wire(1, 0, 2, 0), Wire(2, 0, 1, 0)]
    c = Node("c", "Block", {}, ["in"], ["out"])
    (note,) = written([A, B, c], back, docstring="Title.")["graph"]["annotations"]
    assert note["position"]["y"] == -100 - 10  # a wire that runs back takes 10 above
    chain = [Node(f"n{i}", "Block", {}, ["in"], ["out"]) for i in range(9)]
    wires = [Wire(i, 0, i + 1, 0) for i in range(8)]
    for n, width in ((4, 500), (6, 760)):  # as wide as the blocks, at most 760
        (note,) = written(chain[:n], wires[: n - 1], docstring="Title.")["graph"]["annotations"]
        assert note["width"] == width


def test_new_blocks_stand_beside_those_that_were_there():
    c = Node("c", "Block", {}, ["in"], ["out"])
    old = {
        "graph": {
            "nodes": [
                {"name": "a", "position": {"x": 1040, "y": 503}, "params": {"_rotation": 1}},
                {"name": "b", "position": {"x": 1220, "y": 497}},
            ]
        }
    }
    new = written([A, B, c], [A_TO_B, Wire(1, 0, 2, 0)], existing=old)
    assert positions(new["graph"]["nodes"]) == {
        "a": (1040, 503),
        "b": (1220, 497),
        "c": (1340, 500),
    }
    assert [n["params"] for n in new["graph"]["nodes"]] == [{"_rotation": 1}, {}, {}]
    (note,) = written([A, B], [A_TO_B], docstring="Title.", existing=old)["graph"]["annotations"]
    assert (note["width"], note["position"]) == (420, {"x": 1000, "y": 480 - 50 - 30})
    # where its place is taken, below: 40 high and 30 between
    old["graph"]["nodes"][1]["position"]["x"] = 1400
    old["graph"]["nodes"][0]["position"]["x"] = 860
    new = written([A, B, c], [A_TO_B, Wire(1, 0, 2, 0)], existing=old)
    assert positions(new["graph"]["nodes"])["c"] == (1340, 570)


@pytest.mark.parametrize(
    ("values", "shown"),
    [
        (["1", "2"], ["p0", "p1"]),
        (["1", "2", "3", "4"], ["p0", "p1", "p2"]),
        (["x" * 18], ["p0"]),
        (["x" * 19, "1"], ["p0", "p1"]),  # PathView cuts what does not fit
    ],
)
def test_the_first_parameters_are_shown_on_the_block(values, shown):
    params = {f"p{i}": value for i, value in enumerate(values)}
    (node,) = written([Node("a", "Block", params, [], ["out"])])["graph"]["nodes"]
    assert node["pinnedParams"] == shown
    (node,) = written([Node("a", "Scope", params, ["in"], [])])["graph"]["nodes"]
    assert "pinnedParams" not in node


@pytest.mark.parametrize(
    ("ports", "labels"),
    [
        (["in 0", "in 1"], False),
        (["in"], False),
        (["y"], False),
        (["theta", "q"], True),
        (["in 0", "q"], True),
    ],
)
def test_names_of_ports_are_shown_where_they_say_something(ports, labels):
    (node,) = written([Node("a", "Block", {}, ports, ["out"])])["graph"]["nodes"]
    assert node["params"].get("_showInputLabels", False) is labels
    assert "_showOutputLabels" not in node["params"]
    assert [(p["name"], p["index"], p["direction"]) for p in node["inputs"]] == [
        (name, i, "input") for i, name in enumerate(ports)
    ]


SCRIPT = """
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Constant, Scope

port = Interface()
total = Adder()
part = Subsystem([port, total], [
    Connection(port[0], total[0]), Connection(port[1], total[1]), Connection(port[2], total[2]),
    Connection(total, port[0])])
a = Constant(max(
    1.0,
    0.5))
b = Constant(2.0)
c = Constant(3.0)
scope = Scope()
sim = Simulation([a, b, c, part, scope], [
    Connection(a, part[0]), Connection(b, part[1]), Connection(c, part[2]),
    Connection(part[0], scope[0]), Connection(part[1], scope[2])], log=False)

if __name__ == "__main__":
    sim.run(1.0)
"""


def test_a_block_has_the_ports_that_are_wired_on_either_side(tmp_path):
    path = tmp_path / "ports.py"
    path.write_text(SCRIPT)
    text = export_script(path).read_text(encoding="utf-8")
    assert text.startswith('{\n  "version": ')
    assert text.endswith("\n}\n")
    graph = json.loads(text)["graph"]

    def ports(nodes):
        return {n["name"]: (len(n["inputs"]), len(n["outputs"])) for n in nodes}

    assert ports(graph["nodes"]) == {
        "a": (0, 1),
        "b": (0, 1),
        "c": (0, 1),
        "part": (3, 2),
        "scope": (3, 0),
    }
    assert graph["nodes"][0]["params"] == {"value": "max(1.0, 0.5)"}
    (part,) = (n for n in graph["nodes"] if n["name"] == "part")
    assert ports(part["graph"]["nodes"]) == {"Interface": (2, 3), "total": (3, 1)}
    assert sorted((w["sourcePortIndex"], w["targetPortIndex"]) for w in graph["connections"]) == [
        (0, 0),
        (0, 0),
        (0, 1),
        (0, 2),
        (1, 2),
    ]
    # the third input goes on inside, though the subsystem has two outputs only
    again = runpy.run_path(str(convert_model(path.with_suffix(".pvm"), tmp_path / "out.py")))
    again["sim"].run(0.1)
    assert again["scope"].read()[1][0][-1] == 1.0 + 2.0 + 3.0
