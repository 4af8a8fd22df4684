"""Conversions against printed factors, and the block in a diagram."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import ParameterError, UnitConversion
from pathsim_jsbsim_blocks._core.units import UNITS
from pathsim_jsbsim_blocks.units import conversion, convert

# NIST SP 811 (2008), appendix B.8, as printed there: seven digits, or exact
with (Path(__file__).parent / "data" / "nist_sp811.csv").open(newline="") as _file:
    PRINTED = {(x["unit"], x["in"]): float(x["factor"]) for x in csv.DictReader(_file)}
# slug times foot squared
PRINTED["slug*ft2", "kg*m2"] = 1.459390e1 * 0.3048**2


@pytest.mark.parametrize(("source", "target"), PRINTED)
def test_factors_are_those_printed(source, target):
    factor, offset = conversion(source, target)
    # half of the seventh digit
    assert factor == pytest.approx(PRINTED[source, target], rel=5e-7)
    assert offset == 0.0


@pytest.mark.parametrize(
    ("value", "unit", "kelvin"),
    [
        (0.0, "degC", 273.15),
        (32.0, "degF", 273.15),
        (212.0, "degF", 373.15),
        (518.67, "degR", 288.15),
    ],
)
def test_temperatures_have_an_offset(value, unit, kelvin):
    factor, offset = conversion(unit, "K")
    assert factor * value + offset == pytest.approx(kelvin, rel=1e-12)


def test_arrays_are_converted():
    # NIST SP 811, appendix B.9: the fixed points of water
    celsius = np.array([[0.0, 100.0], [-40.0, math.nan]])
    assert convert(celsius, "degC", "degF") == pytest.approx(
        np.array([[32.0, 212.0], [-40.0, math.nan]]), abs=1e-12, nan_ok=True
    )
    assert celsius[0, 1] == 100.0
    assert convert([10, 20], "nmi", "km").tolist() == pytest.approx([18.52, 37.04], rel=1e-15)
    assert isinstance(convert(1, "ft", "m"), float)
    assert convert(np.float64(250.0), "kt", "m/s") == pytest.approx(250 * 1852 / 3600, rel=1e-15)
    for bad in ("100", None, [1.0, "2"], 1j, True):
        with pytest.raises(ParameterError) as error:
            convert(bad, "ft", "m")
        assert error.value.parameter == "values"


def test_every_unit_is_compared():
    # prefixes of SI, and temperatures, which stand above
    others = {"km", "kN", "kW", "hPa", "K", "degC", "degF", "degR"}
    compared = others.union(*PRINTED)
    assert {unit for units in UNITS.values() for unit in units} == compared
    for unit, base, factor in (("km", "m", 1e3), ("kN", "N", 1e3), ("kW", "W", 1e3)):
        assert conversion(unit, base) == (factor, 0.0)
    assert conversion("hPa", "Pa") == (100.0, 0.0)


def test_the_block_in_a_diagram():
    source, block, scope = Source(math.sin), UnitConversion("kt", "m/s"), Scope()
    wires = [Connection(source, block["in"]), Connection(block["out"], scope)]
    sim = Simulation([source, block, scope], wires, dt=0.1, log=False)
    sim.run(1.0)
    time, [values] = scope.read()
    assert values == pytest.approx(1852 / 3600 * np.sin(time), abs=1e-15)
    block.set(source="degC", target="K")
    sim.run(0.1)
    assert scope.read()[1][0, -1] == pytest.approx(273.15 + np.sin(1.1))


@pytest.mark.parametrize(
    ("source", "target", "text"),
    [
        ("knots", "m/s", "source must be a unit"),
        ("ft", "M", "target must be a unit"),
        ("fps", "m/s", r"did you mean 'ft/s'\?$"),
        ("ft", "feet", r"did you mean 'ft'\?$"),
        ("fpm", "m/s", r"did you mean 'ft/min'\?$"),
        ("ft", "kt", "'ft' is a unit of length, 'kt' one of speed; units of length are m, km, ft"),
        (1, "m", "not 1"),
    ],
)
def test_units_that_do_not_fit_are_refused(source, target, text):
    with pytest.raises(ParameterError, match=text):
        UnitConversion(source, target)
