"""Parameters and ports of the aircraft blocks: those of the wrapper, and further ones."""

import inspect

from pathsim_flight import JSBSimWrapper

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM

OF_THE_WRAPPER = [*inspect.signature(JSBSimWrapper).parameters]


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
