"""The standard atmosphere against tables, other programs and its own differential equation."""

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from fluids.atmosphere import ATMOSPHERE_1976

from pathsim_jsbsim_blocks import ISAtmosphere, ParameterError
from pathsim_jsbsim_blocks.air.atmosphere import (
    ALTITUDE_KINDS,
    EARTH_RADIUS,
    LIMITS,
    Air,
    density_altitude,
    geometric_altitude,
    geopotential_altitude,
    isa,
    pressure_altitude,
)

QUANTITIES = ("pressure", "density", "temperature", "speed_of_sound", "viscosity")

with (Path(__file__).parents[1] / "data" / "isa_reference.csv").open() as _file:
    TABLE = np.array([[float(x) for x in row] for row in list(csv.reader(_file))[1:]]).T
HEIGHT, GEOPOTENTIAL, DEVIATION = TABLE[:3]
COLUMNS = ("temperature", "pressure", "density", "speed_of_sound", "viscosity")
EXPECTED = dict(zip(COLUMNS, TABLE[3:], strict=True))
TABLE_RTOL = 1e-11  # twelve digits are printed: up to 5e-12 of the value is rounding


def relative_difference(a, b):
    return np.max(np.abs(np.asarray(a) / np.asarray(b) - 1))


# the reference table


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("altitude_kind", ALTITUDE_KINDS)
def test_table_from_arrays(quantity, altitude_kind):
    altitude = HEIGHT if altitude_kind == "geometric" else GEOPOTENTIAL
    air = isa(altitude, DEVIATION, altitude_kind)
    # the geopotential altitudes are printed to 12 digits too: 5e-8 m of 80 km, 1e-11 in pressure
    rtol = TABLE_RTOL if altitude_kind == "geometric" else 2 * TABLE_RTOL
    np.testing.assert_allclose(getattr(air, quantity), EXPECTED[quantity], rtol=rtol)


@pytest.mark.parametrize("altitude_kind", ALTITUDE_KINDS)
def test_table_from_the_block(altitude_kind):
    block = ISAtmosphere(altitude_kind=altitude_kind, out_of_range="error")
    rtol = TABLE_RTOL if altitude_kind == "geometric" else 2 * TABLE_RTOL
    for i, altitude in enumerate(HEIGHT if altitude_kind == "geometric" else GEOPOTENTIAL):
        # as geopotential altitude the table's lowest rows are 3e-9 m below -5000 m geometric
        block.inputs[0] = max(altitude, LIMITS[altitude_kind][0])
        block.inputs[1] = DEVIATION[i]
        block.update(0.0)
        np.testing.assert_allclose(
            block.outputs.to_array(), [EXPECTED[q][i] for q in QUANTITIES], rtol=rtol
        )


def test_table_geopotential_altitude():
    np.testing.assert_allclose(geopotential_altitude(HEIGHT), GEOPOTENTIAL, rtol=TABLE_RTOL)
    np.testing.assert_allclose(geometric_altitude(GEOPOTENTIAL), HEIGHT, rtol=TABLE_RTOL)


# other sources


@pytest.mark.parametrize(
    ("geopotential", "temperature", "pressure"),
    [
        # ICAO Doc 7488/3, table D; its pressures are chained with six digits: 2e-6 off at 32 km
        (-5000.0, 320.65, 1.77687e5),
        (0.0, 288.15, 1.01325e5),
        (11000.0, 216.65, 2.26320e4),
        (20000.0, 216.65, 5.47487e3),
        (32000.0, 228.65, 8.68014e2),
        (47000.0, 270.65, 1.10906e2),
        (51000.0, 270.65, 6.69384e1),
        (71000.0, 214.65, 3.95639),
        (80000.0, 196.65, 8.86272e-1),
    ],
)
def test_printed_layer_bases(geopotential, temperature, pressure):
    air = isa(geopotential, altitude_kind="geopotential")
    assert air.temperature == pytest.approx(temperature, abs=1e-9)
    assert air.pressure == pytest.approx(pressure, rel=3e-6)


@pytest.mark.parametrize("deviation", [0.0, -20.0, 15.0])
def test_fluids_agrees(deviation):
    heights = np.linspace(-600.0, 80000.0, 97)  # fluids goes down to -610 m
    other = [ATMOSPHERE_1976(h, deviation) for h in heights.tolist()]
    air = isa(heights, deviation)
    # the US Standard Atmosphere 1976 has R = 287.05307: 8e-6 in pressure at 80 km
    for quantity, name, rtol in [
        ("pressure", "P", 1e-5),
        ("density", "rho", 1e-5),
        ("temperature", "T", 1e-14),
        ("speed_of_sound", "v_sonic", 1e-6),
        ("viscosity", "mu", 1e-14),
    ]:
        assert relative_difference(getattr(air, quantity), [getattr(x, name) for x in other]) < rtol


# shapes


def test_numbers_and_arrays_of_any_shape_keep_it():
    heights = np.linspace(0.0, 20000.0, 6).reshape(2, 3)
    assert isa(heights).density.shape == (2, 3)
    assert isa(heights.T[:, :1], [0.0, 5.0]).density.shape == (3, 2)
    assert isa(5000.0, np.array([0.0, 5.0])).density.shape == (2,)
    np.testing.assert_array_equal(isa(np.asfortranarray(heights)).pressure, isa(heights).pressure)
    np.testing.assert_array_equal(isa([0, 5000]).pressure, [isa(0).pressure, isa(5000).pressure])
    assert isa([]).density.shape == (0,)
    many = np.linspace(0.0, 80000.0, 40_001)  # several of the pieces it works in
    np.testing.assert_array_equal(isa(many).pressure[::100], isa(many[::100]).pressure)
    for number in (5000, np.float64(5000.0), np.int32(5000), np.array(5000.0)):
        assert isa(number) == isa(5000.0)
        assert type(isa(number).density) is float


# altitudes in the air


@pytest.mark.parametrize("altitude_kind", ALTITUDE_KINDS)
def test_pressure_and_density_altitude_are_inverse(altitude_kind):
    altitudes = np.linspace(-8000.0, 120_000.0, 1301)
    air = isa(altitudes, altitude_kind=altitude_kind)
    # 1e-9 m: p's last digit is worth up to 1e-12 m times the altitude's scale of some km
    for inverse, values in ((pressure_altitude, air.pressure), (density_altitude, air.density)):
        np.testing.assert_allclose(inverse(values, altitude_kind), altitudes, rtol=0, atol=1e-9)
        one = inverse(float(values[500]), altitude_kind)
        assert type(one) is float
        assert one == pytest.approx(altitudes[500], abs=1e-9)


# beyond the standard


def test_extrapolation_goes_on_smoothly():
    heights = np.linspace(-20_000.0, 1_000_000.0, 5001)
    air = isa(heights)
    assert np.all(np.diff(air.pressure) < 0)
    assert np.all(air.pressure > 0)
    assert np.all(air.temperature > 180.0)
    # US Standard Atmosphere 1976: the layer of -2 K/km ends at 84.852 km with 186.946 K, 0.3734 Pa
    top = isa(84_852.0, altitude_kind="geopotential")
    assert top.temperature == pytest.approx(186.946, abs=1e-9)
    assert top.pressure == pytest.approx(0.37338, rel=2e-5)


# bad input to the functions


def test_air_may_be_as_cold_as_any_above_0_K():
    assert isa(0.0, 0.5 - 288.15).temperature == pytest.approx(0.5)
    assert isa([0.0, 0.0], 0.5 - 288.15).temperature == pytest.approx([0.5, 0.5])
    for deviation in (-288.15, -288.65):
        for altitude in (0.0, [0.0, 0.0]):
            with pytest.raises(ParameterError) as error:
                isa(altitude, deviation)
            assert error.value.parameter == "temp_deviation"


BELOW = [-EARTH_RADIUS, -7e6, [0.0, -7e6]]  # the centre of the Earth
NO_NUMBERS = [math.nan, [0.0, math.nan], math.inf, "5000", None, True, [[1.0], [1.0, 2.0]], [1j]]
NOT_POSITIVE = [0.0, -1.0, math.nan, "1e5", [1e5, 0.0]]


@pytest.mark.parametrize(
    ("function", "bad", "parameter"),
    [
        (isa, [*NO_NUMBERS, *BELOW], "altitude"),
        (geopotential_altitude, [*NO_NUMBERS, *BELOW], "altitude"),
        (geometric_altitude, [7e6], "altitude"),
        (lambda bad: isa(0.0, bad), [*NO_NUMBERS, -300.0, [0.0, -300.0]], "temp_deviation"),
        (lambda bad: isa([0.0, 1.0], bad), [*NO_NUMBERS, -300.0], "temp_deviation"),
        (lambda bad: isa([0.0, 1.0, 2.0], bad), [[0.0, 1.0]], "altitude, temp_deviation"),
        (lambda bad: isa(0.0, altitude_kind=bad), ["geopotental", None], "altitude_kind"),
        (lambda bad: pressure_altitude(1e5, bad), ["pressure"], "altitude_kind"),
        (pressure_altitude, NOT_POSITIVE, "pressure"),
        (density_altitude, NOT_POSITIVE, "density"),
        (lambda bad: Air(bad, 288.15), NOT_POSITIVE, "pressure"),
        (lambda bad: Air(101325.0, bad), NOT_POSITIVE, "temperature"),
        (lambda bad: Air([1e5, 9e4, 8e4], bad), [[280.0, 270.0]], "pressure, temperature"),
        (lambda bad: ISAtmosphere(altitude_kind=bad), ["geometrical"], "altitude_kind"),
        (lambda bad: ISAtmosphere(out_of_range=bad), ["clip"], "out_of_range"),
    ],
)
def test_bad_input_is_refused_by_name(function, bad, parameter):
    for value in bad:
        with pytest.raises(ParameterError) as error:
            function(value)
        assert error.value.parameter == parameter, value
