"""Labels of signals."""

import pytest

from pathsim_jsbsim_blocks._core.scopes import name_and_unit


@pytest.mark.parametrize(
    ("label", "name", "unit"),
    [
        ("pitch angle [deg]", "pitch angle", "deg"),
        (" speed[ft/s] ", " speed", "ft/s"),
        ("tank [1] [lb]", "tank [1]", "lb"),
        ("Mach number", "Mach number", ""),
        ("[kt] of speed", "[kt] of speed", ""),
    ],
)
def test_a_label_ends_with_its_unit_in_brackets(label, name, unit):
    assert name_and_unit(label) == (name, unit)
