"""Algebraic models of aircraft whose engines settle in steps of time only."""

import warnings

import models_from_outside as outside
import numpy as np
import pytest
from how_many import first
from plain_jsbsim import open_fdm

from pathsim_jsbsim_blocks import Aircraft, LinearisationError
from pathsim_jsbsim_blocks.flight import settling

# every bundled aircraft with constant-speed propellers or a turboprop that trims: ft, KCAS
SPEEDS = {
    "c310": (5000, (160, 110, 135)),
    "pc7": (5000, (136, 110, 150)),
    "c182": (5000, (98, 80, 120)),
    "pa28": (2000, (75, 88, 96)),
    "Boeing314": (5000, (130, 147, 165)),
    "pogo-jsbsim": (5000, (150, 167, 190)),
    "DHC6": (5000, (100, 115, 133)),
}
CASES = [(name, speeds[i]) for i in range(3) for name, (_, speeds) in SPEEDS.items()]

# of these 8 s show no spiral and no phugoid, or up and down are not opposite in the throttle
_NOT_IN_FLIGHT = ("DHC6", "pogo-jsbsim")

# rad/s: faster motion has other poles in JSBSim's Euler steps of 1/120 s (c310 by 16 %)
FAST = 8.0


def plane(name, speed):
    gear = 0.0 if name in ("pc7", "c310", "737") else None
    setup = {"propulsion/fuel_freeze": 1.0}
    altitude = SPEEDS.get(name, (5000,))[0]
    return Aircraft(name, altitude=altitude, speed=speed, gear=gear, setup=setup)


def settled(block, faster=0.0, higher=0.0, more=0.0):
    """The acceleration along the path in plain JSBSim, ft/s2, after 50 s without integration.

    ``more`` throttle than in the trim.
    """
    trim = block.trim
    gear = dict.fromkeys(("gear/gear-cmd-norm", "gear/gear-pos-norm"), trim.gear)
    fdm = open_fdm(block.aircraft, 1 / 120, gear)
    fdm["ic/h-sl-ft"] = trim.altitude + higher
    fdm["ic/vt-fps"] = trim.tas + faster
    fdm["ic/alpha-deg"] = trim.alpha
    fdm["ic/theta-deg"] = trim.theta
    fdm["ic/beta-deg"] = trim.beta
    fdm["ic/phi-deg"] = trim.phi
    fdm.run_ic()
    governors = [f"propulsion/engine[{i}]/constant-speed-mode" for i in range(len(trim.throttle))]
    on = [fdm[name] for name in governors]
    for name in governors:
        fdm[name] = 0.0
    fdm["propulsion/set-running"] = -1
    for name, value in zip(governors, on, strict=True):
        fdm[name] = value
    fdm["propulsion/fuel_freeze"] = 1.0
    for name in ("elevator", "aileron", "rudder"):
        fdm[f"fcs/{name}-cmd-norm"] = getattr(trim, name)
    fdm["fcs/pitch-trim-cmd-norm"] = trim.pitch_trim
    for i, throttle in enumerate(trim.throttle):
        fdm[f"fcs/throttle-cmd-norm[{i}]"] = throttle + more
    for state in ("rate", "position"):
        for motion in ("translational", "rotational"):
            fdm[f"simulation/integrator/{state}/{motion}"] = 0
    for _ in range(6000):
        fdm.run()
    velocity = np.array([fdm[f"velocities/{axis}-aero-fps"] for axis in "uvw"])
    rates = [fdm[f"accelerations/{axis}dot-ft_sec2"] for axis in "uvw"]
    return velocity @ rates / np.linalg.norm(velocity)


@pytest.mark.parametrize(("name", "speed"), first(CASES, 2))
def test_the_derivatives_of_the_airspeed_are_those_of_a_settled_engine(name, speed):
    block = plane(name, speed)
    model = block.linear_model("algebraic")
    row = model.A[model.states.index("vt")]
    by_speed = (settled(block, faster=2.0) - settled(block, faster=-2.0)) / 4.0
    by_height = (settled(block, higher=30.0) - settled(block, higher=-30.0)) / 60.0
    # tables have kinks within 2 ft/s of some of these conditions
    assert row[model.states.index("vt")] == pytest.approx(by_speed, rel=0.02), by_speed
    assert row[model.states.index("h")] == pytest.approx(by_height, rel=0.05, abs=2e-5), by_height
    by_throttle = (settled(block, more=1e-3) - settled(block, more=-1e-3)) / 2e-3
    throttle = model.B[model.states.index("vt"), model.inputs.index("throttle")]
    assert throttle == pytest.approx(by_throttle, rel=0.02), by_throttle


@pytest.mark.parametrize(
    ("name", "speed"), first([case for case in CASES if case[0] not in _NOT_IN_FLIGHT])
)
def test_the_modes_are_those_of_the_flown_model(name, speed):
    block = plane(name, speed)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        flown = np.linalg.eigvals(block.linear_model().A)
    for mode in block.linear_model("algebraic").modes():
        # 8 s show slower ones with an error of their own
        if 0.02 < abs(mode.pole) < FAST:
            nearest = flown[np.argmin(np.abs(flown - mode.pole))]
            assert abs(mode.pole - nearest) < 0.05 * abs(nearest), mode


def test_an_engine_that_does_not_settle_is_refused(monkeypatch):
    block = plane("c182", 98)
    # too few steps for its governor
    monkeypatch.setattr(settling, "_STEPS", 100)
    with pytest.raises(LinearisationError) as error:
        block.linear_model("algebraic")
    assert (error.value.reason, error.value.aircraft) == ("engine", "c182")


def test_the_model_of_a_light_propeller_is_that_of_its_flight(tmp_path):
    """A tenth of the inertia: JSBSim's steady state gave B[vt, throttle] = 0.000003."""
    root = outside.light_propeller(tmp_path, 10)
    block = Aircraft("c172p", altitude=5000, speed=90, root=root)
    model = block.linear_model("algebraic")
    row, column = model.states.index("vt"), model.inputs.index("throttle")
    # settled in held flight at 1/1000 s
    assert model.A[row, row] == pytest.approx(-0.058294, abs=1e-6)
    assert model.B[row, column] == pytest.approx(6.604390, abs=1e-5)
    [phugoid] = [mode for mode in model.modes() if mode.name == "phugoid"]
    [flown] = [mode for mode in block.linear_model().modes() if mode.name == "phugoid"]
    assert phugoid.damping == pytest.approx(flown.damping, rel=0.01)
