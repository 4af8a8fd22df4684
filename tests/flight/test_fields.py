"""Parameters of the aircraft blocks that are those of a trim condition or an airframe."""

import inspect
from dataclasses import fields

import pytest
from pathsim_flight import JSBSimWrapper

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, LinearAircraft, TrimCondition
from pathsim_jsbsim_blocks.flight.airframe import Airframe

CONDITION = {f.name: (f.type, f.default) for f in fields(TrimCondition) if f.name != "setup"}
AIRFRAME = {
    name: (parameter.annotation, parameter.default)
    for name, parameter in inspect.signature(Airframe).parameters.items()
    if name not in ("aircraft", "dt")
}
OF_THE_WRAPPER = [*inspect.signature(JSBSimWrapper).parameters]


def declared(block):
    """Fields of a block, with type and default, by the names of a condition and an airframe."""
    names = {f.name: f.name.removeprefix("trim_") for f in fields(block) if f.init}
    names |= {"trim_airspeed": "speed", "JSBSim_path": "root"}
    return {names[f.name]: (f.type, f.default) for f in fields(block) if f.init}


@pytest.mark.parametrize(
    ("block", "count"), [(Aircraft, 20), (JSBSimFDM, 15), (LinearAircraft, 9)], ids=str
)
def test_types_and_defaults_are_those_of_the_condition_and_the_airframe(block, count):
    meant, found = {**CONDITION, **AIRFRAME}, declared(block)
    common = meant.keys() & found.keys()
    assert len(common) == count
    for name in common:
        if block is JSBSimFDM and name in ("speed", "altitude", "gamma"):
            assert found[name][0] == meant[name][0], name
        else:
            assert found[name] == meant[name], name


def test_defaults_of_the_drop_in_are_those_of_the_wrapper():
    wrapper = inspect.signature(JSBSimWrapper).parameters
    ours = inspect.signature(JSBSimFDM).parameters
    assert [*ours][: len(OF_THE_WRAPPER)] == OF_THE_WRAPPER
    for name in OF_THE_WRAPPER:
        assert ours[name].default == wrapper[name].default, name


def test_further_ports_are_among_the_labels_of_the_block():
    plane = Aircraft("c172p", input_properties=["gear", "flaps"], output_properties=["h_agl"])
    assert [*plane.input_port_labels] == [*Aircraft.input_port_labels, "gear", "flaps"]
    assert [*plane.inputs._mapping.values()] == list(range(9))
    assert [*plane.output_port_labels] == [*Aircraft.output_port_labels, "h_agl"]
    assert plane.output_port_labels == plane.outputs._mapping
    assert JSBSimFDM(output_properties=["position/h-sl-ft"]).output_port_labels == {
        "position/h-sl-ft": 0
    }
