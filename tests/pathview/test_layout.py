"""Automatic layout: what a reader expects of any diagram, and no overlaps in all of them."""

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pathsim_jsbsim_blocks.pathview.diagram import Graph, Node, Wire
from pathsim_jsbsim_blocks.pathview.layout import arrange, size


def graph(wires, ports=None, kinds=None):
    """From ``"a>b a>c.1"``: wires by names, with the number of the target's port."""
    names = list(dict.fromkeys(n.partition(".")[0] for w in wires.split() for n in w.split(">")))
    found, into, out = [], dict.fromkeys(names, 0), dict.fromkeys(names, 0)
    for wire in wires.split():
        source, target = wire.split(">")
        target, _, port = target.partition(".")
        out[source] = 1
        into[target] = max(into[target], int(port or 0) + 1)
        found.append(Wire(names.index(source), 0, names.index(target), int(port or 0)))
    nodes = [
        Node(
            n,
            (kinds or {}).get(n, "Block"),
            {},
            [f"in {i}" for i in range(into[n])],
            [f"out {i}" for i in range((ports or {}).get(n, out[n]))],
        )
        for n in names
    ]
    return Graph(nodes, found, [])


def placed(g, pinned=0):
    sizes = [size(n, pinned) for n in g.nodes]
    layout = arrange(g, sizes)
    x, y = ({n.name: c[k] for n, c in zip(g.nodes, layout.centres, strict=True)} for k in (0, 1))
    return x, y, {g.nodes[i].name for i in layout.turned}


def test_feedback_blocks_are_turned_and_below():
    x, y, turned = placed(
        graph("step>sum sum>plant plant>scope plant>sensor sensor>filter filter>sum.1")
    )
    assert turned == {"sensor", "filter"}
    assert x["sum"] < x["filter"] < x["sensor"] < x["plant"] < x["scope"]
    assert min(y["sensor"], y["filter"]) > max(y[n] for n in ("step", "sum", "plant"))


def test_an_oscillator_begins_at_its_sum():
    x, _, turned = placed(
        graph("v>x v>damper x>spring spring>sum damper>sum.1 sum>mass mass>v x>scope v>scope.1")
    )
    assert turned == {"spring", "damper"}
    assert x["sum"] < x["mass"] < x["v"] < x["x"] < x["scope"]


def test_a_controller_stands_before_its_plant():
    """Many outputs make the plant, although it is wired first and comes back everywhere."""
    x, _, turned = placed(
        graph(
            "plane>hold plane>hold.1 plane>hold.2 set>hold.3 hold>plane plane>scope",
            ports={"plane": 22},
        )
    )
    assert x["set"] < x["hold"] < x["plane"] < x["scope"]
    assert not turned


def test_an_interface_is_where_a_subsystem_begins():
    x, _, _ = placed(graph("io>gain gain>filter filter>io", kinds={"io": "Interface"}))
    assert x["io"] < x["gain"] < x["filter"]


def test_a_source_stands_right_before_its_target():
    x, _, _ = placed(graph("a>b b>c late>c.1 c>scope"))
    assert x["late"] == x["b"]


@given(st.integers(1, 9), st.data())
def test_nothing_overlaps_and_all_is_on_the_grid(n, data):
    ends = data.draw(st.lists(st.tuples(*[st.integers(0, n - 1)] * 2), max_size=3 * n))
    into = [0] * n
    wires = []
    for source, target in ends:
        wires.append(Wire(source, 0, target, into[target]))
        into[target] += 1
    outputs = {w.source for w in wires}
    nodes = [
        Node(
            "x" * data.draw(st.integers(1, 20)),
            "Block",
            {},
            ["in"] * into[i],
            ["out"] * data.draw(st.integers(int(i in outputs), 6)),
        )
        for i in range(n)
    ]
    sizes = [size(node, data.draw(st.integers(0, 3))) for node in nodes]
    layout = arrange(Graph(nodes, wires, []), sizes)
    assert all(v % 10 == 0 for c in layout.centres for v in c)
    for (a, box_a), (b, box_b) in itertools.combinations(
        zip(layout.centres, sizes, strict=True), 2
    ):
        assert (
            abs(a[0] - b[0]) >= (box_a[0] + box_b[0]) / 2
            or abs(a[1] - b[1]) >= (box_a[1] + box_b[1]) / 2
        )


def test_a_scope_does_not_move_its_sources():
    """Each source is level with the block that it feeds, however far the scope of all is."""
    lanes = " ".join(f"s{i}>plane{i} s{i}>scope.{i}" for i in range(3))
    _, y, _ = placed(graph(lanes, ports={f"plane{i}": 22 for i in range(3)}))
    assert [y[f"s{i}"] for i in range(3)] == [y[f"plane{i}"] for i in range(3)]
    assert y["plane2"] - y["plane1"] == 440 + 60


def test_a_chain_too_long_for_a_page_goes_on_in_a_second_row():
    names = "abcdefghijkl"
    x, y, _ = placed(graph(" ".join(f"{m}>{n}" for m, n in itertools.pairwise(names))))
    rows = {n: [m for m in names if y[m] == y[n]] for n in names}
    assert [*rows.values()] == [list("abcdef")] * 6 + [list("ghijkl")] * 6
    assert x["a"] == x["g"] == 40
    assert max(x.values()) == 40 + 5 * (80 + 50 + 10)
    assert y["g"] - y["a"] == 40 + 60 + 10  # px: and 10 for the wire between


def test_two_ways_back_do_not_touch():
    x, y, turned = placed(
        graph("step>sum sum>plant plant>scope plant>one one>sum.1 plant>two two>sum.2")
    )
    assert turned == {"one", "two"}
    assert x["one"] == x["two"]
    assert abs(y["one"] - y["two"]) == 70


def test_wires_that_run_back_have_room_above_and_below():
    holds = ("one", "two", "three")
    back = " ".join(f"plane>{hold}.{i}" for hold in holds for i in range(4))
    on = " ".join(f"{hold}>plane.{i}" for i, hold in enumerate(holds))
    _, y, _ = placed(graph(f"{back} {on} plane>scope", ports={"plane": 8}))
    # blocks 80 high, 60 between, and 10 more: the four wires are of one port
    assert [y["one"], y["two"], y["three"]] == [-150, 0, 150]


def test_a_block_seen_only_by_a_scope_stands_beside_the_last_before_it():
    x, _, _ = placed(graph("a>b b>c c>scope alone>scope.1"))
    assert x["alone"] == x["c"]


def test_too_short_a_way_back_is_widened_about_its_middle():
    x, _, turned = placed(graph("step>sum sum>plant plant>scope plant>back back>way way>sum.1"))
    assert turned == {"back", "way"}
    middle = (x["sum"] + x["plant"]) / 2
    # 80 px and 50 for each of the two blocks
    assert [x["back"], x["way"]] == pytest.approx(
        [middle + 130 * side / 3 for side in (1, -1)], abs=5
    )


@pytest.mark.parametrize(
    ("name", "kind", "pinned", "expected"),
    [
        ("a" * 10, "Block", 0, (80, 40)),
        ("a" * 11, "Block", 0, (100, 40)),  # 6 px for a letter of the name, 5 for one of the type
        ("a", "B" * 13, 0, (100, 40)),
        ("a", "Block", 2, (160, 100)),  # and 24 for a pinned parameter
    ],
)
def test_a_block_is_as_large_as_pathview_draws_it(name, kind, pinned, expected):
    assert size(Node(name, kind, {}, [], ["out"]), pinned) == expected


def test_names_of_ports_have_room_inside_a_block():
    # 8 px and 4 for each letter, in steps of 20; numbers and recorders show no names
    for kind, port, width in (("Block", "a" * 16, 160), ("Block", "in 0", 80), ("Scope", "aa", 80)):
        assert size(Node("a", kind, {}, [port], [])) == (width, 40)
