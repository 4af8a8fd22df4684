"""Wind in flight: the ports of `Aircraft`, and the condition's wind."""

import math

import numpy as np
import pytest
from pathsim import Connection
from pathsim.blocks import Source, StepSource
from plain_jsbsim import FLIGHTS, fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, Autopilot, RampSource, TrimCondition
from pathsim_jsbsim_blocks import fly as run
from pathsim_jsbsim_blocks.air import isa, tas_to_cas

T = 1 / 120
PORTS = ["wind_north", "wind_east", "wind_down"]
GUSTS = [f"atmosphere/gust-{axis}-fps" for axis in ("north", "east", "down")]
SHOWN = {"h": "position/h-sl-ft", "vt": "velocities/vt-fps", "nz": "accelerations/Nz"}


def recorded(aircraft, names, *sources, duration):
    """Outputs of a flight with sources at the first ports."""
    sim, scope = diagram(aircraft, names, dict(zip(PORTS, sources, strict=False)))
    sim.run(duration)
    return sim, scope.read()[1]


def winds(seed):
    """Wind of each period, and sources of it."""
    values = np.random.default_rng(seed).normal(0.0, 12.0, (240, 3))
    values[:40] = 0.0  # nothing at first: the ports are not written
    index = lambda t: min(round(t / T), 239)  # noqa: E731
    return values, [Source(lambda t, i=i: values[index(t), i]) for i in range(3)]


@pytest.mark.parametrize("name", ["c172p", "737"])
def test_wind_is_bit_for_bit_that_of_a_plain_loop(name):
    altitude, speed = FLIGHTS[name]
    values, sources = winds(3)
    expected = fly(trimmed(name, altitude, speed), GUSTS, values, list(SHOWN.values()))
    plane = Aircraft(name, altitude=altitude, speed=speed, gear=1, solver="jsbsim")
    _, data = recorded(plane, SHOWN, *sources, duration=2.0)
    assert np.array_equal(data.T, expected)


def test_the_wind_comes_on_top_of_the_conditions_and_moves_air_and_ground_alike():
    condition = TrimCondition(speed=90.0, heading=60.0, wind_north=-20.0, wind_east=10.0)
    values, sources = winds(4)
    plane = Aircraft("c172p", condition=condition)
    sim, (vt,) = recorded(plane, ["vt"], *sources, duration=1.5)
    fdm = plane.fdm
    axes = ("north", "east", "down")
    ground = np.array([fdm[f"velocities/v-{axis}-fps"] for axis in axes])
    wind = np.array([-20.0, 10.0, 0.0]) + values[round(sim.time / T) - 1]
    assert vt[-1] == pytest.approx(np.linalg.norm(ground - wind), abs=1e-9)
    assert [fdm[f"atmosphere/total-wind-{axis}-fps"] for axis in axes] == pytest.approx(wind)
    # the pitot tube measures the motion through the air, the track that over the ground
    calibrated = tas_to_cas(0.3048 * vt[-1], isa(0.3048 * fdm["position/h-sl-ft"]))
    assert plane.outputs["vc"] == pytest.approx(calibrated / 0.514444444, rel=1e-4)
    track = math.atan2(ground[1], ground[0])
    assert fdm["flight-path/psi-gt-rad"] == pytest.approx(track, abs=1e-9)


def test_a_gust_among_the_properties_stays_where_no_wire_comes_in():
    gust = {"atmosphere/gust-down-fps": -6.0}
    plane = Aircraft("c172p", speed=90.0, properties=gust)
    recorded(plane, ["h"], duration=0.5)
    assert plane.fdm["atmosphere/gust-down-fps"] == -6.0
    recorded(plane, ["h"], StepSource(5.0, 0.1), duration=0.5)
    assert [plane.fdm[name] for name in GUSTS] == [5.0, 0.0, -6.0]


def on_autopilot(plane, wind=None):
    """The aircraft after 300 s on autopilot, with a wind blown in if one is given."""
    autopilot = Autopilot(gains="737", T=1 / 30)
    measured = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc")
    commands = ("elevator", "aileron", "rudder", "throttle")
    ramps = {
        port: RampSource(final=x, start=1.0, rise_time=20.0) for port, x in (wind or {}).items()
    }
    wires = [
        Connection(plane[measured], autopilot[measured]),
        Connection(autopilot[commands], plane[commands]),
    ]
    sim, _ = diagram(plane, sources=ramps, others=[autopilot], wires=wires)
    run(sim, 300.0)
    return plane


@pytest.mark.long
def test_a_wind_blown_in_on_autopilot_ends_at_the_trim_with_that_wind():
    north, east = 25.0, -15.0
    # burnt fuel would change the trim
    same = {"T": 1 / 30, "substeps": 4, "properties": {"propulsion/fuel_freeze": 1.0}}
    windy = TrimCondition(altitude=10000.0, speed=280.0, gear=0.0, wind_north=north, wind_east=east)
    there = Aircraft("737", condition=windy, **same)
    here = Aircraft("737", altitude=10000.0, speed=280.0, gear=0.0, **same)
    on_autopilot(here, {"wind_north": north, "wind_east": east})
    # the trim leaves out what the Earth's curvature takes of the lift: v^2 / (g r) is 4e-4, and the
    # angle of attack from zero lift is three times alpha
    for name, tolerance in (("vc", 1e-3), ("nz", 1e-3), ("alpha", 2e-3)):
        assert here.outputs[name] == pytest.approx(there.outputs[name], rel=tolerance), name
    for axis in ("north", "east"):
        name = f"velocities/v-{axis}-fps"
        assert here.fdm[name] == pytest.approx(there.fdm[name], abs=0.1), name
    # flown as long from that trim, the aircraft has found the curvature too
    on_autopilot(there)
    for name in ("vc", "nz", "alpha"):
        assert here.outputs[name] == pytest.approx(there.outputs[name], rel=1e-3), name
