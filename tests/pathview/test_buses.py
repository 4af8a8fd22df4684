"""Buses of PathView: a wire that its expansion leaves out is refused, all others fly."""

import json

import pytest
from pathview_models import block, model, subsystem, wire

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import convert_model


def sources(*names):
    return [block(name, "Constant", value=str(i + 1.0)) for i, name in enumerate(names)]


def into(creator, *names):
    return [{**wire(name, creator, 0, i), "label": name} for i, name in enumerate(names)]


BUS = [*sources("theta", "q"), block("bus", "BusCreator", 2, 1)]
WIRES = into("bus", "theta", "q")


def selector(*signals, name="sel"):
    return block(name, "BusSelector", 1, len(signals), signals=list(signals))


def within(*nodes, connections, inputs=1, outputs=1, name="S"):
    io = block(f"{name}-io", "Interface", outputs, inputs)
    return subsystem(name, io, *nodes, inputs=inputs, outputs=outputs, connections=connections)


SCOPE = block("out", "Scope", 1, 0)

BAD = {
    "a signal that the bus lacks": (
        model(*BUS, selector("thet"), SCOPE,
              connections=[*WIRES, wire("bus", "sel"), wire("sel", "out")]),
        "bus selector 'sel': its bus has no signal 'thet'; did you mean 'theta'",
    ),
    "a bus into a plain block": (
        model(*BUS, SCOPE, connections=[*WIRES, wire("bus", "out")]),
        "connection from 'bus' to 'out', input 0, is a bus: select one of theta, q",
    ),
    "an output without a signal": (
        model(*BUS, selector(""), SCOPE,
              connections=[*WIRES, wire("bus", "sel"), wire("sel", "out")]),
        "connection from 'sel' to 'out', input 0, does not reach a signal",
    ),
    "a selector of a plain signal": (
        model(*sources("theta"), selector("theta"), SCOPE,
              connections=[wire("theta", "sel"), wire("sel", "out")]),
        "bus selector 'sel': its bus has no signal 'theta'",
    ),
    "a signal that is not connected": (
        model(*BUS, selector("1"), SCOPE,
              connections=[WIRES[0], wire("bus", "sel"), wire("sel", "out")]),
        "connection from 'sel' to 'out', input 0, does not reach a signal",
    ),
    "a bus of a bus into a plain block": (
        model(*BUS, block("all", "BusCreator", 1, 1), selector("bus"), SCOPE,
              connections=[*WIRES, {**wire("bus", "all"), "label": "bus"}, wire("all", "sel"),
                           wire("sel", "out")]),
        "connection from 'sel' to 'out', input 0, is a bus: select one of theta, q",
    ),
    "in a subsystem": (
        model(*BUS, within(selector("alpha"), connections=[
            wire("S-io", "sel"), wire("sel", "S-io")]), SCOPE,
              connections=[*WIRES, wire("bus", "S"), wire("S", "out")]),
        "bus selector 'sel': its bus has no signal 'alpha'",
    ),
    "two subsystems deep, into a plain block": (
        model(*BUS, within(within(block("gain", "Amplifier", 1, 1), name="T", connections=[
            wire("T-io", "gain"), wire("gain", "T-io")]),
            connections=[wire("S-io", "T"), wire("T", "S-io")]), SCOPE,
              connections=[*WIRES, wire("bus", "S"), wire("S", "out")]),
        "connection from 'T-io' to 'gain', input 0, is a bus: select one of theta, q",
    ),
    "not connected, and selected in a subsystem": (
        model(*BUS, within(selector("1"), connections=[
            wire("S-io", "sel"), wire("sel", "S-io")]), SCOPE,
              connections=[WIRES[0], wire("bus", "S"), wire("S", "out")]),
        "subsystem 'S': a bus of its inputs has an unconnected signal",
    ),
    "not connected in a subsystem, and selected outside": (
        model(within(*BUS, connections=[WIRES[0], wire("bus", "S-io")], inputs=0),
              selector("1"), SCOPE, connections=[wire("S", "sel"), wire("sel", "out")]),
        "subsystem 'S': a bus of its outputs has an unconnected signal",
    ),
}  # fmt: skip


def converted(content, folder):
    (folder / "model.pvm").write_text(json.dumps(content))
    return convert_model(folder / "model.pvm", folder / "out.py").read_text()


@pytest.mark.parametrize("case", BAD)
def test_a_wire_that_the_expansion_of_buses_loses_is_refused(case, tmp_path):
    content, message = BAD[case]
    with pytest.raises(DiagramError, match=message):
        converted(content, tmp_path)
    assert not (tmp_path / "out.py").exists()


GOOD = {
    "through a subsystem": (
        [*BUS, within(selector("q", "theta"), outputs=2, connections=[
            wire("S-io", "sel"), wire("sel", "S-io"), wire("sel", "S-io", 1, 1)])],
        [*WIRES, wire("bus", "S"), wire("S", "out"), wire("S", "out", 1, 1)],
    ),
    "made in a subsystem": (
        [within(*BUS, inputs=0, connections=[*WIRES, wire("bus", "S-io")]),
         selector("q", "theta")],
        [wire("S", "sel"), wire("sel", "out"), wire("sel", "out", 1, 1)],
    ),
    "a bus of buses": (
        [*BUS, block("all", "BusCreator", 1, 1), selector("bus.q", "bus.theta")],
        [*WIRES, {**wire("bus", "all"), "label": "bus"}, wire("all", "sel"), wire("sel", "out"),
         wire("sel", "out", 1, 1)],
    ),
    "an input without a selection is not connected": (
        [*BUS[:2], block("bus", "BusCreator", 3, 1), selector("q", "theta")],
        [*WIRES, wire("bus", "sel"), wire("sel", "out"), wire("sel", "out", 1, 1)],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", GOOD)
def test_selected_signals_arrive(case, tmp_path):
    nodes, connections = GOOD[case]
    # two wires between the same blocks have ids of their own
    connections = [{**x, "id": f"{x['id']}-{i}"} for i, x in enumerate(connections)]
    code = converted(model(*nodes, block("out", "Scope", 2, 0), connections=connections), tmp_path)
    script = {"__name__": "model"}
    exec(compile(code, "model", "exec"), script)
    script["sim"].run(0.05)
    assert script["out"].read()[1][:, -1].tolist() == [2.0, 1.0]
