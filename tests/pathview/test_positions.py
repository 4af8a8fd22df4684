"""Positions of a model that is exported again, and ports; new positions are those of test_committed."""

import json
import runpy
from pathlib import Path

from scripts_of_tests import script

from pathsim_jsbsim_blocks.pathview import convert_model
from pathsim_jsbsim_blocks.pathview.diagram import Diagram, Event, Graph, Node, Wire
from pathsim_jsbsim_blocks.pathview.pvm import model

A, B = Node("a", "Block", {}, [], ["out"]), Node("b", "Block", {}, ["in"], ["out"])
A_TO_B = Wire(0, 0, 1, 0)


def written(nodes, wires=(), events=(), docstring="", existing=None):
    graph = Graph(list(nodes), list(wires), list(events))
    return model(Diagram(Path("diagram.py"), docstring, graph, "", {}, 1.0, []), existing)


def positions(items):
    return {item["name"]: (item["position"]["x"], item["position"]["y"]) for item in items}


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
    # below where another block stands within 20 px of its place: 40 high and 30 between
    old["graph"]["nodes"][1]["position"]["x"] = 1430
    old["graph"]["nodes"][0]["position"]["x"] = 830
    new = written([A, B, c], [A_TO_B, Wire(1, 0, 2, 0)], existing=old)
    assert positions(new["graph"]["nodes"])["c"] == (1340, 570)


def test_events_stand_in_a_row_below_the_blocks_or_stay_where_they_were():
    events = [Event(name, "pathsim.events.Event", {}) for name in ("first", "second", "third")]
    old = {"events": [{"name": "third", "position": {"x": 7, "y": 8}}]}
    # the blocks end at 20; an event is 80 wide
    assert positions(written([A, B], [A_TO_B], events, existing=old)["events"]) == {
        "first": (40, 140),
        "second": (160, 140),
        "third": (7, 8),
    }


BLOCKS = """
port, total = Interface(), Adder()
part = Subsystem([port, total], [
    *(Connection(port[i], total[i]) for i in range(3)), Connection(total, port[0])])
a = Constant(max(
    1.0,
    0.5))
b, c, scope = Constant(2.0), Constant(3.0), Scope()
"""
WIRES = """*(Connection(x, part[i]) for i, x in enumerate((a, b, c))),
    Connection(part[0], scope[0]), Connection(part[1], scope[2])"""


def test_a_block_has_the_ports_that_are_wired_on_either_side(export, tmp_path):
    export(script(BLOCKS, WIRES, names="a, b, c, part, scope", after="sim.run(1.0)"))
    path = tmp_path / "script.pvm"
    text = path.read_text(encoding="utf-8")
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
    wires = [(w["sourcePortIndex"], w["targetPortIndex"]) for w in graph["connections"]]
    assert sorted(wires) == [(0, 0), (0, 0), (0, 1), (0, 2), (1, 2)]
    # the third input goes on inside, though the subsystem has two outputs only
    again = runpy.run_path(str(convert_model(path, tmp_path / "out.py")))
    again["sim"].run(0.1)
    assert again["scope"].read()[1][0][-1] == 1.0 + 2.0 + 3.0
