"""The block of the standard atmosphere: ends of its range, bad input, pathsim-flight's block."""

import contextlib
import math
import warnings

import numpy as np
import pathsim_flight
import pytest

from pathsim_jsbsim_blocks import FlightError, ISAtmosphere
from pathsim_jsbsim_blocks.air.atmosphere import EARTH_RADIUS, G0, LIMITS, isa


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
    block.linearize(0.0)
    linear = set_inputs(block, 5100.0, 10.0)
    assert linear[0] == pytest.approx(pressure + 100.0 * d[0, 0], rel=1e-9)


def test_stands_in_for_pathsim_flight():
    ours, theirs = ISAtmosphere(), pathsim_flight.ISAtmosphere()
    assert isinstance(ours, pathsim_flight.ISAtmosphere)
    assert ours.input_port_labels == theirs.input_port_labels
    assert theirs.output_port_labels.items() <= ours.output_port_labels.items()
    # its base pressures have five digits, 110.91 Pa at 47 km
    for height in (0, 5000, 15_000, 25_000, 35_000, 49_000, 65_000, 75_000):
        assert ours._eval(height) == pytest.approx(theirs._eval(height), rel=4e-5)
    assert ours.StdSL_pressure == theirs.StdSL_pressure
    assert ours.StdSL_speed_of_sound == pytest.approx(theirs.StdSL_speed_of_sound, rel=2e-7)
    for band, other in zip(ours.atmosphere_bands, theirs.atmosphere_bands, strict=True):
        assert (band.start_alt, band.lapse_rate) == (other.start_alt, other.lapse_rate)
        assert band.base_pressure == pytest.approx(other.base_pressure, rel=4e-5)
        assert ours.get_atmosphere_band(other.start_alt + 1.0) == band


@pytest.mark.parametrize("height", [-100, 90_000])
def test_unlike_pathsim_flights_it_extrapolates(height):
    with pytest.warns(RuntimeWarning) if height > 0 else contextlib.nullcontext():
        assert ISAtmosphere()._eval(height)[0] == isa(height).pressure
    with pytest.raises(IndexError):
        pathsim_flight.ISAtmosphere()._eval(height)
