"""Airspeed conversions against a table, JSBSim, printed answers and the normal shock relations."""

import csv
import math
from itertools import permutations
from pathlib import Path

import numpy as np
import pathsim_flight
import pytest
from plain_jsbsim import open_fdm

import pathsim_jsbsim_blocks
from pathsim_jsbsim_blocks import FlightError, ParameterError
from pathsim_jsbsim_blocks.air import airspeed
from pathsim_jsbsim_blocks.air.airspeed import (
    cas_to_mach,
    cas_to_tas,
    crossover_altitude,
    dynamic_pressure,
    impact_pressure,
    mach_to_cas,
)
from pathsim_jsbsim_blocks.air.atmosphere import A0, Air, isa

pytestmark = pytest.mark.matrix

KNOT = 1852 / 3600
FOOT = 0.3048
PSF = 47.88025898  # Pa

SPEEDS = {"cas": "CAS", "eas": "EAS", "tas": "TAS", "mach": "Mach"}
CONVERSIONS = list(permutations(SPEEDS, 2))
FROM_PATHSIM_FLIGHT = ["CAStoMach", "CAStoTAS", "TAStoCAS", "CAStoEAS", "EAStoTAS", "MachtoCAS"]

with (Path(__file__).parents[1] / "data" / "airspeed_reference.csv").open() as _file:
    TABLE = np.array([[float(x) for x in row] for row in list(csv.reader(_file))[1:]]).T
HEIGHT, DEVIATION = TABLE[:2]
SPEED = dict(zip(("mach", "cas", "tas", "eas"), TABLE[2:6], strict=True))
IMPACT_PRESSURE = TABLE[6]
TABLE_RTOL = 1e-11  # twelve digits are printed: up to 8e-12 where two of them meet


def convert(source, target):
    return getattr(airspeed, f"{source}_to_{target}")


def block_class(source, target):
    return getattr(pathsim_jsbsim_blocks, f"{SPEEDS[source]}to{SPEEDS[target]}")


def run_block(block, *inputs):
    for i, value in enumerate(inputs):
        block.inputs[i] = value
    block.update(0.0)
    return block.outputs[0]


# the reference table


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
def test_table_from_arrays(source, target):
    out = convert(source, target)(SPEED[source], isa(HEIGHT, DEVIATION))
    np.testing.assert_allclose(out, SPEED[target], rtol=TABLE_RTOL)


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
def test_table_from_the_blocks(source, target):
    block = block_class(source, target)(out_of_range="error")
    has_deviation = "tas" in (source, target)
    assert block.input_port_labels == (
        {source: 0, "altitude": 1, "temp_deviation": 2}
        if has_deviation
        else {source: 0, "altitude": 1}
    )
    assert block.output_port_labels == {target: 0}
    out = [
        run_block(block, speed, h, *([dt] if has_deviation else []))
        for speed, h, dt in zip(SPEED[source], HEIGHT, DEVIATION, strict=True)
    ]
    np.testing.assert_allclose(out, SPEED[target], rtol=TABLE_RTOL)


def test_table_impact_pressure():
    air = isa(HEIGHT, DEVIATION)
    np.testing.assert_allclose(
        impact_pressure(SPEED["mach"], air), IMPACT_PRESSURE, rtol=TABLE_RTOL
    )
    one = impact_pressure(float(SPEED["mach"][0]), isa(float(HEIGHT[0])))
    assert one == pytest.approx(IMPACT_PRESSURE[0], rel=TABLE_RTOL)


# inverses


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
def test_round_trips(source, target):
    near_sonic = 1 + np.array([-1e-6, -1e-12, -1e-15, 0.0, 1e-15, 1e-12, 1e-6])
    machs = np.concatenate([np.geomspace(1e-6, 30.0, 301), near_sonic])
    for height in (-5000.0, 0.0, 11_000.0, 35_000.0, 80_000.0):
        air = isa(height, -10.0)
        speeds = machs if source == "mach" else convert("mach", source)(machs, air)
        back = convert(target, source)(convert(source, target)(speeds, air), air)
        np.testing.assert_allclose(back, speeds, rtol=4e-15)
        back = [
            convert(target, source)(convert(source, target)(v, air), air)
            for v in speeds[::10].tolist()
        ]
        np.testing.assert_allclose(back, speeds[::10], rtol=4e-15)


# printed answers


@pytest.mark.parametrize(
    ("kcas", "feet", "mach", "ktas"),
    [
        (250, 10_000, 0.452236, 288.682),
        (370, 25_000, 0.869514, 523.468),
        (300, 35_000, 0.872536, 503.080),
    ],
)
def test_printed_answers(kcas, feet, mach, ktas):
    # printed for geometric altitude with the gas constant of 1976: 4e-6
    air = isa(feet * FOOT)
    assert cas_to_mach(kcas * KNOT, air) == pytest.approx(mach, rel=4e-6)
    assert cas_to_tas(kcas * KNOT, air) / KNOT == pytest.approx(ktas, rel=4e-6)


# physics, written another way


@pytest.mark.parametrize("mach", [1.001, 1.3, 2.0, 5.0, 30.0])
def test_supersonic_impact_pressure_is_behind_a_normal_shock(mach):
    # NACA Report 1135, equations 93 and 96, then isentropic to rest behind the shock
    pressure_rise = (7 * mach**2 - 1) / 6
    behind = (mach**2 + 5) / (7 * mach**2 - 1)  # Mach number squared
    total = pressure_rise * (1 + 0.2 * behind) ** 3.5
    assert impact_pressure(mach, Air(1000.0, 220.0)) == pytest.approx(
        1000.0 * (total - 1), rel=1e-13
    )


def test_dynamic_pressure_is_half_rho_v_squared():
    air = isa(7000.0, 12.0)
    tas = convert("mach", "tas")(1.4, air)
    assert dynamic_pressure(1.4, air) == pytest.approx(air.density * tas**2 / 2, rel=1e-14)
    # low speed: qc = q (1 + M^2/4 + ...), which is 1e-12 / 4 off at Mach 1e-6
    assert impact_pressure(1e-6, air) == pytest.approx(dynamic_pressure(1e-6, air), rel=3e-13)


@pytest.mark.parametrize(("kcas", "mach"), [(250, 0.7), (300, 0.78), (280, 0.6)])
def test_crossover_altitude_is_that_of_bada(kcas, mach):
    # Eurocontrol BADA user manual, transition altitude: the ISA's troposphere, geopotential
    delta = ((1 + 0.2 * (kcas * KNOT / A0) ** 2) ** 3.5 - 1) / ((1 + 0.2 * mach**2) ** 3.5 - 1)
    expected = 1000 / 6.5 * 288.15 * (1 - delta ** (0.0065 * 287.05287 / 9.80665))
    assert crossover_altitude(kcas * KNOT, mach, "geopotential") == pytest.approx(
        expected, abs=1e-6
    )


def test_at_the_crossover_altitude_cas_and_mach_are_one_speed():
    cas, mach = np.array([100.0, 150.0, 500.0]), np.array([0.9, 0.4, 2.5])
    air = isa(crossover_altitude(cas, mach))
    np.testing.assert_allclose(cas_to_mach(cas, air), mach, rtol=1e-13)


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
def test_sign_is_kept_and_zero_is_exact(source, target):
    air = isa(12_000.0)
    f = convert(source, target)
    speeds = np.array([0.3, 1.7]) if source == "mach" else np.array([90.0, 700.0])
    np.testing.assert_array_equal(f(-speeds, air), -f(speeds, air))
    assert f(-speeds[1].item(), air) == -f(speeds[1].item(), air) < 0
    assert f(0.0, air) == 0.0
    assert f(np.zeros(2), air).tolist() == [0.0, 0.0]
    assert run_block(block_class(source, target)(), -speeds[0], 12_000.0) == -f(speeds[0], air)


def test_shapes_broadcast():
    air = isa(np.linspace(0.0, 20_000.0, 4))
    speeds = np.array([[50.0], [150.0], [400.0]])
    for source, target in CONVERSIONS:
        scale = 100.0 if source == "mach" else 1.0
        assert convert(source, target)(speeds / scale, air).shape == (3, 4)
    np.testing.assert_allclose(
        cas_to_mach(speeds, air)[2, 3], cas_to_mach(400.0, isa(20_000.0)), rtol=1e-14
    )
    assert cas_to_mach(150.0, air).shape == (4,)
    assert cas_to_mach([100, 200], isa(5000.0)).shape == (2,)
    assert type(cas_to_mach(np.float64(150.0), isa(5000))) is float


# JSBSim as another converter


@pytest.mark.parametrize("delta_t", [0.0, 30.0])
@pytest.mark.parametrize(
    ("aircraft", "machs"),
    [("global5000", np.linspace(0.1, 0.9, 10)), ("f16", np.linspace(0.2, 2.0, 10))],
)
def test_jsbsim_agrees(aircraft, machs, delta_t):
    fdm = open_fdm(aircraft, 1 / 120)
    for feet in (0.0, 10_000.0, 25_000.0, 40_000.0, 55_000.0):
        for mach in machs.tolist():
            fdm["atmosphere/delta-T"] = delta_t  # Rankine; JSBSim recomputes the pressure
            fdm["ic/h-sl-ft"] = feet
            fdm["ic/mach"] = mach
            fdm.run_ic()
            there = {
                "cas": fdm["velocities/vc-kts"] * KNOT,
                "tas": fdm["velocities/vt-fps"] * FOOT,
                "eas": fdm["velocities/ve-kts"] * KNOT,
                "mach": fdm["velocities/mach"],
            }
            air = (
                Air(fdm["atmosphere/P-psf"] * PSF, fdm["atmosphere/T-R"] / 1.8)
                if delta_t
                else isa(fdm["position/h-sl-ft"] * FOOT)
            )
            # JSBSim's p0 differs by 5.4e-6, its speed of sound by 1.4e-6
            for source, target in CONVERSIONS:
                assert convert(source, target)(there[source], air) == pytest.approx(
                    there[target], rel=1e-5
                )
            assert dynamic_pressure(there["mach"], air) == pytest.approx(
                fdm["aero/qbar-psf"] * PSF, rel=1e-5
            )


# bad input


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda: cas_to_tas(120.0, 5000.0), "air"),  # an altitude
        (lambda: cas_to_mach([1.0, 2.0, 3.0], isa([0.0, 1.0])), "cas, pressure, temperature"),
        (lambda: crossover_altitude([100.0, 110.0, 120.0], [0.7, 0.8]), "cas, mach"),
        (lambda: crossover_altitude(0.0, 0.7), "cas"),
        (lambda: crossover_altitude(120.0, -0.7), "mach"),
        (lambda: crossover_altitude(math.nan, 0.7), "cas"),
        (lambda: crossover_altitude(120.0, "0.7"), "mach"),
    ],
)
def test_bad_input_is_refused_by_name(call, parameter):
    with pytest.raises(ParameterError) as error:
        call()
    assert error.value.parameter == parameter


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
@pytest.mark.parametrize("bad", [math.nan, math.inf, "250", None, True, [1.0, math.nan], 1j])
def test_bad_speeds_are_refused(source, target, bad):
    with pytest.raises(ParameterError) as caught:
        convert(source, target)(bad, isa(0.0))
    assert caught.value.parameter == source


# the blocks


@pytest.mark.parametrize(("source", "target"), CONVERSIONS)
def test_blocks_stop_at_bad_inputs(source, target):
    with pytest.raises(FlightError) as caught:
        run_block(block_class(source, target)(), math.nan, 0.0)
    assert (caught.value.name, caught.value.time) == (source, 0.0)
    with pytest.raises(FlightError) as error:
        run_block(block_class(source, target)(), 1.0, math.nan)
    assert error.value.name == "altitude"
    with pytest.raises(FlightError) as error:
        run_block(block_class(source, target)(out_of_range="error"), 1.0, 1e5)
    assert error.value.name == "altitude"
    with pytest.raises(ParameterError) as error:
        block_class(source, target)(altitude_kind="pressure")
    assert (error.value.parameter, error.value.value) == ("altitude_kind", "pressure")


def test_a_block_takes_geopotential_altitude():
    block = block_class("cas", "mach")(altitude_kind="geopotential")
    air = isa(11_000.0, altitude_kind="geopotential")
    assert run_block(block, 120.0, 11_000.0) == cas_to_mach(120.0, air)


@pytest.mark.parametrize("name", FROM_PATHSIM_FLIGHT)
def test_stands_in_for_pathsim_flight(name):
    ours, theirs = getattr(pathsim_jsbsim_blocks, name)(), getattr(pathsim_flight, name)()
    assert isinstance(ours, type(theirs))
    assert theirs.input_port_labels.items() <= ours.input_port_labels.items()
    assert theirs.output_port_labels == ours.output_port_labels
    for altitude in (0, 1000, 5000, 10_000, 20_000):
        for mach in (0.15, 0.3, 0.45):  # the CAS of 0.45 at sea level is Mach 1.6 at 20 km
            speed = mach if name.startswith("Mach") else mach * A0
            assert ours._eval(speed, altitude) == pytest.approx(
                theirs._eval(speed, altitude), rel=2e-6
            )


# its MachtoCAS takes the subsonic formula at Mach 1.2
@pytest.mark.parametrize(
    ("altitude", "there", "right"), [(5000, 318.6, 316.98), (10000, 234.2, 232.90)]
)
def test_flight_exceptions_supersonic_mach_to_cas(altitude, there, right):
    # the right values stand as comments beside its own: 317.0 and 232.9
    assert pathsim_flight.MachtoCAS()._eval(1.2, altitude) == pytest.approx(there, abs=0.05)
    # without a deviation
    found = pathsim_jsbsim_blocks.MachtoCAS()._eval(1.2, altitude)
    assert found == mach_to_cas(1.2, isa(altitude)) == pytest.approx(right, abs=5e-3)


def test_subclass_of_a_block_has_any_name():
    class Indicator(pathsim_jsbsim_blocks.CAStoTAS):
        """My own."""

    block = Indicator(out_of_range="clamp")
    assert Indicator.__doc__ == "My own."
    assert [*block.input_port_labels] == ["cas", "altitude", "temp_deviation"]
    block.inputs[0], block.inputs[1] = 100.0, 3000.0
    block.update(0.0)
    assert block.outputs[0] == cas_to_tas(100.0, isa(3000.0))
