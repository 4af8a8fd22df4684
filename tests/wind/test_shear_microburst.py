"""Wind shear and microburst: profiles, conservation of mass, positions on the ellipsoid."""

import math

import numpy as np
import pymap3d
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source
from scipy.optimize import minimize_scalar

from pathsim_jsbsim_blocks import Microburst, ParameterError, WindShear
from pathsim_jsbsim_blocks.wind import logarithmic_profile, oseguera_bowles


def test_the_profile_is_that_of_the_specification():
    # MIL-F-8785C, category C: ln(h / 0.15) / ln(20 / 0.15); others: 2 ft
    assert logarithmic_profile(20.0, 30.0) == pytest.approx(30.0, rel=1e-15)
    assert logarithmic_profile(200.0, 30.0) == pytest.approx(30.0 * 7.195437 / 4.892852, rel=1e-6)
    assert logarithmic_profile(200.0, 30.0, 2.0) == pytest.approx(60.0, rel=1e-15)
    heights = np.array([-10.0, 0.0, 0.15, 1000.0, 1e6])
    assert logarithmic_profile(heights, 15.0) == pytest.approx(
        [0.0, 0.0, 0.0, *[15.0 * 8.804875 / 4.892852] * 2], rel=1e-6
    )
    assert isinstance(logarithmic_profile(50.0), float)


def test_wind_shear_blows_from_its_direction():
    height, scope = Source(lambda t: 1000.0 + 20.0 * t), Scope()
    shear = WindShear(direction=270.0, terrain=1000.0)
    wires = [Connection(height, shear), Connection(shear["north", "east"], scope[:2])]
    sim = Simulation([height, shear, scope], wires, dt=0.5, log=False)
    sim.run(10.0)
    time, (north, east) = scope.read()
    assert abs(north).max() < 1e-12
    assert east == pytest.approx(1.687810 * logarithmic_profile(20.0 * time), rel=1e-6)


def flow(r, z):
    """Outflow and upward velocity at a radius and a height."""
    north, _, down = oseguera_bowles(r, 0.0, z, radius=2500.0, outflow=50.0, height=200.0)
    return float(north), -float(down)


def test_the_strongest_outflow_is_where_and_what_was_asked_for():
    best = minimize_scalar(lambda r: -flow(r, 200.0)[0], bounds=(100.0, 9000.0), method="bounded")
    assert -best.fun == pytest.approx(50.0, rel=1e-6)
    assert best.x == pytest.approx(1.1209 * 2500.0, rel=1e-3)
    # the paper's rounded 0.22 and 2.75 put the strongest outflow at 0.998 of the height given
    highest = minimize_scalar(lambda z: -flow(best.x, z)[0], bounds=(1.0, 2000.0), method="bounded")
    assert highest.x == pytest.approx(200.0, rel=3e-3)
    assert -highest.fun == pytest.approx(50.0, rel=1e-4)


@pytest.mark.parametrize("r", [10.0, 1000.0, 2500.0, 6000.0])
@pytest.mark.parametrize("z", [5.0, 100.0, 900.0])
def test_the_flow_keeps_its_mass(r, z):
    d = 0.1
    outward = ((r + d) * flow(r + d, z)[0] - (r - d) * flow(r - d, z)[0]) / (2 * d * r)
    upward = (flow(r, z + d)[1] - flow(r, z - d)[1]) / (2 * d)
    assert outward + upward == pytest.approx(0.0, abs=1e-7)
    assert flow(r, z)[1] < 0.0


def test_the_centre_and_the_ground_are_regular():
    assert oseguera_bowles(0.0, 0.0, 100.0)[:2] == (0.0, 0.0)
    assert oseguera_bowles(500.0, 500.0, 0.0) == (0.0, 0.0, 0.0)
    assert oseguera_bowles(500.0, 500.0, -1.0) == (0.0, 0.0, 0.0)
    north, east, down = oseguera_bowles(np.array([1e-200, 1e5]), 0.0, 100.0)
    assert north[0] == pytest.approx(0.0, abs=1e-12)
    assert east == pytest.approx([0.0, 0.0])
    assert down[0] > down[1] >= 0.0


def test_the_flow_is_the_same_on_all_sides():
    for psi in np.radians([30.0, 135.0, 250.0]):
        north, east, down = oseguera_bowles(2000 * math.cos(psi), 2000 * math.sin(psi), 80.0)
        u, _, w = oseguera_bowles(2000.0, 0.0, 80.0)
        assert (north, east, down) == pytest.approx((u * math.cos(psi), u * math.sin(psi), w))


@pytest.mark.parametrize(("lat0", "lon0"), [(51.5, 179.99), (-33.9, -71.0), (80.0, 10.0)])
def test_a_place_on_the_ellipsoid(lat0, lon0):
    # pymap3d's WGS84, in m; 2 nmi away
    e, n = 3000.0, -2000.0
    lat, lon, _ = pymap3d.enu2geodetic(e, n, 0.0, lat0, lon0, 0.0)
    burst = Microburst(lat0=lat0, lon0=lon0, terrain=500.0)
    for i, value in enumerate((float(lat), float(lon), 700.0)):
        burst.inputs[i] = value
    burst.update(0.0)
    expected = oseguera_bowles(n / 0.3048, e / 0.3048, 200.0)
    # ft/s; meridians converge
    assert burst.outputs.to_array() == pytest.approx(expected, abs=0.05)


@pytest.mark.parametrize(
    ("make", "parameter"),
    [
        (lambda: WindShear(wind_20ft=-1.0), "wind_20ft"),
        (lambda: WindShear(roughness=0.0), "roughness"),
        (lambda: WindShear(roughness=20.0), "roughness"),
        (lambda: WindShear(terrain="high"), "terrain"),
        (lambda: logarithmic_profile(math.inf), "h"),
        (lambda: Microburst(lat0=90.0), "lat0"),
        (lambda: Microburst(lon0=math.inf), "lon0"),
        (lambda: Microburst(radius=0.0), "radius"),
        (lambda: Microburst(outflow=-1.0), "outflow"),
        (lambda: Microburst(height=0.0), "height"),
        (lambda: Microburst(terrain=None), "terrain"),
        (lambda: oseguera_bowles(math.nan, 0.0, 0.0), "north"),
    ],
)
def test_bad_parameters_are_refused_by_name(make, parameter):
    with pytest.raises(ParameterError) as error:
        make()
    assert error.value.parameter == parameter
