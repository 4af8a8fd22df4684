"""The ready ports of `Aircraft`, each against a source of its own; its commands within their range.

What is compared with: other properties of the same flight in a plain JSBSim loop (radians, metres,
velocity components, forces), from which each port is recomputed.
"""

import contextlib
import re
import warnings

import numpy as np
import pymap3d
import pytest
from pathsim import Simulation
from pathsim.blocks import Constant, Source
from plain_jsbsim import FLIGHTS, fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, AircraftError, JSBSimFDM, TrimCondition

T = 1 / 120
INPUTS = ["elevator", "aileron", "rudder", "throttle"]
COMMANDS = [
    "fcs/elevator-cmd-norm",
    "fcs/aileron-cmd-norm",
    "fcs/rudder-cmd-norm",
    "fcs/throttle-cmd-norm[0]",
]
FOOT = 0.3048  # m
KNOT = 1852 / 3600 / FOOT  # ft/s
RAW = [
    "attitude/phi-rad",
    "attitude/theta-rad",
    "attitude/psi-rad",
    "velocities/phidot-rad_sec",
    "velocities/thetadot-rad_sec",
    "velocities/psidot-rad_sec",
    *(f"velocities/{axis}-aero-fps" for axis in "uvw"),
    *(f"velocities/v-{axis}-fps" for axis in ("north", "east", "down")),
    "velocities/vc-fps",
    "velocities/vtrue-kts",
    "atmosphere/a-fps",
    "position/h-sl-meters",
    *(f"position/ecef-{axis}-ft" for axis in "xyz"),
    *(f"forces/fb{axis}-{kind}-lbs" for axis in "xz" for kind in ("aero", "prop")),
    "inertia/weight-lbs",
]


def moves(t):
    """Increments that move the aircraft about all axes, within its commands' range."""
    return [
        -0.25 * np.sin(2 * np.pi * t / 2),
        0.4 * np.sin(2 * np.pi * t / 3),
        -0.5 * np.sin(2 * np.pi * t / 2.5),
        0.2 * np.sin(2 * np.pi * t / 4),
    ]


def held(plane, port, increment, duration=2 * T):
    """Fly with an increment at an input."""
    diagram(plane, sources={port: Constant(increment)})[0].run(duration)


@pytest.fixture(scope="module")
def flight():
    """Outputs of the block by port, and raw properties of the same flight in a plain loop."""
    k = np.arange(4 * 120)
    setup = {"ic/lat-geod-deg": 47.0, "ic/long-gc-deg": 8.5}
    fdm = trimmed("c172p", 5000.0, 90.0, gamma=2.0, heading=310.0, setup=setup)
    wind = {"atmosphere/wind-north-fps": 25.0, "atmosphere/wind-down-fps": -8.0}
    for name, value in wind.items():
        fdm[name] = value
    trim = np.array([fdm[name] for name in COMMANDS])
    raw = dict(zip(RAW, fly(fdm, COMMANDS, trim + [moves(i * T) for i in k], RAW).T, strict=True))

    plane = Aircraft(
        "c172p",
        altitude=5000.0,
        speed=90.0,
        gamma=2.0,
        heading=310.0,
        latitude=47.0,
        longitude=8.5,
        properties=wind,
        solver="jsbsim",
    )
    sources = {name: Source(lambda t, i=i: moves(t)[i]) for i, name in enumerate(INPUTS)}
    names = list(plane.output_port_labels)
    sim, scope = diagram(plane, names, sources)
    sim.run(4.0)
    return dict(zip(names, scope.read()[1], strict=True)), raw


def worked_out(raw):
    """Each port of the block, from other properties and other units."""
    get = raw.__getitem__
    phi, theta, psi = (get(f"attitude/{angle}-rad") for angle in ("phi", "theta", "psi"))
    phidot, thetadot, psidot = (
        get(f"velocities/{angle}dot-rad_sec") for angle in ("phi", "theta", "psi")
    )
    u, v, w = (get(f"velocities/{axis}-aero-fps") for axis in "uvw")
    north, east, down = (get(f"velocities/v-{axis}-fps") for axis in ("north", "east", "down"))
    true = np.sqrt(u * u + v * v + w * w)
    lat, lon, _ = pymap3d.ecef2geodetic(*(FOOT * get(f"position/ecef-{axis}-ft") for axis in "xyz"))
    # the load factors are those of the forces one step earlier, where JSBSim sums them up
    nx, nz = (
        np.concatenate(
            [
                [np.nan],
                (
                    (get(f"forces/fb{axis}-aero-lbs") + get(f"forces/fb{axis}-prop-lbs"))
                    / get("inertia/weight-lbs")
                )[:-1],
            ]
        )
        for axis in "xz"
    )
    return {
        "theta": np.degrees(theta),
        "phi": np.degrees(phi),
        "psi": np.degrees(psi),
        "p": np.degrees(phidot - psidot * np.sin(theta)),
        "q": np.degrees(thetadot * np.cos(phi) + psidot * np.cos(theta) * np.sin(phi)),
        "r": np.degrees(-thetadot * np.sin(phi) + psidot * np.cos(theta) * np.cos(phi)),
        "alpha": np.degrees(np.arctan2(w, u)),
        "beta": np.degrees(np.arcsin(v / true)),
        "gamma": np.degrees(np.arctan2(-down, np.hypot(north, east))),
        "h": get("position/h-sl-meters") / FOOT,
        "hdot": -down,
        "vc": get("velocities/vc-fps") / KNOT,
        "vt": get("velocities/vtrue-kts") * KNOT,
        "mach": true / get("atmosphere/a-fps"),
        "nx": nx,
        "nz": -nz,
        "lat": lat,
        "lon": lon,
    }


# by how much each port moves at least in that flight, in its unit: a wrong factor must show
PORTS = {
    "theta": 5.0,
    "phi": 20.0,
    "psi": 5.0,
    "p": 20.0,
    "q": 10.0,
    "r": 10.0,
    "alpha": 5.0,
    "beta": 5.0,
    "gamma": 5.0,
    "h": 10.0,
    "hdot": 5.0,
    "vc": 5.0,
    "vt": 5.0,
    "mach": 0.005,
    "nx": 0.1,
    "nz": 0.5,
    "lat": 1e-4,
    "lon": 1e-4,
}


def test_every_port_is_listed_here():
    assert [*PORTS, "elev_sat", "ail_sat", "rud_sat", "thr_sat"] == list(
        Aircraft.output_port_labels
    )


@pytest.mark.parametrize("port", PORTS)
def test_a_port_is_what_other_properties_say(flight, port):
    block, raw = flight
    assert np.ptp(block[port]) > PORTS[port]
    expected = worked_out(raw)[port]
    known = np.isfinite(expected)
    assert np.count_nonzero(~known) <= 1
    # rounding; JSBSim's weight is in another pound than its load factors, by 1.4e-8
    tolerance = 1e-7 if port in ("nx", "nz") else 1e-9
    assert block[port][known] == pytest.approx(expected[known], rel=tolerance, abs=tolerance)


@pytest.mark.parametrize(
    ("port", "signs"),
    [
        ("elevator", {"q": -1, "theta": -1, "alpha": -1, "nz": -1, "hdot": -1, "gamma": -1}),
        ("aileron", {"p": 1, "phi": 1}),
        # the nose goes left, so the wind comes from the right
        ("rudder", {"r": -1, "psi": -1, "beta": 1}),
        ("throttle", {"nx": 1, "vc": 1, "vt": 1, "mach": 1}),
    ],
)
def test_a_positive_input_does_what_its_line_in_the_manual_says(port, signs):
    def after(increment):
        plane = Aircraft("c172p", speed=90.0, heading=90.0)
        held(plane, port, increment, 0.5)
        return {name: plane.outputs[name] for name in signs}

    bare, moved = after(0.0), after(0.1)
    assert {name: np.sign(moved[name] - bare[name]) for name in signs} == signs


def test_nothing_is_saturated_before_it_flies_nor_without_an_engine():
    glider = Aircraft("SGS", altitude=5000.0, speed=50.0, mode="none")
    saturations = ["elev_sat", "ail_sat", "rud_sat", "thr_sat"]
    for plane in (Aircraft("c172p", speed=90.0), glider):
        assert [plane.outputs[name] for name in saturations] == [0.0] * 4
    held(glider, "throttle", 0.5)
    assert [glider.outputs[name] for name in saturations] == [0.0] * 4


@pytest.mark.parametrize(
    ("aircraft", "port", "increment", "command", "excess"),
    [
        ("c172p", "elevator", 1.0, 0.86993, 0.13007),
        ("c172p", "elevator", -2.0, -1.0, -1.0),
        ("c172p", "elevator", 0.5, 0.5, 0.0),
        ("737", "elevator", -2.0, -0.84041, -1.15959),
        ("737", "aileron", 1.25, 1.0, 0.25),
        ("737", "rudder", -3.0, -1.0, -2.0),
    ],
)
def test_the_aircraft_limits_its_commands_and_says_by_how_much(
    aircraft, port, increment, command, excess
):
    altitude, speed = FLIGHTS[aircraft]
    gear = 0 if aircraft == "737" else None
    plane = Aircraft(aircraft, altitude=altitude, speed=speed, gear=gear)
    beyond = pytest.warns(RuntimeWarning, match=f"{port}' exceeds the full travel")
    with beyond if abs(increment) > 2 else contextlib.nullcontext():
        held(plane, port, increment)
    # six figures of a trim whose tolerance is 1e-4 rad/s2
    assert plane.fdm[f"fcs/{port}-cmd-norm"] == pytest.approx(command, abs=1e-5)
    saturations = {"elevator": "elev_sat", "aileron": "ail_sat", "rudder": "rud_sat"}
    for other, saturation in saturations.items():
        expected = excess if other == port else 0.0
        assert plane.outputs[saturation] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("increment", "command"), [(1.0, 1.0), (-1.0, 0.0)])
def test_the_aircraft_limits_its_throttles(increment, command):
    plane = Aircraft("737", altitude=10000, speed=280, gear=0)
    held(plane, "throttle", increment)
    assert [plane.fdm[f"fcs/throttle-cmd-norm[{i}]"] for i in (0, 1)] == [command, command]
    assert plane.outputs["thr_sat"] == pytest.approx(
        plane.trim.throttle[0] + increment - command, abs=1e-12
    )


@pytest.mark.parametrize(("engines_off", "share"), [([], 0.5), ([1], 1.0)])
def test_the_excess_of_the_throttle_is_the_mean_over_the_engines_that_run(engines_off, share):
    condition = TrimCondition(altitude=10000, speed=250, gear=0, engines_off=engines_off)
    plane = Aircraft("737", condition=condition, input_properties=["throttle[0]"])
    held(plane, "throttle[0]", 1.0)
    # engine 0 is asked for its trimmed throttle and 1 more, engine 1 for nothing more
    expected = share * plane.trim.throttle[0]
    assert plane.outputs["thr_sat"] == pytest.approx(expected, abs=1e-12)


DRY = {f"propulsion/tank[{i}]/contents-lbs": 0.02 for i in (0, 1)}


@pytest.mark.parametrize(
    ("aircraft", "parameters", "said"),
    [
        # 46 lb in each collector tank, 3.3 lb/s: a plain loop of JSBSim stops them at 14.07 s
        (
            "Concorde",
            {"altitude": 5000, "speed": 280, "gear": 0},
            ["Concorde: engines 0, 1, 2, 3 stopped for lack of fuel by t = 13 s"],
        ),
        (
            "Concorde",
            {"altitude": 5000, "speed": 280, "gear": 0, "setup": {"propulsion/fuel_freeze": 1.0}},
            [],
        ),
        ("c172p", {"speed": 90, "setup": DRY}, ["c172p: engine 0 stopped for lack of fuel"]),
        # for want of ignition, tanks full
        ("c172p", {"speed": 90, "properties": {"propulsion/engine/set-running": 0.0}}, []),
    ],
)
def test_engines_that_run_out_of_fuel_are_told_once_in_a_flight(aircraft, parameters, said):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        plane = Aircraft(aircraft, T=1 / 30, **parameters)
        sim = Simulation([plane], dt=plane.T, log=False)
        for _ in range(2):
            sim.run(60.0, reset=True)
    # a trim with engines about to stop does not hold, and says so
    caught = [w for w in caught if "does not hold" not in str(w.message)]
    for warning, text in zip(caught, 2 * said, strict=True):
        assert issubclass(warning.category, RuntimeWarning)
        assert text in str(warning.message)
    runs = plane.fdm["propulsion/engine[0]/set-running"]
    assert runs == (0.0 if said or "properties" in parameters else 1.0)


def test_a_subclass_with_parameters_of_its_own_takes_a_condition():
    class Trainer(Aircraft):
        def __init__(self, speed):
            super().__init__("c172p", condition=TrimCondition(altitude=3000, speed=speed))

    assert Trainer(80).outputs["vc"] == pytest.approx(80)


def test_the_root_is_a_keyword_of_both_aircraft_blocks(tmp_path):
    # pathsim-flight's name stays in the block that stands in for its own
    for block, name in ((Aircraft, "root"), (JSBSimFDM, "JSBSim_path")):
        with pytest.raises(AircraftError, match=re.escape(str(tmp_path))):
            block(**{name: tmp_path})
    assert JSBSimFDM().JSBSim_path is None


def test_a_heading_of_north_does_not_alternate_between_0_and_360():
    fdm = trimmed("c172p", 5000.0, 90.0)
    raw = fly(fdm, [], np.empty((240, 0)), ["attitude/psi-deg"])[:, 0]
    assert raw.max() == 360.0  # JSBSim's own does
    plane = Aircraft("c172p", altitude=5000.0, speed=90.0, solver="jsbsim")
    sim, scope = diagram(plane, ["psi"])
    sim.run(2.0)
    _, [psi] = scope.read()
    assert psi.max() < 360.0
    assert plane.trim.psi == psi[0] == 0.0
    # nothing else is changed, by more than the rounding of it
    assert np.abs((psi - raw + 180.0) % 360.0 - 180.0).max() < 1e-9
    # the aircraft drifts west, by 1e-5 deg: one jump, where it really leaves north
    assert np.count_nonzero(np.abs(np.diff(psi)) > 180.0) == 1
