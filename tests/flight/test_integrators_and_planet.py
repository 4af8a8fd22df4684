"""Integrators, planet and gravity of a flight: kept through its life, and worth what they claim."""

import numpy as np
import pytest
from plain_jsbsim import fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, trim

pytestmark = pytest.mark.matrix

# rate/rotational, rate/translational, position/rotational, position/translational
OWN, PRECISE = (1, 3, 1, 4), (4, 4, 7, 4)
PROPERTIES = [
    f"simulation/integrator/{kind}/{motion}"
    for kind in ("rate", "position")
    for motion in ("rotational", "translational")
]
OUTPUTS = ["aero/alpha-deg", "attitude/theta-deg", "position/h-sl-ft", "position/lat-geod-deg"]
# ft, ft3/s2, 1/s (NIMA TR8350.2)
A, GM, J2, OMEGA = 20925646.32546, 14.0764417572e15, 1.08262982e-3, 7.292115e-5


def doublet(hz, seconds=8):
    """Elevator commands of a doublet from 1 s to 3 s, at every step."""
    time = np.arange(seconds * hz) / hz
    return (0.1 * ((time >= 1) & (time < 2)) - 0.1 * ((time >= 2) & (time < 3)))[:, None]


def plainly_flown(hz, numbers=None):
    """The outputs of a c172p in a doublet, at 30 Hz, written without this package."""
    integrators = dict(zip(PROPERTIES, numbers or (), strict=False))
    fdm = trimmed("c172p", 5000.0, 90.0, 1 / hz, setup=integrators)
    return fly(fdm, ["fcs/elevator-cmd-norm"], doublet(hz), OUTPUTS)[:: hz // 30]


def in_a_doublet(**options):
    plane = JSBSimFDM(
        input_properties=["fcs/elevator-cmd-norm"],
        output_properties=OUTPUTS,
        aircraft_model="c172p",
        trim_airspeed=90,
        trim_altitude=5000,
        **options,
    )
    # gap 0: from one half straight into the other
    source = DoubletSource(amplitude=0.1, start=1.0, width=1.0, gap=0.0)
    return *diagram(plane, OUTPUTS, {0: source}), plane


def integrators_of(fdm):
    return tuple(fdm[name] for name in PROPERTIES)


@pytest.mark.parametrize(
    ("integrators", "numbers"),
    [
        ("default", None),
        ("precise", PRECISE),
        ({"rate_rotational": "adams-bashforth 5"}, (9, *OWN[1:])),
        (
            {
                "position_rotational": "local linearization",
                "rate_translational": "euler",
                "position_translational": "adams-bashforth 2",
            },
            (1, 1, 8, 3),
        ),
    ],
)
def test_a_flight_is_that_of_a_plain_loop(integrators, numbers):
    sim, scope, plane = in_a_doublet(integrators=integrators)
    assert integrators_of(plane.fdm) == (numbers or OWN)
    sim.run(8.0)
    _, flown = scope.read()
    assert np.array_equal(flown.T[::4], plainly_flown(120, numbers))


def test_integrators_stay_through_reset_trim_and_renewal():
    sim, scope, plane = in_a_doublet(integrators="precise")
    sim.run(2.0)
    first = scope.read()[1]
    sim.run(2.0, reset=True)
    assert np.array_equal(scope.read()[1], first)
    assert integrators_of(plane.fdm) == PRECISE

    airframe = Airframe("c172p", planet="round", gravity="point mass", integrators="precise")
    for speed in (90.0, 100.0):
        trim(airframe, TrimCondition(altitude=5000, speed=speed))
        assert integrators_of(airframe.fdm) == PRECISE
    airframe.renew()
    assert integrators_of(airframe.fdm) == PRECISE
    assert airframe.fdm["simulation/gravity-model"] == 0
    airframe.run_ic()
    assert airframe.fdm["position/radius-to-vehicle-ft"] == pytest.approx(20902254.5305)


@pytest.fixture(scope="module")
def exact():
    return plainly_flown(1920, PRECISE)


@pytest.mark.parametrize("hz", [60, 120, 480])
def test_precise_integrators_have_a_third_of_the_error(hz, exact):
    own, precise = (
        abs(plainly_flown(hz, numbers) - exact)[:, :2].max(axis=0) for numbers in (None, PRECISE)
    )
    assert np.all(precise < 0.4 * own)


def test_precise_integrators_are_stable_where_those_of_higher_order_are_not(exact):
    assert abs(plainly_flown(30, PRECISE) - exact)[:, 0].max() < 0.2
    assert not abs(plainly_flown(30, (9, 9, 7, 9)) - exact)[:, 0].max() < 10.0


def test_precise_integrators_rock_an_aircraft_on_its_wheels():
    """The documentation says so: stiff gear, which Euler's method damps. It rests at first."""
    rocking, places = {}, []
    for integrators, hz in (("default", 60), ("precise", 60), ("precise", 120), ("precise", 240)):
        plane = Aircraft("c172p", altitude=0, mode="ground", T=1 / hz, integrators=integrators)
        fdm, nz = plane.fdm, []
        places.append([fdm["position/h-agl-ft"], fdm["attitude/theta-deg"]])
        for _ in range(3 * hz):
            fdm.run()
            nz.append(fdm["accelerations/Nz"])
        rocking[integrators, hz] = np.ptp(nz[-hz:])
    assert np.ptp(places, axis=0) == pytest.approx(0.0, abs=1e-6)
    assert rocking["default", 60] < 1e-3
    assert rocking["precise", 60] > 2.0
    assert 0.5 < rocking["precise", 120] < 1.0
    assert rocking["precise", 240] < 0.05


@pytest.mark.parametrize("integrators", ["default", "precise"])
def test_an_aircraft_rests_on_the_ground_at_any_step(integrators):
    """JSBSim at 30 Hz does not come to rest."""
    rough, fine = (
        Aircraft("c172p", altitude=0, mode="ground", T=1 / hz, integrators=integrators).fdm
        for hz in (30, 240)
    )
    for name in ("position/h-agl-ft", "attitude/theta-deg"):
        assert rough[name] == pytest.approx(fine[name], abs=1e-6)


def standing(planet, gravity):
    """A c172p at rest at the equator, 10,000 ft up."""
    condition = TrimCondition(altitude=10000, speed=0, mode="none")
    return Aircraft("c172p", condition=condition, planet=planet, gravity=gravity)


@pytest.mark.parametrize(
    ("planet", "gravity", "radius", "j2", "rate"),
    [
        (None, None, A, J2, OMEGA),
        ("WGS-84", "J2", A, J2, OMEGA),
        ("WGS-84", "point mass", A, 0.0, OMEGA),
        ("round", None, 20902254.5305, 0.0, OMEGA),
        ("round, fixed", "point mass", 20902254.5305, 0.0, 0.0),
        ({"rotation_rate": 1e-3}, None, A, J2, 1e-3),
        ({"semimajor_axis": 2.1e7, "GM": 1.5e16}, None, 2.1e7, J2, OMEGA),
    ],
)
def test_gravity_and_rotation_are_those_of_the_planet(planet, gravity, radius, j2, rate):
    fdm = standing(planet, gravity).fdm
    gm = planet.get("GM", GM) if isinstance(planet, dict) else GM
    r = radius + 10000.0
    # geopotential at the equator
    g = gm / r**2 * (1 + 1.5 * j2 * (radius / r) ** 2)
    assert fdm["position/radius-to-vehicle-ft"] == pytest.approx(r, abs=1e-6)
    assert fdm["accelerations/gravity-ft_sec2"] == pytest.approx(g, rel=1e-12)
    # at rest to the Earth
    assert fdm["velocities/eci-y-fps"] == pytest.approx(rate * r, rel=1e-12, abs=1e-12)


def test_initial_conditions_replace_those_of_a_condition_that_is_not_trimmed():
    state = {"ic/theta-deg": 5.0, "ic/ve-fps": 300.0, "ic/vd-fps": -40.0, "ic/q-rad_sec": 0.2}
    condition = TrimCondition(altitude=5000, speed=90, heading=90, mode="none", setup=state)
    found = Airframe("c172p")
    trim(found, condition)
    read = {
        "attitude/theta-deg": 5.0,
        "velocities/v-north-fps": 0.0,
        "velocities/v-east-fps": 300.0,
        "velocities/v-down-fps": -40.0,
        "velocities/q-rad_sec": 0.2,
        "position/h-sl-ft": 5000.0,
        "attitude/psi-deg": 90.0,
    }
    for name, value in read.items():
        assert found.fdm[name] == pytest.approx(value, abs=1e-9), name
