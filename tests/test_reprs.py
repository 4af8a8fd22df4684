"""What blocks say of themselves."""

from types import SimpleNamespace

import pytest

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, PitchHold


def test_an_aircraft_names_its_model_and_condition():
    assert repr(Aircraft("c172p", 5000, 90)) == "Aircraft('c172p', 5000 ft, 90 KCAS)"
    fast = Aircraft("737", 30000, mach=0.7, gear=0)
    assert repr(fast) == "Aircraft('737', 30000 ft, Mach 0.7)"
    ground = JSBSimFDM(aircraft_model="c172p", trim_altitude=0, trim_mode="ground")
    assert repr(ground) == "JSBSimFDM('c172p', on the ground at 0 ft)"


def test_a_notebook_shows_a_trim_as_the_table_that_print_shows():
    trim, shown = Aircraft("c172p", 5000, 90).trim, []
    trim._repr_pretty_(SimpleNamespace(text=shown.append), False)  # as IPython does
    assert shown == [str(trim)]
    assert any(line.split()[::2] == ["speed", "KCAS"] for line in str(trim).splitlines())


def test_ports_print_as_a_line_for_each_and_are_written_by_name():
    plane = Aircraft("c172p", 5000, 90, output_properties=["position/h-agl-ft"])
    lines = [line.split() for line in str(plane.outputs).splitlines()]
    assert [name for name, _ in lines] == [*Aircraft.output_port_labels, "position/h-agl-ft"]
    for name, value in lines:
        assert float(value) == pytest.approx(plane.outputs[name], rel=1e-7), name
    # a port without a name, and a value that six decimals would not show
    kick = DoubletSource()
    kick.outputs[1] = -3.7e-7
    assert [line.split() for line in str(kick.outputs).splitlines()] == [
        ["out", "0"],
        ["1", "-3.7e-07"],
    ]
    hold = PitchHold()
    # looking at an input connects nothing
    assert hold.inputs["q"] == 0.0
    assert not hold.inputs.wired
    hold.inputs["theta_ref"] = 2.5
    assert dict(line.split() for line in str(hold.inputs).splitlines())["theta_ref"] == "2.5"


def test_ports_are_completed_in_ipython():
    plane, hold = Aircraft(output_properties=["h_agl"]), PitchHold()
    for ports, names in (
        (plane, {"h_agl", "elevator"}),
        (plane.outputs, {"h_agl"}),
        (hold.inputs, {"elev_sat"}),
    ):
        assert names <= {*ports._ipython_key_completions_()}
