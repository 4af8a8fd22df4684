"""The airspeed without gusts, against flights of JSBSim through air that moves."""

import math

import numpy as np
import pytest

from pathsim_jsbsim_blocks import Aircraft
from pathsim_jsbsim_blocks.control.airspeeds import ComplementaryAirspeed

T = 1 / 60
MOTION = ("vc", "nx", "nz", "alpha", "beta", "theta", "phi", "vt")
KNOT = 1852 / 3600 / 0.3048  # ft/s


def flown(seconds, command=lambda t: [0.0] * 4, wind=lambda t: 0.0, **condition):
    """Measured airspeed, and that without gusts, kt, of a c172p that flies north at 90 KCAS."""
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0, T=T, substeps=2, **condition)
    law, ports = ComplementaryAirspeed(T), [*plane.output_port_labels]
    state, rows, y = law.START, [], plane.outputs.to_array().tolist()
    for k in range(round(seconds / T)):
        signals = [y[ports.index(name)] for name in MOTION]
        airspeed, state = law.sample(state, *signals)
        rows.append((signals[0], airspeed))
        plane.fdm["atmosphere/wind-north-fps"] = wind(k * T)
        y = plane.advance(k + 1, [*command(k * T), 0.0, 0.0, 0.0])
    return np.array(rows).T


def manoeuvre(t):
    """Nose down and up, a bank, and more throttle."""
    return [0.05 * math.sin(0.7 * t), 0.03 * math.sin(0.4 * t), 0.0, 0.2 * (t > 5.0)]


def test_in_air_that_does_not_accelerate_it_is_the_measured_airspeed():
    measured, airspeed = flown(25.0, manoeuvre)
    assert np.ptp(measured) > 8.0
    # a climb of some 20 ft/s adds 0.3 % of it
    assert np.abs(airspeed - measured).max() < 0.4


@pytest.mark.parametrize("omega", [0.3, 0.8])
def test_a_gust_is_taken_out_above_a_tenth_of_a_radian_per_second(omega):
    size, periods = 3.0, 2
    seconds = 50.0 + periods * 2.0 * math.pi / omega
    measured, airspeed = flown(seconds, wind=lambda t: size * math.sin(omega * t))
    n = round(periods * 2.0 * math.pi / omega / T)
    # the wind blows as the aircraft flies: what the high-pass lets through is added to the airspeed
    turn = np.exp(-1j * omega * T * (np.arange(len(measured) - n, len(measured)) - 1.0))
    difference = airspeed[-n:] - measured[-n:]
    found = 2j / n * ((difference - difference.mean()) @ turn)
    # 90 KCAS are 96.9 KTAS at 5000 ft (ISA)
    expected = size / KNOT * 90.0 / 96.9 * 10.0j * omega / (10.0j * omega + 1.0)
    assert found == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("missing", ["nx", "nz", "alpha", "theta", "phi", "vt"])
def test_without_a_signal_it_is_the_measured_airspeed(missing):
    level = {"nx": 0.1, "nz": 1.0, "alpha": 3.0, "beta": 0.0, "theta": 3.0, "phi": 0.1, "vt": 160.0}
    law = ComplementaryAirspeed(T)
    assert law.sample(80.0, 70.0, **level | {missing: 0.0}) == (70.0, law.START)
    measured = law.sample(80.0, 70.0, **level | {missing: 0.0}, connected=True)
    assert (measured != (70.0, law.START)) == (missing != "vt")
