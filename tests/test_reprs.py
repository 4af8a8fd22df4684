"""What blocks say of themselves."""

import pytest

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, PitchHold, UnitConversion


def test_a_block_names_what_differs_from_its_defaults():
    assert repr(DoubletSource(0.2, width=2.0)) == "DoubletSource(amplitude=0.2, width=2.0)"
    assert repr(UnitConversion()) == "UnitConversion()"
    assert repr(PitchHold("737")) == "PitchHold(gains='737')"


def test_an_aircraft_names_its_model_and_condition():
    assert repr(Aircraft("c172p", 5000, 90)) == "Aircraft('c172p', 5000 ft, 90 KCAS)"
    fast = Aircraft("737", 30000, mach=0.7, gear=0)
    assert repr(fast) == "Aircraft('737', 30000 ft, Mach 0.7)"
    ground = JSBSimFDM(aircraft_model="c172p", trim_altitude=0, trim_mode="ground")
    assert repr(ground) == "JSBSimFDM('c172p', on the ground at 0 ft)"


def test_a_notebook_shows_a_trim_as_the_table_that_print_shows():
    formatters = pytest.importorskip("IPython.core.formatters")
    trim = Aircraft("c172p", 5000, 90).trim
    shown = formatters.PlainTextFormatter()(trim)
    assert shown == str(trim)
    assert any(line.split()[::2] == ["speed", "KCAS"] for line in shown.splitlines())


def test_outputs_print_as_a_line_for_each_port():
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
