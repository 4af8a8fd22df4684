"""Automatic layout: what a reader expects of any diagram, and no overlaps in all of them."""

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pathsim_jsbsim_blocks.pathview.diagram import Graph, Node, Wire
from pathsim_jsbsim_blocks.pathview.layout import arrange, size

pytest.importorskip("pathview")


def graph(wires, ports=None, kinds=None):
    """From ``"a>b a>c.1"``: wires by names, with the number of the target's port."""
    names = list(dict.fromkeys(
        n.partition(".")[0] for w in wires.split() for n in w.split(">")))
    found, into, out = [], dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    for wire in wires.split():
        source, target = wire.split(">")
        target, _, port = target.partition(".")
        out[source] = 1
        into[target] = max(into[target], int(port or 0) + 1)
        found.append(Wire(names.index(source), 0, names.index(target), int(port or 0)))
    nodes = [Node(n, (kinds or {}).get(n, "Block"), {},
                  [f"in {i}" for i in range(into[n])],
                  [f"out {i}" for i in range((ports or {}).get(n, out[n]))]) for n in names]
    return Graph(nodes, found, [])


def placed(g, pinned=0):
    sizes = [size(n, pinned) for n in g.nodes]
    layout = arrange(g, sizes)
    x, y = ({n.name: c[k] for n, c in zip(g.nodes, layout.centres, strict=True)} for k in (0, 1))
    return x, y, {g.nodes[i].name for i in layout.turned}


def test_signals_run_from_left_to_right_in_straight_lines():
    x, y, turned = placed(graph("source>gain gain>filter filter>scope"))
    assert x["source"] < x["gain"] < x["filter"] < x["scope"]
    assert len(set(y.values())) == 1
    assert not turned


def test_feedback_blocks_are_turned_and_below():
    x, y, turned = placed(graph(
        "step>sum sum>plant plant>scope plant>sensor sensor>filter filter>sum.1"))
    assert turned == {"sensor", "filter"}
    assert x["sum"] < x["filter"] < x["sensor"] < x["plant"] < x["scope"]
    assert min(y["sensor"], y["filter"]) > max(y[n] for n in ("step", "sum", "plant"))


def test_an_oscillator_begins_at_its_sum():
    x, _, turned = placed(graph("v>x v>damper x>spring spring>sum damper>sum.1 sum>mass mass>v "
                                "x>scope v>scope.1"))
    assert turned == {"spring", "damper"}
    assert x["sum"] < x["mass"] < x["v"] < x["x"] < x["scope"]


def test_a_controller_stands_before_its_plant():
    """Many outputs make the plant, although it is wired first and comes back everywhere."""
    x, _, turned = placed(graph("plane>hold plane>hold.1 plane>hold.2 set>hold.3 hold>plane "
                                "plane>scope", ports={"plane": 22}))
    assert x["set"] < x["hold"] < x["plane"] < x["scope"]
    assert not turned


def test_an_interface_is_where_a_subsystem_begins():
    x, _, _ = placed(graph("io>gain gain>filter filter>io", kinds={"io": "Interface"}))
    assert x["io"] < x["gain"] < x["filter"]


def test_a_source_stands_right_before_its_target():
    x, _, _ = placed(graph("a>b b>c late>c.1 c>scope"))
    assert x["late"] == x["b"]


@given(st.integers(1, 9), st.data())
@settings(max_examples=80, deadline=None)
def test_nothing_overlaps_and_all_is_on_the_grid(n, data):
    ends = data.draw(st.lists(st.tuples(*[st.integers(0, n - 1)] * 2), max_size=3 * n))
    into = [0] * n
    wires = []
    for source, target in ends:
        wires.append(Wire(source, 0, target, into[target]))
        into[target] += 1
    outputs = {w.source for w in wires}
    nodes = [Node("x" * data.draw(st.integers(1, 20)), "Block", {}, ["in"] * into[i],
                  ["out"] * data.draw(st.integers(int(i in outputs), 6))) for i in range(n)]
    sizes = [size(node, data.draw(st.integers(0, 3))) for node in nodes]
    layout = arrange(Graph(nodes, wires, []), sizes)
    assert all(v % 10 == 0 for c in layout.centres for v in c)
    for (a, box_a), (b, box_b) in itertools.combinations(
            zip(layout.centres, sizes, strict=True), 2):
        assert (abs(a[0] - b[0]) >= (box_a[0] + box_b[0]) / 2
                or abs(a[1] - b[1]) >= (box_a[1] + box_b[1]) / 2)
