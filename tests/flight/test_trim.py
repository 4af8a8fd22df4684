"""Trim: the published states, every mode and option, failures that say why."""

import copy
import dataclasses
import gc
import json
import math
import pickle
import subprocess
import sys
import weakref

import pytest
from flights import TURBULENCE
from plain_jsbsim import open_fdm, trimmed

from pathsim_jsbsim_blocks import (
    Aircraft,
    ParameterError,
    TrimCondition,
    TrimError,
    TrimState,
)
from pathsim_jsbsim_blocks.flight import Airframe, empty_weight_cg, trim
from pathsim_jsbsim_blocks.flight.trimming import jsbsim as search
from pathsim_jsbsim_blocks.flight.trimming import trimmer
from pathsim_jsbsim_blocks.flight.trimming.state import UNITS

pytestmark = pytest.mark.matrix


def found(aircraft, setup=None, **condition):
    return trim(Airframe(aircraft), TrimCondition(**{"gear": 1, **condition}), setup)


def test_the_published_trim_of_the_global5000():
    # a plain JSBSim loop (tests/data/studies/04_doublet_trim.csv) prints 12 digits
    state = found(
        "global5000",
        altitude=15000,
        speed=250,
        payload=[7586.0],
        fuel=[4048.815, 4048.815, 4048.815],
        solver="jsbsim",
    )
    assert state.alpha == pytest.approx(4.31758372367, rel=1e-11)
    assert state.elevator_rad == pytest.approx(-0.0517213350122, rel=1e-11)
    assert state.elevator_norm == pytest.approx(-0.147775242892, rel=1e-11)
    assert state.throttle == pytest.approx((0.772610011742, 0.772610011742), rel=1e-11)
    assert state.weight == pytest.approx(67967.445, rel=1e-11)
    assert state.cg_x == pytest.approx(790.81419356, rel=1e-11)


@pytest.mark.parametrize(
    ("aircraft", "altitude", "speed", "gamma"),
    [
        ("c172p", 5000.0, 90.0, 0.0),
        ("737", 15000.0, 300.0, 3.0),
        ("A4", 1000.0, 300.0, 5.0),
        ("f16", 10000.0, 350.0, 0.0),
    ],
)
def test_the_same_state_as_a_plain_trim(aircraft, altitude, speed, gamma):
    state = found(aircraft, altitude=altitude, speed=speed, gamma=gamma, solver="jsbsim")
    fdm = trimmed(aircraft, altitude, speed, gamma=gamma)
    assert state.alpha == fdm["aero/alpha-deg"]
    assert state.throttle[0] == fdm["fcs/throttle-cmd-norm"]
    assert state.pitch_trim == fdm["fcs/pitch-trim-cmd-norm"]
    assert state.aileron == fdm["fcs/aileron-cmd-norm"]
    # JSBSim's own tolerance: 1e-3 ft/s2 and 1e-4 rad/s2
    assert max(abs(a) for a in (state.udot, state.vdot, state.wdot)) < 1e-3
    assert max(abs(a) for a in (state.pdot, state.qdot, state.rdot)) < 1e-4


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"speed": 50},
        {"mach": 0.3, "gamma": 5},
        {"wind_north": -20},
        {"wind_north": -20, "heading": 30},
    ],
)
@pytest.mark.parametrize("aircraft", ["c172p", "737", "A4"])
def test_on_the_ground_nothing_moves_but_the_air(aircraft, more):
    condition = TrimCondition(**{"altitude": 0, "mode": "ground", **more})
    airframe = Airframe(aircraft)
    state = trim(airframe, condition)
    fdm = airframe.fdm
    assert fdm["gear/wow"] == 1.0
    assert fdm["velocities/vg-fps"] == 0.0
    assert fdm["velocities/h-dot-fps"] == 0.0
    wind = condition.wind_north
    assert fdm["atmosphere/total-wind-north-fps"] == pytest.approx(wind, abs=1e-9)
    assert state.tas == pytest.approx(abs(wind), abs=1e-9)
    # a bent tyre turns the nose a little
    assert math.remainder(state.psi - condition.heading, 360) == pytest.approx(0, abs=0.2)
    assert "speed" not in str(condition)
    assert "gamma" not in str(condition)


def let_down(aircraft, altitude, create=()):
    """Pitch in deg and height in ft of a plain JSBSim aircraft, let down with brakes on."""
    fdm = open_fdm(aircraft, 1 / 120)
    for name in create:
        fdm[name] = 0.0
    fdm["ic/terrain-elevation-ft"], fdm["ic/h-agl-ft"] = altitude, 12.0
    fdm["ic/vc-kts"] = 0.0
    fdm.run_ic()
    for side in ("left", "center", "right"):
        fdm[f"fcs/{side}-brake-cmd-norm"] = 1.0
    for _ in range(40 * 120):
        fdm.run()
    return fdm["attitude/theta-deg"], fdm["position/h-agl-ft"]


PUSHBACK = (
    "/sim/model/pushback/position-norm",
    "/gear/gear/wow",
    *(f"/sim/model/pushback/{gain}" for gain in ("ki", "kp", "kd")),
)


# JSBSim's own search stands the Camel on two wheels at -12.3 deg, and finds nothing for dr1
@pytest.mark.parametrize("altitude", [0.0, 2000.0])
@pytest.mark.parametrize(("aircraft", "create"), [("Camel", ()), ("dr1", PUSHBACK), ("p51d", ())])
def test_a_tail_dragger_rests_on_its_tail(aircraft, create, altitude):
    airframe = Airframe(aircraft, create=dict.fromkeys(create, 0.0))
    state = trim(airframe, TrimCondition(mode="ground", altitude=altitude))
    pitch, height = let_down(aircraft, altitude, create)
    # idle power changes it a little
    assert state.theta == pytest.approx(pitch, abs=0.3)
    assert airframe.fdm["position/h-agl-ft"] == pytest.approx(height, abs=0.05)
    assert max(abs(state.wdot), 10.0 * abs(state.qdot), 10.0 * abs(state.pdot)) <= 1e-4


def test_engines_idle_as_they_do_after_minutes_on_the_ground():
    # as JSBSim initialises it the c172p's pulls with 433 lbf, and creeps with 5.6 ft/s2
    airframe = Airframe("c172p")
    state = trim(airframe, TrimCondition(mode="ground", altitude=0))
    assert state.thrust == pytest.approx(43.3, abs=0.1)
    airframe.fdm["fcs/left-brake-cmd-norm"] = airframe.fdm["fcs/right-brake-cmd-norm"] = 1.0
    for _ in range(20 * 120):
        airframe.fdm.run()
    assert airframe.fdm["propulsion/engine/thrust-lbs"] == pytest.approx(state.thrust, rel=0.02)
    assert airframe.fdm["attitude/theta-deg"] == pytest.approx(state.theta, abs=0.3)


@pytest.mark.parametrize("aircraft", ["c172p", "737"])
def test_turbulence_before_the_trim_is_refused_and_after_it_flies(aircraft):
    condition = {"altitude": 10_000, "speed": 280, "gear": 0} if aircraft == "737" else {}
    condition = {"altitude": 5000, "speed": 90, **condition}
    with pytest.raises(TrimError, match="into properties") as error:
        trim(Airframe(aircraft), TrimCondition(**condition), TURBULENCE)
    assert error.value.reason == "turbulence"
    plane = Aircraft(aircraft, **condition, properties=TURBULENCE)
    assert max(map(abs, (plane.trim.udot, plane.trim.wdot))) <= 1e-4
    # without strength it does not act
    trim(Airframe(aircraft), TrimCondition(**condition), {"atmosphere/turb-type": 3})


@pytest.mark.parametrize("mode", ["none", "full"])
def test_a_start_below_the_terrain_is_named(mode):
    setup = {"ic/terrain-elevation-ft": 3000}
    with pytest.raises(TrimError, match="500 ft below the terrain") as error:
        trim(Airframe("c172p"), TrimCondition(mode=mode, altitude=2500, speed=90, setup=setup))
    assert error.value.reason == "ground"


def test_an_aircraft_that_does_not_come_to_rest_is_told_so():
    with pytest.raises(TrimError, match="does not come to rest") as error:
        trim(Airframe("SGS"), TrimCondition(mode="ground", altitude=0))
    assert error.value.reason == "no equilibrium"


def test_after_a_ground_trim_the_ground_is_where_it_was():
    airframe = Airframe("c172p")
    trim(airframe, TrimCondition(altitude=6000, mode="ground"))
    state = trim(airframe, TrimCondition(altitude=5000, speed=90))
    assert state.alpha == pytest.approx(found("c172p", altitude=5000, speed=90).alpha, abs=1e-5)
    assert airframe.fdm["position/h-agl-ft"] == pytest.approx(5000, abs=1)
    # and a terrain that the user has set stays
    trim(airframe, TrimCondition(altitude=5000, speed=90, setup={"ic/terrain-elevation-ft": 1000}))
    trim(airframe, TrimCondition(altitude=6000, mode="ground"))
    trim(airframe, TrimCondition(altitude=5000, speed=90))
    assert airframe.fdm["position/h-agl-ft"] == pytest.approx(4000, abs=1)


def test_longitudinal_trim_leaves_the_wings_alone():
    state = found("737", altitude=15000, speed=250, mode="longitudinal")
    assert state.aileron == 0.0
    assert abs(state.wdot) < 1e-3


@pytest.mark.parametrize(("heading", "north", "east"), [(0, -30, 0), (45, -20, 10), (270, 0, 25)])
def test_wind_moves_the_ground_speed_not_the_airspeed(heading, north, east):
    airframe = Airframe("c172p")
    windy = TrimCondition(
        altitude=5000, speed=90, heading=heading, wind_north=north, wind_east=east
    )
    trim(airframe, windy)
    state = trim(airframe, windy)  # which the first one does not turn
    still = found("c172p", altitude=5000, speed=90, heading=heading)
    fdm = airframe.fdm
    course = math.radians(heading)
    for _ in range(2):
        assert fdm["velocities/vc-kts"] == pytest.approx(90.0, abs=0.01)
        assert fdm["atmosphere/total-wind-north-fps"] == pytest.approx(north, abs=1e-9)
        assert fdm["atmosphere/total-wind-east-fps"] == pytest.approx(east, abs=1e-9)
        # the aircraft's heading differs from its path through the air by a sideslip of 0.001 deg
        assert fdm["velocities/v-north-fps"] == pytest.approx(
            still.tas * math.cos(course) + north, abs=0.02
        )
        assert fdm["velocities/v-east-fps"] == pytest.approx(
            still.tas * math.sin(course) + east, abs=0.02
        )
        for _ in range(600):
            fdm.run()
    assert state.alpha == pytest.approx(still.alpha, abs=0.01)
    # and a trim in still air after it, with the same airframe, is not blown about
    calm = trim(airframe, TrimCondition(altitude=5000, speed=90, heading=heading))
    assert calm.psi == pytest.approx(still.psi, abs=1e-6)
    assert airframe.fdm["atmosphere/total-wind-north-fps"] == pytest.approx(0.0, abs=1e-9)
    assert calm.alpha == pytest.approx(still.alpha, abs=1e-6)


def test_a_warm_trim_in_another_wind_has_the_airspeed_of_its_condition():
    airframe, condition = Airframe("737"), {"altitude": 15000, "speed": 250, "gear": 1}
    for wind in (50, 20):
        trim(airframe, TrimCondition(**condition, wind_north=wind), warm=True)
        assert airframe.fdm["velocities/vc-kts"] == pytest.approx(250, abs=1e-6)


def test_the_cg_really_moves_and_the_installed_model_stays():
    x = empty_weight_cg("global5000")[0]
    condition = {"altitude": 15000, "speed": 250, "gear": 1}
    here = trim(Airframe("global5000"), TrimCondition(**condition))
    ahead = trim(Airframe("global5000", empty_cg_x=0.95 * x), TrimCondition(**condition))
    assert here.cg_x - ahead.cg_x == pytest.approx(0.05 * x * 50300 / here.weight, rel=0.05)
    # CG ahead: more nose-up elevator (negative is trailing edge up)
    assert ahead.elevator_rad < here.elevator_rad - 0.01
    assert empty_weight_cg("global5000")[0] == x
    # a loaded model keeps its centre of gravity
    with pytest.raises(ParameterError, match=r"empty_cg_x must be that of the airframe \(None\)"):
        trim(Airframe("global5000"), TrimCondition(**condition, empty_cg_x=0.95 * x))


@pytest.mark.parametrize(
    ("aircraft", "condition", "reason"),
    [
        ("737", {"altitude": 15000, "speed": 120, "solver": "jsbsim"}, "alpha limit"),
        # a wind from behind lifts the tail, a storm from ahead the whole aircraft
        (
            "c172p",
            {"altitude": 0, "mode": "ground", "wind_north": 20, "solver": "jsbsim"},
            "pitch angle",
        ),
        (
            "c172x",
            {"altitude": 0, "mode": "ground", "wind_north": -150, "solver": "jsbsim"},
            "height",
        ),
        ("c172x", {"altitude": 0, "mode": "ground", "wind_north": -150}, "no equilibrium"),
    ],
)
def test_a_failed_trim_says_why(aircraft, condition, reason):
    condition = TrimCondition(**condition)
    with pytest.raises(TrimError) as error:
        trim(Airframe(aircraft), condition)
    assert error.value.reason == reason
    assert error.value.condition is condition
    assert error.value.aircraft == aircraft
    assert set(error.value.residuals) == {"udot", "vdot", "wdot", "pdot", "qdot", "rdot"}
    assert max(map(abs, error.value.residuals.values())) > 1e-3


@pytest.mark.parametrize(
    ("condition", "nearest"), [({"speed": 55}, None), ({"speed": 25, "mode": "glide"}, 35.0)]
)
def test_without_power_another_speed_helps_a_glide_only(condition, nearest):
    airframe = Airframe("SGS")
    with pytest.raises(TrimError) as error:
        trim(airframe, TrimCondition(**condition))
    assert (error.value.nearest and error.value.nearest.speed) == nearest


@pytest.mark.long
def test_what_was_written_outlasts_a_failed_trim():
    # fields left at None are not written, whether or not the trims in between converged
    airframe = Airframe("c172p", create={"ours/lamp": 2.0})
    airframe.write({"fcs/flap-cmd-norm": 0.0})
    with pytest.raises(TrimError):
        trim(airframe, TrimCondition(altitude=3000, speed=20, flaps=0.5, fuel=[50, 60]))
    before = airframe.fdm
    state = trim(airframe, TrimCondition(altitude=3000, speed=70))
    assert airframe.fdm is not before
    assert airframe.fdm["ours/lamp"] == 2.0
    assert state == dataclasses.replace(
        found("c172p", altitude=3000, speed=70, flaps=0.5, fuel=[50, 60]), condition=state.condition
    )


@pytest.mark.parametrize("mode", ["none", "full"])
def test_after_a_flight_that_broke_it_an_airframe_starts_fresh(mode):
    airframe, condition = Airframe("c172p"), TrimCondition(altitude=5000, speed=90, mode=mode)
    fresh = trim(airframe, condition)
    airframe.fdm["fcs/aileron-cmd-norm"] = math.nan
    for _ in range(10):
        airframe.fdm.run()
    assert math.isnan(airframe.fdm["velocities/p-rad_sec"])
    assert trim(airframe, condition) == fresh


GROUND = """
import sys
from pathsim_jsbsim_blocks import TrimCondition, TrimError
from pathsim_jsbsim_blocks.flight.airframe import Airframe
from pathsim_jsbsim_blocks.flight import trim
try:
    condition = TrimCondition(
        mode="ground", altitude=0, wind_east=float(sys.argv[2]), solver="jsbsim"
    )
    trim(Airframe(sys.argv[1]), condition)
except TrimError as error:
    print(error.reason)
"""


@pytest.mark.long
# JSBSim's search for a ground attitude reads invalid memory, which ends the process
@pytest.mark.parametrize(("aircraft", "wind"), [("SGS", "0"), ("minisgs", "0"), ("f15", "40")])
def test_a_ground_trim_that_jsbsim_does_not_survive_is_an_error(aircraft, wind):
    command = [sys.executable, "-c", GROUND, aircraft, wind]
    done = subprocess.run(command, capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip(), done.stderr) == (0, "no convergence", "")


@pytest.mark.parametrize(
    ("aircraft", "condition"),
    [
        ("Short_S23", {"altitude": 2000, "mach": 1.88, "mode": "turn", "bank": 30}),
        ("c172p", {"altitude": 30000, "speed": 450}),
    ],
)
def test_propellers_beyond_mach_1_are_refused_before_the_search(monkeypatch, aircraft, condition):
    monkeypatch.setattr(search, "messages", None)
    with pytest.raises(TrimError) as error:
        found(aircraft, **condition)
    assert error.value.reason == "mach"


def test_a_model_without_alpha_limits_has_those_of_jsbsims_trim():  # FGTrimAxis.cpp
    with pytest.raises(TrimError) as error:
        found("A4", altitude=5000, speed=60, solver="jsbsim")
    assert "[-5, 20] deg" in str(error.value)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("altitude", -2000, 278_386),  # where the US Standard Atmosphere, 1976 ends
        ("speed", 1e-9, 2000),
        ("mach", 1e-9, 30),
        ("gamma", -90, 90),
        ("bank", -89, 89),
        ("gear", 0, 1),
        ("flaps", 0, 1),
        ("alpha_min", -90, 90),
        ("alpha_max", -90, 90),
    ],
)
def test_the_range_of_a_condition(name, low, high):
    for limit, beyond in ((low, low - 0.5), (high, high + 0.5)):
        assert getattr(TrimCondition(mode="turn", **{name: limit}), name) == limit
        with pytest.raises(ParameterError) as error:
            TrimCondition(mode="turn", **{name: beyond})
        assert error.value.parameter == name


@pytest.mark.parametrize(
    ("values", "parameter"),
    [
        ({"speed": 0}, "speed"),
        ({"mach": 0}, "mach"),
        # JSBSim flies higher than the air reaches, but without a trim
        ({"altitude": 1e6, "mode": "ground"}, "altitude"),
        ({"altitude": 2e9, "mode": "none"}, "altitude"),
        ({"bank": 30}, "bank"),
        ({"load_factor": 2}, "load_factor"),
        ({"payload": [-1]}, "payload[0]"),
        ({"fuel": {"left": 3}}, "fuel index"),
        ({"fuel": {-1: 3.0}}, "fuel index"),
        ({"fuel": 100}, "fuel"),
        ({"alpha_min": 5, "alpha_max": 1}, "alpha_min"),
        ({"setup": ["a"]}, "setup"),
        ({"engines_off": "both"}, "engines_off"),
        ({"engines_off": b"x"}, "engines_off"),
        ({"engines_off": 1}, "engines_off"),
        ({"engines_off": [-1]}, "engines_off"),
        ({"engines_off": [1], "solver": "jsbsim"}, "solver"),
        ({"free": "alpha"}, "free"),
        ({"free": "gamma"}, "free"),
        ({"throttle": 2.0}, "throttle"),
        ({"throttle": 0.5, "thrust": 100.0}, "throttle"),
        ({"throttle": 0.5, "free": "throttle"}, "free"),
        ({"mode": "glide", "throttle": 0.5}, "throttle"),
        ({"mode": "glide", "solver": "jsbsim"}, "solver"),
        ({"mode": "none", "solver": "newton"}, "solver"),
        ({"mode": "turn", "bank": 10, "beta": 3.0}, "beta"),
    ],
)
def test_impossible_conditions_and_contradictions_are_refused(values, parameter):
    with pytest.raises(ParameterError) as error:
        TrimCondition(**values)
    assert error.value.parameter == parameter
    assert TrimCondition(altitude=1e9, mode="none").altitude == 1e9


def test_conditions_and_states_are_values():
    condition = TrimCondition(
        altitude=1000, speed=80, mode="none", payload=[10.0], setup={"fcs/flap-cmd-norm": 1.0}
    )
    same = TrimCondition(
        altitude=1000, speed=80, mode="none", payload={0: 10.0}, setup={"fcs/flap-cmd-norm": 1.0}
    )
    assert hash(condition) == hash(same)
    assert len({condition, same, TrimCondition()}) == 2
    for twin in (copy.deepcopy(condition), pickle.loads(pickle.dumps(condition))):
        assert twin == condition
        with pytest.raises(TypeError):
            twin.setup["fcs/flap-cmd-norm"] = 0.0
        with pytest.raises(dataclasses.FrozenInstanceError):
            twin.altitude = 0.0
    assert dataclasses.asdict(condition)["payload"] == {0: 10.0}
    state = trim(Airframe("c172p"), condition)
    data = dataclasses.asdict(state)
    assert data["condition"] == dataclasses.asdict(condition)
    assert json.loads(json.dumps(data["condition"]["setup"])) == {"fcs/flap-cmd-norm": 1.0}
    assert hash(state) == hash(copy.deepcopy(state))


def test_the_setup_of_a_block_is_written_after_that_of_its_condition():
    def start(setup, more=None):
        at = {"altitude": 1000, "speed": 80, "mode": "none"}
        return Aircraft("c172p", condition=TrimCondition(**at, setup=setup), setup=more)

    plane = start({"ic/lat-geod-deg": 10.0}, {"ic/lat-geod-deg": 30.0})
    assert plane.outputs["lat"] == pytest.approx(30.0)
    # two names of one latitude: the first does not act
    twice = {"ic/lat-geod-deg": 10.0, "ic/lat-geod-rad": math.radians(20.0)}
    for setups in ([twice], ({"ic/lat-geod-deg": 10.0}, {"ic/lat-geod-rad": math.radians(20.0)})):
        with pytest.raises(ParameterError) as error:
            start(*setups)
        assert error.value.value == "ic/lat-geod-deg"


def test_every_quantity_has_a_unit():
    names = {f.name for kind in (TrimCondition, TrimState) for f in dataclasses.fields(kind)}
    assert set(UNITS) == names - {
        "aircraft",
        "condition",
        "setup",
        "free",
        "solver",
        "drift",
        "coordinated",
    }


def test_a_state_as_a_dict_and_as_a_table():
    found = trim(Airframe("737"), TrimCondition(altitude=15000, speed=280, gear=1))
    numbers = found.to_dict()
    assert numbers["alpha"] == found.alpha
    assert [numbers["throttle[0]"], numbers["throttle[1]"]] == list(found.throttle)
    table = found.to_frame()
    assert table.loc["alpha", "unit"] == "deg"
    assert table.loc["throttle[1]", "unit"] == "norm"
    assert table["value"].to_dict() == numbers


def test_a_failed_search_with_an_infinite_property_warns_of_nothing():
    # the air-fuel ratio of an engine that burns nothing
    with pytest.raises(TrimError):
        trim(Airframe("p51d"), TrimCondition(altitude=5000, speed=40), hint=False)


def test_an_airframe_that_was_trimmed_can_be_freed():
    airframe = Airframe("737")
    trim(airframe, TrimCondition(altitude=15000, speed=280, gear=0, solver="newton"))
    gone = weakref.ref(airframe)
    del airframe
    gc.collect()
    assert gone() is None


@pytest.mark.parametrize(
    "field", sorted(set(UNITS) & {f.name for f in dataclasses.fields(TrimState)})
)
def test_every_field_of_a_state_is_checked(monkeypatch, field):
    airframe, condition = Airframe("c172p"), TrimCondition(altitude=5000, speed=90, mode="none")
    fine = trim(airframe, condition)
    broken = (math.nan,) if field == "throttle" else math.inf
    monkeypatch.setattr(
        trimmer,
        "read_state",
        lambda *_: dataclasses.replace(fine, **{field: broken}),
    )
    with pytest.raises(TrimError, match=f"{field} not finite after the trim"):
        trim(Airframe("c172p"), condition)
