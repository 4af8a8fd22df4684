"""The block of the standard atmosphere: ends of its range, bad input, pathsim-flight's tests."""

import math
import warnings

import numpy as np
import pathsim_flight
import pytest

from pathsim_jsbsim_blocks import FlightError, ISAtmosphere, ParameterError
from pathsim_jsbsim_blocks.air.atmosphere import EARTH_RADIUS, G0, LIMITS, isa

QUANTITIES = ("pressure", "density", "temperature", "speed_of_sound", "viscosity")


def set_inputs(block, *values):
    for i, value in enumerate(values):
        block.inputs[i] = value
    block.update(0.0)
    return block.outputs.to_array()


def test_extrapolating_block_warns_once_and_goes_on():
    block = ISAtmosphere()
    with pytest.warns(RuntimeWarning, match=r"-5001 m is outside .*-5000 m to 81020 m.*extrap"):
        out = set_inputs(block, -5001.0)
    assert out[0] == isa(-5001.0).pressure
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert set_inputs(block, 90_000.0)[0] == isa(90_000.0).pressure
        set_inputs(block, -1e-9)
        set_inputs(ISAtmosphere(), -4999.0)
    block.reset()
    with pytest.warns(RuntimeWarning):
        set_inputs(block, -5001.0)


def test_clamping_block_stays_at_the_ends():
    block = ISAtmosphere(out_of_range="clamp")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for altitude in (-5001.0, -EARTH_RADIUS, -1e9):
            assert set_inputs(block, altitude)[0] == isa(-5000.0).pressure
        for altitude in (81_020.0, 1e9):
            np.testing.assert_allclose(set_inputs(block, altitude)[0], 0.88627223857908, rtol=1e-11)


def test_strict_block_refuses():
    block = ISAtmosphere(out_of_range="error")
    with pytest.raises(FlightError) as caught:
        set_inputs(block, 81_021.0)
    assert (caught.value.name, caught.value.value) == ("altitude", 81_021.0)
    block.altitude_kind = "geopotential"
    with pytest.raises(FlightError) as error:
        set_inputs(block, 80_001.0)
    assert error.value.name == "altitude"
    # below the centre of the Earth nothing can be extrapolated
    with pytest.raises(FlightError) as error:
        set_inputs(ISAtmosphere(), -7e6)
    assert error.value.name == "altitude"


@pytest.mark.parametrize("kind", ["geometric", "geopotential"])
def test_the_ends_of_the_range_belong_to_it(kind):
    block = ISAtmosphere(altitude_kind=kind, out_of_range="error")
    for altitude in LIMITS[kind]:
        assert set_inputs(block, altitude)[0] == isa(altitude, altitude_kind=kind).pressure


@pytest.mark.parametrize(
    ("parameter", "bad", "right"),
    [("altitude_kind", "geometrical", "geometric"), ("out_of_range", "clip", "clamp")],
)
def test_bad_parameters_are_refused(parameter, bad, right):
    with pytest.raises(ParameterError, match=right):
        ISAtmosphere(**{parameter: bad})


@pytest.mark.parametrize("out_of_range", ["extrapolate", "clamp", "error"])
@pytest.mark.parametrize(
    ("inputs", "port"),
    [
        ((math.nan, 0.0), "altitude"),
        ((math.inf, 0.0), "altitude"),
        ((0.0, math.nan), "temp_deviation"),
        ((0.0, -300.0), "temp_deviation"),
    ],
)
def test_no_block_goes_on_with_nan(out_of_range, inputs, port):
    with pytest.raises(FlightError) as caught:
        set_inputs(ISAtmosphere(out_of_range=out_of_range), *inputs)
    assert (caught.value.name, caught.value.time) == (port, 0.0)


def test_parameters_can_be_edited_while_the_diagram_runs():
    block = ISAtmosphere()
    assert set_inputs(block, 11_000.0)[0] == isa(11_000.0).pressure
    block.altitude_kind = "geopotential"
    assert set_inputs(block, 11_000.0)[0] == isa(11_000.0, altitude_kind="geopotential").pressure
    block.out_of_range = "clamp"
    assert set_inputs(block, 1e6)[2] == 196.65


def test_linear_model_is_the_hydrostatic_equation():
    block = ISAtmosphere()
    set_inputs(block, 5000.0, 10.0)
    pressure, density, temperature, speed_of_sound, _ = block.outputs.to_array()
    _, _, _, d = block.to_statespace(0.0)
    stretch = (EARTH_RADIUS / (EARTH_RADIUS + 5000.0)) ** 2
    standard_density = density * temperature / (temperature - 10.0)
    assert d.shape == (5, 2)
    # PathSim differentiates numerically: 1e-6 of the value
    assert d[0, 0] == pytest.approx(-standard_density * G0 * stretch, rel=1e-6)
    assert d[2] == pytest.approx([-0.0065 * stretch, 1.0], rel=1e-6)
    assert d[3, 1] == pytest.approx(speed_of_sound / (2 * temperature), rel=1e-6)
    assert d[1, 1] == pytest.approx(-density / temperature, rel=1e-6)
    assert d[0, 1] == pytest.approx(0.0, abs=1e-9 * pressure)


# pathsim-flight's own tests: tests/atmosphere/test_international_standard_atmosphere.py in
# https://github.com/pathsim/pathsim-flight, rewritten. Exceptions: it expects an IndexError for
# -100 m and for 90,000 m, and a rounded StdSL_speed_of_sound of 340.294 m/s.


def test_stands_in_for_pathsim_flight():
    assert issubclass(ISAtmosphere, pathsim_flight.ISAtmosphere)
    assert ISAtmosphere.input_port_labels == pathsim_flight.ISAtmosphere.input_port_labels
    assert (
        pathsim_flight.ISAtmosphere.output_port_labels.items()
        <= ISAtmosphere.output_port_labels.items()
    )
    assert len(ISAtmosphere()._eval(1000.0)) == 4


def test_flight_sea_level_constants():
    assert ISAtmosphere().StdSL_pressure == 101325
    # exception: 340.294 there
    assert ISAtmosphere().StdSL_speed_of_sound == pytest.approx(340.293988026, abs=5e-10)


@pytest.mark.parametrize(
    ("geopotential", "temperature", "pressure"),
    [
        (0, 288.15, 101325.0),
        (11000, 216.65, 22632.0),
        (20000, 216.65, 5474.9),
        (32000, 228.65, 868.02),
        (47000, 270.65, 110.91),
        (51000, 270.65, 66.939),
        (71000, 214.65, 3.9564),
    ],
)
def test_flight_band_boundaries(geopotential, temperature, pressure):
    block = ISAtmosphere()
    out = set_inputs(block, block.geometric_altitude(geopotential), 0)
    assert out[0] == pytest.approx(pressure, abs=0.05)
    assert out[2] == pytest.approx(temperature, abs=0.05)
    band = next(band for band in block.atmosphere_bands if band.start_alt == geopotential)
    assert block.get_atmosphere_band(geopotential + 1.0) == band
    isothermal = geopotential in (11000, 47000)
    assert (band.lapse_rate == 0.0) is isothermal
    assert band.base_pressure == pytest.approx(pressure, rel=5e-5)


@pytest.mark.parametrize(("height", "there"), [(-100, "IndexError"), (90000, "IndexError")])
def test_flight_exceptions_for_altitudes(height, there):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        assert ISAtmosphere()._eval(height)[0] == isa(height).pressure
    with pytest.raises(IndexError):
        pathsim_flight.ISAtmosphere()._eval(height)


@pytest.mark.parametrize(
    ("height", "pressure", "density", "temperature", "speed_of_sound"),
    [
        (0, 101325, 1.2250, 288.15, 340.294),
        (5000, 54048, 0.7364, 255.68, 320.545),
        (15000, 12112, 0.1948, 216.65, 295.069),
        (25000, 2549.2, 0.0401, 221.55, 298.389),
        (35000, 574.59, 0.0085, 236.51, 308.299),
        (49000, 90.337, 0.0012, 270.65, 329.799),
        (65000, 10.930, 0.00016, 233.29, 306.193),
        (75000, 2.388, 0.0000399, 208.40, 289.396),
    ],
)
def test_flight_spot_altitudes(height, pressure, density, temperature, speed_of_sound):
    out = set_inputs(ISAtmosphere(), height, 0)
    assert out[0] == pytest.approx(pressure, abs=0.5)
    assert out[1] == pytest.approx(density, abs=5e-5)
    assert out[2] == pytest.approx(temperature, abs=5e-3)
    assert out[3] == pytest.approx(speed_of_sound, abs=5e-4)
