"""The Newton search against JSBSim's own, against its promises, and flown."""

import dataclasses
import math
import warnings
from pathlib import Path

import numpy as np
import pytest
from fleet_conditions import FEW, FLYING
from how_many import first
from models_from_outside import digital_throttle
from pathsim import Simulation
from scipy.optimize import lsq_linear
from scipy.spatial.transform import Rotation

from pathsim_jsbsim_blocks import Aircraft, ParameterError, TrimCondition, TrimError
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.flight import trim
from pathsim_jsbsim_blocks.flight.airframe import Airframe
from pathsim_jsbsim_blocks.flight.trimming.search import bounded, solution

CRUISE = {"altitude": 15000, "speed": 250}

# ft/s2 and rad/s2, what `trim` promises
TOLERANCES = dict.fromkeys(("udot", "vdot", "wdot"), 1e-4) | dict.fromkeys(
    ("pdot", "qdot", "rdot"), 1e-5
)


def flown(airframe, state, duration=10.0):
    """Height off the path in ft, bank in deg and speed in kt lost in a flight, controls fixed."""
    fdm = airframe.fdm
    climb = fdm["velocities/h-dot-fps"]
    for _ in range(round(duration * 120)):
        fdm.run()
    return (
        fdm["position/h-sl-ft"] - state.altitude - climb * duration,
        fdm["attitude/phi-deg"] - state.phi,
        fdm["velocities/vc-kts"] - state.speed,
    )


def found(aircraft, **condition):
    airframe = Airframe(aircraft)
    state = trim(airframe, TrimCondition(**{"gear": 1, **condition}))
    for name, tolerance in TOLERANCES.items():
        assert abs(getattr(state, name)) <= tolerance
    return airframe, state


@pytest.mark.parametrize("aircraft", first([*FEW, *sorted(set(FLYING) - set(FEW))], len(FEW)))
def test_what_jsbsim_trims_the_newton_search_trims_too(aircraft):
    altitude, speed, gear, create = FLYING[aircraft]
    condition = TrimCondition(
        altitude=altitude, speed=speed, gear=gear, setup={"propulsion/fuel_freeze": 1.0}
    )
    airframe = Airframe(aircraft, create=dict.fromkeys(create, 0.0))
    ours = trim(airframe, condition)
    if any(airframe.fdm[name] for name in airframe.of_engines("constant-speed-mode")):
        with pytest.raises(TrimError) as error:
            trim(airframe, dataclasses.replace(condition, solver="jsbsim"))
        assert "solver='newton'" in str(error.value)
        return
    theirs = trim(airframe, dataclasses.replace(condition, solver="jsbsim"))
    # JSBSim trims this turboprop without the torque of its propellers
    near = 3e-3 if aircraft == "DHC6" else 1e-3
    for angle in ("alpha", "theta", "phi", "gamma", "psi", "beta"):
        off = math.remainder(getattr(ours, angle) - getattr(theirs, angle), 360.0)
        assert off == pytest.approx(0.0, abs=near), angle
    # JSBSim stops before this aircraft's engines have settled: it climbs 4 ft in 30 s
    throttle = 5e-3 if aircraft == "Short_S23" else 1e-3
    assert ours.throttle == pytest.approx(theirs.throttle, abs=throttle)
    for name, tolerance in TOLERANCES.items():
        assert abs(getattr(ours, name)) <= tolerance
    assert set(ours.free) == {"alpha", "pitch_trim", "phi", "aileron", "rudder", "throttle"}


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        ("SGS", {"speed": 55, "mode": "glide"}),
        ("c172p", {"speed": 70, "mode": "glide"}),
        ("737", {"altitude": 15000, "speed": 250, "throttle": 0.8}),
        ("737", {"altitude": 15000, "speed": 250, "thrust": 10000.0}),
        ("737", {"altitude": 15000, "speed": 300, "thrust": 16000.0, "free": "speed"}),
        ("c172p", {"altitude": 3000, "speed": 90, "beta": 5.0}),
        ("737", {"altitude": 15000, "speed": 250, "beta": -5.0, "mode": "full"}),
        ("c172p", {"speed": 90, "mode": "turn", "bank": -30, "solver": "newton"}),
        ("737", {"altitude": 30000, "mach": 0.8, "gear": 0, "heading": 123}),
        # JSBSim's own settling of its engines ends beside their equilibrium
        ("c310", {"altitude": 458, "speed": 125.65, "gear": 0}),
        # a governor stopped their engines while JSBSim settled them
        ("c182", {"altitude": 700, "speed": 60}),
        ("pa28", {"altitude": 700, "speed": 90}),
        # JSBSim's search refused it
        ("c310", {"altitude": 5000, "speed": 98, "gear": 0}),
        ("737", {"speed": 250, "mode": "turn", "bank": 30, "wind_north": 80, "solver": "newton"}),
        # its rudder starts anew from the yaw damper in each step
        ("f16", {"altitude": 5000, "speed": 276, "gear": 0, "beta": -0.5}),
        # turboprops, which JSBSim starts at idle in the first step
        ("pc7", {"altitude": 5000, "speed": 136, "gear": 0, "solver": "newton"}),
        ("DHC6", {"altitude": 5000, "speed": 133, "solver": "newton"}),
        # JSBSim's own settling of its propeller ends 5 % beside the equilibrium
        ("c172p", {"altitude": 3848, "speed": 119.3, "beta": -0.47}),
        ("737", {**CRUISE, "mode": "turn", "bank": 45, "wind_north": 80, "solver": "newton"}),
    ],
)
def test_what_is_trimmed_is_what_was_asked_for_and_flies_on(aircraft, condition):
    airframe, state = found(aircraft, **condition)
    asked = {"altitude": 5000, "gamma": 0.0, "beta": 0.0, **condition}
    for name in {"altitude", "speed", "mach", "gamma", "beta", "thrust"} & {*asked} - {*state.free}:
        assert getattr(state, name) == pytest.approx(asked[name], abs=1e-6), name
    if "throttle" in condition:
        assert {*state.throttle} == {condition["throttle"]}
    fdm = airframe.fdm
    sideways = fdm["velocities/v-aero-fps"]
    for _ in range(30):
        fdm.run()
        # nothing moves at first: ft/s2 and rad/s2, as issued
        assert abs(fdm["velocities/v-aero-fps"] - sideways) * 120 < 0.1
        sideways = fdm["velocities/v-aero-fps"]
        for axis in "pqr":
            assert abs(fdm[f"accelerations/{axis}dot-rad_sec2"]) < 0.02
    height, bank, speed = flown(airframe, state, 9.75)
    assert abs(height) < 3.0 or aircraft == "f16"  # unstable
    assert abs(speed) < 1.0
    assert abs(bank) < 0.1


@pytest.mark.parametrize(
    ("aircraft", "bad"),
    [
        # left the propellers at another speed, and the glide 10 lb of thrust
        ("C130", {"speed": 163, "mode": "turn", "bank": 75}),
        # left the integrator of the pitch law
        ("f16", {"speed": 225, "mode": "turn", "bank": 75}),
        ("737", {"speed": 100}),
    ],
)
def test_other_trims_and_a_failed_search_leave_no_trace(aircraft, bad):
    speed = {"C130": 163, "f16": 225, "737": 250}[aircraft]
    good = TrimCondition(altitude=5000, speed=speed, mode="glide", gear=0)
    airframe = Airframe(aircraft)
    fresh = trim(Airframe(aircraft), good)
    trim(airframe, dataclasses.replace(good, speed=1.2 * speed, altitude=8000))
    with pytest.raises(TrimError):
        trim(airframe, TrimCondition(altitude=5000, solver="newton", **bad), hint=False)
    again = trim(airframe, good)
    for name in ("alpha", "gamma", "pitch_trim", "aileron", "rudder", "thrust"):
        assert getattr(again, name) == pytest.approx(getattr(fresh, name), abs=1e-7), name


def test_a_glide_is_as_steep_as_lift_over_drag():
    airframe, state = found("SGS", speed=55, mode="glide")
    ratio = airframe.fdm["forces/fwz-aero-lbs"] / airframe.fdm["forces/fwx-aero-lbs"]
    assert math.tan(math.radians(state.gamma)) == pytest.approx(-1 / ratio, rel=1e-4)
    assert "gamma" in state.free
    assert "throttle" not in state.free


def test_a_coordinated_turn_has_no_side_load_and_the_radius_of_the_textbook():
    airframe, state = found(
        "737", altitude=15000, speed=210, gear=0, mode="turn", bank=40, coordinated=True
    )
    g = airframe.fdm["accelerations/gravity-ft_sec2"]
    # the textbook's radius and load factor are those of a small angle of attack; here it is 8 deg
    radius = state.tas**2 / (g * math.tan(math.radians(40)))
    assert state.turn_radius == pytest.approx(radius, rel=0.02)
    assert state.nz == pytest.approx(1 / math.cos(math.radians(40)), rel=0.02)
    # the Earth's rotation, 0.0034 g at the equator, is not in the rate
    assert state.ny == pytest.approx(0.0, abs=2.5e-3)
    heading = state.psi
    flown(airframe, state)
    turned = math.remainder(airframe.fdm["attitude/psi-deg"] - heading, 360.0)
    assert turned == pytest.approx(10 * state.turn_rate, abs=0.1)


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        # no coordinated turn exists in this model: the rudder's side force and yaw are nearly those
        # of the sideslip
        ("T37", {"altitude": 300, "speed": 93.6, "bank": 35}),
        ("T37", {"altitude": 300, "speed": 121, "bank": 55}),
        ("737", {"altitude": 15000, "speed": 250, "bank": -30, "heading": 358}),
        ("c172p", {"altitude": 3000, "speed": 90, "bank": 60, "heading": 90}),
    ],
)
def test_a_turn_has_its_heading_no_sideslip_and_the_rate_of_its_forces(aircraft, condition):
    airframe, state = found(aircraft, mode="turn", **{**condition, "gear": 0})
    fdm = airframe.fdm
    assert state.beta == pytest.approx(0.0, abs=1e-6)
    assert state.phi == pytest.approx(condition["bank"], abs=1e-6)
    # JSBSim's own turn trim leaves the nose up to 6 deg beyond, into the turn
    away = math.remainder(state.psi - condition.get("heading", 0.0), 360.0)
    assert away == pytest.approx(0.0, abs=0.01)
    # force across the horizontal velocity over mass and speed, from JSBSim's forces in body axes
    force = [fdm[f"forces/fb{axis}-total-lbs"] for axis in "xyz"]
    turned = Rotation.from_euler("ZYX", [state.psi, state.theta, state.phi], degrees=True)
    north, east, _ = turned.apply(force)
    along = np.array([fdm["velocities/v-north-fps"], fdm["velocities/v-east-fps"]])
    across = (along[0] * east - along[1] * north) / (along @ along)
    rate = across / fdm["inertia/mass-slugs"]
    assert math.radians(state.turn_rate) == pytest.approx(rate, rel=2e-3)
    assert state.ny == pytest.approx(force[1] / state.weight, abs=2e-3)
    heading = state.psi
    height, bank, speed = flown(airframe, state, 5.0)
    turned = math.remainder(fdm["attitude/psi-deg"] - heading, 360.0)
    assert turned == pytest.approx(5 * state.turn_rate, abs=0.1)
    assert abs(height) < 5.0
    assert abs(bank) < 0.1
    assert abs(speed) < 0.5


def test_a_pull_up_curves_the_path_by_the_load_factor():
    airframe, state = found("737", altitude=15000, speed=250, mode="pull-up", load_factor=1.5)
    climb, fdm = state.gamma, airframe.fdm
    g = fdm["accelerations/gravity-ft_sec2"]
    for _ in range(30):
        fdm.run()
    rate = math.radians(fdm["flight-path/gamma-deg"] - climb) / 0.25
    assert rate == pytest.approx(0.5 * g / state.tas, rel=0.02)


@pytest.mark.parametrize(
    ("aircraft", "condition", "reason", "limit"),
    [
        ("737", {"altitude": 15000, "speed": 140, "alpha_max": 12}, "alpha limit", 12.0),
        ("737", {"altitude": 15000, "speed": 400, "gamma": 9}, "thrust", 1.0),
        ("737", {"altitude": 15000, "speed": 250, "gamma": -20}, "thrust", 0.0),
        # the model's own alphalimits, 0.28 rad
        ("c172p", {"altitude": 5000, "speed": 40}, "alpha limit", math.degrees(0.28)),
        ("c172p", {"speed": 60, "payload": [1500]}, "alpha limit", math.degrees(0.28)),
        ("SGS", {"altitude": 5000, "speed": 60}, "thrust", None),
        ("c172p", {"altitude": 3, "speed": 70}, "ground", None),
        ("f16", {"altitude": 5000, "speed": 276, "gear": 0, "beta": -5}, "rudder", -1.0),
        # with the elevator at its other end the nose rises
        (
            "MD11",
            {"altitude": 5000, "speed": 284, "gear": 0, "mode": "pull-up", "load_factor": 4},
            "no convergence",
            None,
        ),
        # after a search that was given up the throttle still has its effect
        ("pc7", {"altitude": 5000, "speed": 204, "gear": 0}, "thrust", 1.0),
        (
            "B17",
            {"altitude": 5000, "speed": 166, "gear": 0, "mode": "turn", "bank": -75},
            "thrust",
            1.0,
        ),
        # the pitching moment of this model is a sawtooth over the airspeed
        ("Camel", {"altitude": 5000, "speed": 130, "mode": "glide"}, "no equilibrium", None),
        # its engines are not running: the propellers start to turn, and do not settle
        pytest.param(
            "L410",
            {"speed": 143, "gear": 0, "mode": "glide"},
            "propeller",
            None,
            marks=pytest.mark.long,
        ),
    ],
)
def test_a_failure_names_the_limit_and_its_value(aircraft, condition, reason, limit):
    with pytest.raises(TrimError) as error:
        trim(Airframe(aircraft), TrimCondition(**condition), hint=False)
    assert error.value.reason == reason
    assert error.value.limit == (limit if limit is None else pytest.approx(limit))
    assert all(map(math.isfinite, error.value.residuals.values()))


def test_with_one_engine_out_the_rudder_holds_the_nose():
    _, both = found("737", altitude=15000, speed=250, solver="newton", gear=0)
    rudders = []
    for dead in (0, 1):
        airframe, state = found("737", altitude=15000, speed=250, gear=0, engines_off=[dead])
        fdm = airframe.fdm
        assert fdm[f"propulsion/engine[{dead}]/thrust-lbs"] == pytest.approx(0.0, abs=1e-9)
        assert fdm[f"propulsion/engine[{dead}]/reverser-angle-rad"] == 0.0
        # a rudder costs little drag in this model: the other engine does the work of both
        assert state.thrust == pytest.approx(both.thrust, rel=0.01)
        assert state.beta == pytest.approx(0.0, abs=1e-6)
        assert {"phi", "aileron", "rudder"} < set(state.free)
        height, bank, speed = flown(airframe, state)
        assert (height, bank, speed) == pytest.approx((0.0, 0.0, 0.0), abs=2.0)
        assert fdm[f"propulsion/engine[{dead}]/thrust-lbs"] == 0.0
        rudders.append(state.rudder)
    # positive yaws the nose left, away from a dead right engine
    assert rudders[1] > 0.01
    assert rudders[0] == pytest.approx(-rudders[1], rel=1e-3)


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        ("f16", {"altitude": 10000, "speed": 250, "mode": "glide"}),
        ("c172p", {"altitude": 5000, "speed": 70, "mode": "glide"}),
        ("c172p", {"altitude": 0, "mode": "ground"}),
        ("737", {"altitude": 0, "mode": "ground"}),
        ("737", {"altitude": 10000, "speed": 250, "mode": "none"}),
    ],
)
def test_engines_that_do_not_run_stay_off(aircraft, condition):
    airframe = Airframe(aircraft)
    state = trim(airframe, TrimCondition(**condition, gear=1, engines_off="all"))
    fdm = airframe.fdm
    thrusts = [f"propulsion/engine[{i}]/thrust-lbs" for i in range(airframe.engines)]
    assert state.thrust == pytest.approx(0.0, abs=1e-9)
    for _ in range(360):
        fdm.run()
        assert all(fdm[name] == pytest.approx(0.0, abs=1e-9) for name in thrusts)
    # and run again in the next trim
    speed = 90 if aircraft == "c172p" else 250
    assert trim(airframe, TrimCondition(altitude=5000, speed=speed, gear=1))
    fdm = airframe.fdm
    assert all(fdm[name] > 10.0 for name in thrusts)


@pytest.mark.parametrize("how", ["setup", "properties"])
@pytest.mark.parametrize("aircraft", ["c172p", "737"])
def test_set_running_is_respected(aircraft, how):
    stopped = {"propulsion/engine[0]/set-running": 0.0}
    condition = {"altitude": 5000, "speed": 90 if aircraft == "c172p" else 250, "mode": "none"}
    plane = Aircraft(aircraft, **condition, gear=1, **{how: stopped})
    Simulation([plane], dt=plane.T, log=False).run(3.0)
    assert plane.fdm["propulsion/engine[0]/set-running"] == 0.0
    assert abs(plane.fdm["propulsion/engine[0]/thrust-lbs"]) < 20.0


def test_an_engine_starts_on_the_ground():
    airframe = Airframe("c172p")
    trim(airframe, TrimCondition(altitude=0, mode="ground", engines_off=[0]))
    fdm = airframe.fdm
    fdm["propulsion/magneto_cmd"], fdm["propulsion/starter_cmd"] = 3, 1
    fdm["fcs/mixture-cmd-norm"], fdm["fcs/throttle-cmd-norm"] = 0.87, 0.2
    for _ in range(600):
        fdm.run()
    assert fdm["propulsion/engine/set-running"] == 1.0
    assert fdm["propulsion/engine/thrust-lbs"] > 50.0


def test_without_an_engine_there_is_no_level_flight():
    with pytest.raises(TrimError) as error:
        trim(Airframe("f16"), TrimCondition(altitude=10000, speed=250, engines_off=[0]))
    assert error.value.reason == "thrust"
    with pytest.raises(ParameterError) as error:
        trim(Airframe("SGS"), TrimCondition(speed=55, mode="glide", engines_off=[0]))
    assert (error.value.parameter, error.value.value) == ("engines_off", (0,))


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        ("A320", {"altitude": 5000, "speed": 144, "gear": 0.0}),
        ("737", {"altitude": 30000, "speed": 420, "gear": 1.0}),
        ("c172p", {"altitude": 5000, "speed": 30}),
        # far too fast: a speed twice that of the first is above what a condition allows
        ("787-8", {"altitude": 5000, "speed": 1192, "gear": 0.0}),
        pytest.param("c182", {"altitude": 5000, "speed": 245}, marks=pytest.mark.long),
    ],
)
def test_a_failure_names_the_nearest_speed_that_trims(aircraft, condition):
    with pytest.raises(TrimError) as error:
        trim(Airframe(aircraft), TrimCondition(**condition))
    nearest = error.value.nearest
    exact = dataclasses.replace(nearest, solver="newton")
    trim(Airframe(aircraft), exact)
    # two knots nearer to what was asked for, it does not
    nearer = nearest.speed - math.copysign(2.0, nearest.speed - condition["speed"])
    with pytest.raises(TrimError):
        trim(Airframe(aircraft), dataclasses.replace(exact, speed=nearer), hint=False)


def test_a_steady_trim_is_told_from_one_that_departs():
    def state(aircraft, **condition):
        return trim(
            Airframe(aircraft), TrimCondition(**condition), fly=10 if aircraft == "737" else 30
        )

    condition = {"altitude": 15000, "speed": 280, "gear": 0.0, "solver": "newton"}
    jet = state("737", **condition)
    assert jet.steady
    airframe, untested = found("737", **condition)
    assert dataclasses.replace(jet, drift=None) == untested
    height, bank, speed = flown(airframe, untested)
    # its engines have settled anew
    assert jet.drift == pytest.approx((10.0, height, speed, bank), abs=0.02)
    # unstable in pitch, and flown without its pilot
    assert state("XB-70", altitude=5000, speed=192, gear=0.0).steady is False
    assert trim(Airframe("737"), TrimCondition(**condition)).steady is None
    assert state("c172p", speed=90, mode="none").drift is None


def test_a_gear_that_is_down_in_fast_flight_is_warned_of():
    fast = {"altitude": 10000, "speed": 280}
    with pytest.warns(
        RuntimeWarning, match="737 at 280 KCAS: the landing gear is down, .* gear=1 confirms it"
    ):
        trim(Airframe("737"), TrimCondition(**fast))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for aircraft, condition in (
            ("737", {**fast, "gear": 0}),
            ("737", {**fast, "gear": 1}),
            ("737", {**fast, "speed": 199}),
            ("737", {"altitude": 0, "mode": "ground"}),
            ("787-8", {**fast, "gear": 0}),
            ("c172p", {"speed": 90}),
        ):
            trim(Airframe(aircraft), TrimCondition(**condition))
    with pytest.warns(RuntimeWarning, match="landing gear"):
        Aircraft("737", **fast)


def test_a_flight_is_trimmed_where_it_is():
    plane = Aircraft(
        "737",
        altitude=10000,
        speed=280,
        gear=0,
        heading=30,
        gamma=2,
        flaps=0.25,
        setup={"propulsion/tank[0]/contents-lbs": 5000.0},
        properties={"atmosphere/wind-north-fps": 10.0},
    )
    sim = Simulation([plane], dt=plane.T, log=False)
    sim.run(20.0)
    fdm, outputs = plane.fdm, plane.outputs.to_array()
    state = plane.trim_here(gamma=0.0, solver="newton")
    condition = state.condition
    # the flight goes on, untouched
    assert np.array_equal(outputs, plane.outputs.to_array())
    assert plane.fdm is fdm
    assert state.altitude == pytest.approx(fdm["position/h-sl-ft"], abs=1e-3)
    assert state.speed == pytest.approx(fdm["velocities/vc-kts"], abs=1e-3)
    # 20 s of fuel are burnt
    assert state.weight == pytest.approx(fdm["inertia/weight-lbs"], abs=0.1)
    assert state.weight < plane.trim.weight - 10.0
    assert (state.gear, state.flaps) == pytest.approx((0.0, 0.25), abs=1e-6)
    assert condition.wind_north == pytest.approx(10.0)
    assert condition.latitude > 0.01
    assert state.gamma == pytest.approx(0.0, abs=1e-6)
    assert plane.trim_here(solver="newton").condition.gamma == pytest.approx(
        math.degrees(math.asin(fdm["velocities/h-dot-fps"] / fdm["velocities/vt-fps"])), abs=1e-6
    )
    # what it found starts another block, which is steady
    other = Aircraft("737", condition=condition)
    Simulation([other], dt=other.T, log=False).run(10.0)
    assert float(other.outputs["h"]) == pytest.approx(state.altitude, abs=5.0)
    with pytest.raises(ParameterError) as error:
        plane.trim_here(gama=0.0)
    assert (error.value.parameter, error.value.value) == ("change", "gama")
    assert "'gamma'" in str(error.value)


def test_near_the_ground_jsbsims_search_is_not_asked():
    low = TrimCondition(altitude=190, speed=200, gear=0)
    with pytest.raises(TrimError) as error:
        trim(Airframe("737"), dataclasses.replace(low, solver="jsbsim"))
    assert error.value.reason == "no convergence"
    trim(Airframe("737"), low)


def test_a_trim_that_does_not_hold_is_warned_of():
    # unstable in pitch, and flown without its pilot
    with pytest.warns(RuntimeWarning, match="does not hold: pitch moves by"):
        trim(Airframe("XB-70"), TrimCondition(altitude=27000, speed=300, mode="glide", gear=0))


def test_residuals_above_the_tolerance_are_a_trim_if_the_aircraft_stays(tmp_path):
    # one of 4096 steps of the throttle changes udot by 0.0036 ft/s2
    airframe = Airframe("c172p", root=digital_throttle(tmp_path, 4096))
    with pytest.warns(RuntimeWarning, match="tolerances, udot=0.00") as warned:
        state = trim(airframe, TrimCondition(altitude=5000, speed=90), fly=10)
    assert len(warned) == 1
    assert 1e-4 < abs(state.udot) < 1e-3
    # the integral of udot over 10 s is 0.006 kt
    assert abs(state.drift.speed) < 0.01
    assert abs(state.drift.height) < 1.0


def test_larger_residuals_are_no_trim(tmp_path):
    airframe = Airframe("c172p", root=digital_throttle(tmp_path, 256))
    with pytest.raises(TrimError) as error:
        trim(airframe, TrimCondition(altitude=5000, speed=90), hint=False)
    assert error.value.reason == "no convergence"
    assert abs(error.value.residuals["udot"]) > 1e-3


@pytest.mark.long
def test_a_search_that_ends_with_its_budget_has_found_its_trim():
    # governors that settle slowly
    turn = TrimCondition(altitude=5000, speed=123.5, gear=0, mode="turn", bank=45)
    lean = {f"fcs/mixture-cmd-norm[{i}]": 0.862 for i in (0, 1)}
    found = trim(Airframe("c310"), turn, setup=lean, hint=False)
    # the propellers settle at the rates of the turn
    assert found.throttle == pytest.approx([0.96312] * 2, abs=1e-4)


@pytest.mark.long
def test_engines_that_never_settle_are_given_up_in_time_for_the_nearest_speed():
    # at full throttle this fast the propeller's speed goes on oscillating
    with pytest.raises(TrimError) as error:
        trim(Airframe("c172p"), TrimCondition(speed=140, solver="newton"))
    assert (error.value.reason, error.value.limit) == ("thrust", 1.0)
    assert 120.0 < error.value.nearest.speed < 140.0


def test_the_command_says_whether_a_trim_is_steady(capsys):
    assert main(["trim", "c172p", "--speed", "90", "--steady"]) == 0
    assert "steady: after 10 s with controls fixed +" in capsys.readouterr().out
    assert main(["trim", "XB-70", "--speed", "192", "--gear", "0", "--steady", "30"]) == 0
    assert "not steady: after 30 s" in capsys.readouterr().out


@pytest.mark.parametrize("start", first(range(14), 1))
def test_the_published_envelope_is_met_point_by_point(start):
    points = np.genfromtxt(
        Path(__file__).parents[1] / "data" / "studies" / "09_trim_envelope.csv",
        delimiter=",",
        names=True,
    )[start::14]
    airframe = Airframe("737")
    for point in points:
        condition = TrimCondition(
            altitude=15000,
            speed=point["vc_request_kts"],
            gamma=point["gamma_deg"],
            gear=1,
            alpha_min=-4,
            alpha_max=12,
            solver="newton",
        )
        if point["trimmed"]:
            state = trim(airframe, condition, hint=False)
            assert state.alpha == pytest.approx(point["alpha_deg"], abs=1e-3)
            assert state.throttle[0] == pytest.approx(point["throttle_norm"], abs=1e-3)
        else:
            with pytest.raises(TrimError):
                trim(airframe, condition, hint=False)


@pytest.mark.parametrize(
    ("aircraft", "altitude", "speeds"),
    first(
        [
            ("737", 15000, (250, 260, 420, 270)),
            # at the first airspeed no surface has an effect, nor has the pitch trim
            ("A4", 5000, (1e-4, 350)),
            ("c172p", 5000, (90, 95, 30, 100)),
        ],
        2,
    ),
)
def test_a_warm_start_finds_what_a_cold_one_finds(aircraft, altitude, speeds):
    airframe = Airframe(aircraft)
    for speed in speeds:
        condition = TrimCondition(altitude=altitude, speed=speed, gear=1, solver="newton", gamma=1)
        states = []
        for there, warm in ((airframe, True), (Airframe(aircraft), False)):
            try:
                states.append(trim(there, condition, hint=False, warm=warm))
            except TrimError as error:
                states.append(error.reason)
        ours, cold = states
        if isinstance(cold, str):
            assert ours == cold
            continue
        assert airframe.fdm.get_sim_time() == 0.0
        for name in ("alpha", "theta", "phi", "pitch_trim", "aileron", "rudder"):
            assert getattr(ours, name) == pytest.approx(getattr(cold, name), abs=1e-9), name
        assert ours.throttle == pytest.approx(cold.throttle, abs=1e-9)


def test_the_bounded_step_is_the_one_that_scipy_finds():
    rng = np.random.default_rng(15)
    for rows, columns in [(6, 6), (3, 3), (7, 6), (6, 5), (3, 4)] * 20:
        a = rng.normal(size=(rows, columns)) * 10.0 ** rng.uniform(-2, 2, columns)
        b = rng.normal(size=rows)
        low, high = -(rng.random(columns) ** 3) - 1e-9, rng.random(columns) ** 3 + 1e-9
        ours = bounded(a, b, low, high, np.linalg.lstsq(a, b, rcond=None)[0])
        theirs = lsq_linear(a, b, bounds=(low, high), method="bvls", tol=1e-14).x
        assert ((low <= ours) & (ours <= high)).all()
        left, least = (np.linalg.norm(a @ x - b) for x in (ours, theirs))
        assert left <= least * (1.0 + 1e-9) + 1e-12


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_slopes_beyond_all_numbers_are_no_error():
    # a paraglider at Mach 0.04 reaches 1e24 ft/s2
    a = np.array([[1e200, 2e200, 0.0], [3e200, 1e200, 0.0], [0.0, 0.0, 0.0]])
    step = bounded(a, np.full(3, 1e201), -np.ones(3), np.ones(3), solution(a, np.full(3, 1e201)))
    assert np.isnan(step).any() or (abs(step) <= 1.0).all()
    assert np.isnan(solution(a.T @ a, np.ones(3))).all()
