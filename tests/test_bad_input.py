"""Bad input is refused at once, by a typed error that names the nearest right thing."""

import math
import re
import warnings

import numpy as np
import pytest
from models_from_outside import changed
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope, Source

from pathsim_jsbsim_blocks import (
    Aircraft,
    AircraftError,
    Autopilot,
    BlocksError,
    DoubletSource,
    FlightError,
    ISAtmosphere,
    JSBSimFDM,
    OneMinusCosineGust,
    ParameterError,
    PitchHold,
    PropertyError,
    RollHold,
    TrimCondition,
    TrimError,
    fly,
)
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.linear import flying_qualities
from pathsim_jsbsim_blocks.studies import trim_sweep

pytestmark = pytest.mark.matrix

NAN = math.nan


def fdm(**keywords):
    """A c172p that trims, but for the keywords given."""
    if "condition" not in keywords:
        keywords = {"trim_airspeed": 90, "trim_altitude": 5000, **keywords}
    return JSBSimFDM(**{"aircraft_model": "c172p", **keywords})


def outputs(*names):
    return {"output_properties": list(names)}


def inputs(*names):
    return {"input_properties": list(names)}


THETA, THROTTLE = "attitude/theta-deg", "fcs/throttle-cmd-norm"
MASS, TANK = "inertia/pointmass-weight-lbs", "propulsion/tank"
RATE, AB3 = "rate_rotational", "adams-bashforth 3"
AT_RATE = f"integrators['{RATE}']"
LEVEL = TrimCondition(speed=90)

VALUES = {  # of parameters by themselves
    "JSBSim_path": [5],
    "output_properties": [[THETA, THETA], THETA],
    "input_properties": [[THROTTLE, f"{THROTTLE}[0]"], 3, [1]],
    "T": [0, 10**400, 1e-300],
    "substeps": [0, 1.5],
    "trim_airspeed": [0],
    "trim_altitude": [1e9],
    "trim_gamma": [100],
    "gear": ["up"],
    "flaps": [30],
    "condition": [{"altitude": 5000}],
    "integrators": ["fast"],
    "planet": [6371.0, {"semiminor_axis": 3e7}],  # that is above the semimajor axis
    "setup": [[("fcs/elevator-cmd-norm", 0.1)]],
    "properties": ["turbulence"],
    "create": [["a"]],
    "allow_network": ["no"],
}
OTHER_NAMES = {"JSBSim_path": "root", "trim_airspeed": "speed"}


@pytest.mark.parametrize(("name", "value"), [(n, x) for n, xs in VALUES.items() for x in xs])
def test_a_bad_value_is_refused_when_the_block_is_built(name, value):
    with pytest.raises(ParameterError) as error:
        fdm(**{name: value})
    assert error.value.parameter == OTHER_NAMES.get(name, name.removeprefix("trim_"))
    assert error.value.value == value


# keywords; what the error says is at fault: a value of a parameter, a property or an aircraft; a name
# that it must offer
NAMES = [
    ({"substeps": 10**30}, ("T / substeps", 1 / 120e30), ""),
    ({"condition": LEVEL, "trim_airspeed": 90}, ("trim_airspeed", 90), ""),
    # more fuel than the tank holds
    ({"condition": TrimCondition(speed=90, fuel=[100, 1000])}, ("setup", 1000.0), ""),
    ({"trim_mode": "longitudnal"}, ("mode", "longitudnal"), "longitudinal"),
    ({"gravity": "point"}, ("gravity", "point"), "point mass"),
    ({"planet": "WGS84"}, ("planet", "WGS84"), "WGS-84"),
    ({"planet": {"gm": 1.0}}, ("planet key", "gm"), ""),
    ({"planet": {"GM": 0}}, ("planet['GM']", 0), ""),
    ({"integrators": {"rotational_rate": "x"}}, ("integrators key", "rotational_rate"), RATE),
    ({"integrators": {RATE: "adams bashforth 3"}}, (AT_RATE, "adams bashforth 3"), AB3),
    ({"integrators": {RATE: "buss 2"}}, (AT_RATE, "buss 2"), ""),  # JSBSim throws at the first step
    ({"setup": {THROTTLE: "up"}}, (f"setup['{THROTTLE}']", "up"), ""),
    ({"aircraft_model": "C172P"}, "C172P", "c172p"),
    ({"aircraft_model": "f-16"}, "f-16", "f16"),
    ({"aircraft_model": "../c172p"}, "../c172p", "c172p"),
    ({"aircraft_model": "a" * 5000}, "a" * 5000, ""),
    ({"aircraft_model": 172}, "172", ""),
    ({"aircraft_model": "blank"}, "blank", ""),
    ({"JSBSim_path": "/nowhere"}, "c172p", ""),
    (inputs("fcs/elevator-cmd-nrm"), "fcs/elevator-cmd-nrm", "fcs/elevator-cmd-norm"),
    (outputs("theta-deg"), "theta-deg", THETA),
    (outputs("attitude"), "attitude", "attitude/phi-deg"),
    (outputs("propulsion/engine[0]"), "propulsion/engine[0]", "propulsion/engine/AFR"),
    (inputs(THETA), THETA, "ic/theta-deg"),  # cannot be written
    (outputs("simulation/do_simple_trim"), "simulation/do_simple_trim", ""),
    (inputs("simulation/pause"), "simulation/pause", ""),  # would stop the aircraft's clock
    ({"condition": TrimCondition(payload={9: 1})}, f"{MASS}[9]", f"{MASS}[4]"),
    # JSBSim would take the index modulo 2**32 and write to point mass 0
    ({"condition": TrimCondition(payload={2**32: 1})}, f"{MASS}[{2**32}]", ""),
    ({"setup": {f"{TANK}/content-lbs": 1}}, f"{TANK}/content-lbs", f"{TANK}/contents-lbs"),
    ({"properties": {THETA: 3}}, THETA, ""),
    ({"create": {THETA: 3}}, THETA, ""),
    ({"create": {"a b": 3}}, "a b", ""),
    ({"create": {"": 3}}, "", ""),
]


@pytest.mark.parametrize(("keywords", "fault", "offered"), NAMES)
def test_an_error_carries_what_is_at_fault_and_the_nearest_right_name(keywords, fault, offered):
    with pytest.raises(BlocksError) as caught:
        fdm(**keywords)
    error = caught.value
    if isinstance(error, ParameterError):
        assert (error.parameter, error.value) == (fault[0], pytest.approx(fault[1]))
        nearest = str(error).partition("did you mean")[2]
        assert repr(offered) in nearest or not offered
    else:
        assert getattr(error, "name", error.aircraft) == fault
        assert offered in error.nearest or not offered


def test_an_aircraft_in_the_place_of_the_sample_period_is_recognised():
    with pytest.raises(ParameterError, match=re.escape("aircraft_model='pa28'")) as error:
        JSBSimFDM("pa28")
    assert (error.value.parameter, error.value.value) == ("T", "pa28")


def test_a_model_that_lacks_a_property_names_it():
    with pytest.raises(AircraftError) as error:
        fdm(aircraft_model="L17")
    assert error.value.missing == ("fcs/flaps-pos-deg",)


@pytest.mark.parametrize(
    ("keywords", "reason", "text"),
    [
        ({"altitude": 5000, "speed": 10}, "no convergence", "the search did not converge"),
        ({"altitude": 5000, "speed": 45}, "alpha limit", "alpha reached the end of"),
        ({"altitude": 5000, "speed": 90, "gamma": 20}, "thrust", "gamma=20.0"),
    ],
)
def test_no_trim_says_which_limit_was_hit(keywords, reason, text):
    with pytest.raises(TrimError, match=re.escape(text)) as error:
        Aircraft("c172p", **keywords)
    assert error.value.reason == reason
    assert error.value.aircraft == "c172p"
    assert error.value.condition.altitude == 5000


# reading a property by one of these names in plain JSBSim aborts the process (but for the last four)
SPELLINGS = "1abc|a b|a[x]|a:b|a[|a]|a[-1]|höhe|attitude/theta-deg |-attitude/theta-deg|%s|a/1|-x"
MALFORMED = [*SPELLINGS.split("|"), "\0", "attitude/theta-deg\0", "\ud800"]


@pytest.mark.parametrize("name", MALFORMED)
def test_a_malformed_name_is_a_typed_error_however_it_comes(name):
    airframe = Airframe("c172p")
    assert not airframe.has(name)
    for use in (
        lambda: airframe.reader(name),
        lambda: airframe.writer(name),
        lambda: airframe.access(name),
        lambda: airframe.canonical(name),
        lambda: airframe.write({name: 1.0}),
        lambda: trim(airframe, TrimCondition(speed=90, setup={name: 1.0})),
        lambda: fdm(**inputs(name)),
        lambda: fdm(**outputs(name)),
    ):
        with pytest.raises(PropertyError) as error:
            use()
        assert (error.value.aircraft, error.value.name) == ("c172p", name)
        assert "theta-deg" not in name or error.value.nearest[0] == THETA


def test_other_spellings_of_a_property_are_the_property():
    reference = float(fdm(**outputs(THETA)).outputs[0])
    for name in ("attitude//theta-deg", "attitude/../attitude/theta-deg", f"/fdm/jsbsim/{THETA}"):
        assert float(fdm(**outputs(name)).outputs[0]) == reference


def test_ports_that_do_not_exist():
    block = fdm(**inputs("fcs/elevator-cmd-norm"), **outputs(THETA, "aero/alpha-deg"))
    for key in (2, slice(0, 3), (0, 7)):
        with pytest.raises(ParameterError) as error:
            block[key]
        assert error.value.parameter == "port"


def test_ports_of_the_wrong_direction():
    block = fdm(**inputs("fcs/elevator-cmd-norm"), **outputs(THETA, "aero/alpha-deg"))
    with pytest.raises(ValueError, match=f"Input port '{THETA}' not defined"):
        Connection(Constant(0.1), block[THETA])
    # PathSim lets an input register grow
    source = Constant(0.1)
    sim = Simulation([source, block], [Connection(source, block[1])], dt=block.T, log=False)
    with pytest.raises(ParameterError) as error:
        sim.run(0.1)
    assert (error.value.parameter, error.value.value) == ("inputs", 2)


@pytest.mark.parametrize("value", [NAN, -math.inf])
@pytest.mark.parametrize(
    "make",
    [
        lambda: fdm(**inputs("fcs/elevator-cmd-norm"), **outputs(THETA)),
        lambda: Aircraft("c172p", speed=90),
    ],
    ids=["JSBSimFDM", "Aircraft"],
)
def test_an_input_that_is_not_finite_ends_the_flight(make, value):
    block, scope, level = make(), Scope(), value
    source = Source(lambda t: level if t > 0.999 else 0.01)
    *_, port = block.inputs._mapping  # the last, which is a wind of Aircraft
    wires = [Connection(source, block[port]), Connection(block[0], scope)]
    sim = Simulation([source, block, scope], wires, dt=block.T, log=False)
    with pytest.raises(FlightError, match=r"aircraft 'c172p': input .* at t = 1 s") as error:
        sim.run(2.0)
    assert error.value.name == port
    assert error.value.time == pytest.approx(1.0)
    assert error.value.value == pytest.approx(value, nan_ok=True)
    time, data = scope.read()
    assert time[-1] > 0.99
    assert np.isfinite(data).all()
    level = 0.01
    with pytest.raises(FlightError) as again:  # until a reset
        sim.run(1.0)
    assert (again.value.name, again.value.time) == (error.value.name, error.value.time)


@pytest.mark.parametrize("aircraft", ["f16", "A4"])
def test_ground_impact_ends_the_flight(aircraft):
    # JSBSim's own run() goes on with a state that is not a number
    unlimited = {"sink_max": math.inf, "scrape_max": math.inf}
    plane = Aircraft(
        aircraft, altitude=3000, speed=400, gamma=-80, gear=1, mode="none", **unlimited
    )
    scope = Scope(labels=["h"])
    sim = Simulation([plane, scope], [Connection(plane["h"], scope)], dt=plane.T, log=False)
    with pytest.raises(FlightError, match=f"aircraft '{aircraft}': crashed") as error:
        sim.run(30.0)
    time, (height,) = scope.read()
    # 3000 ft at about 700 ft/s
    assert 3.0 < error.value.time < 6.0
    assert abs(error.value.value) > 50.0
    assert time[-1] == pytest.approx(error.value.time - plane.T)
    assert np.isfinite(height).all()
    assert height[: int(3.0 / plane.T)].min() > 0.0
    # neither forgotten by going on, nor remembered after a reset
    with pytest.raises(FlightError):
        sim.run(1.0)
    sim.run(1.0, reset=True)
    assert len(scope.read()[0]) == 121


@pytest.mark.parametrize("shown", [[], ["simulation/sim-time-sec", "inertia/weight-lbs"]])
def test_a_state_that_is_not_a_number_ends_the_flight_whatever_is_shown(shown):
    block = JSBSimFDM(
        aircraft_model="A4", trim_altitude=3000, trim_airspeed=400, gear=0, output_properties=shown
    )
    sim = Simulation([block], dt=block.T, log=False)
    sim.run(0.5)
    block.fdm["fcs/elevator-cmd-norm"] = math.nan
    with pytest.raises(FlightError) as error:
        sim.run(0.5)
    assert error.value.name == "velocities/vt-fps"
    assert block.samples < 63


@pytest.mark.parametrize(
    ("block", "called", "port"),
    [
        (Aircraft, "Pitch", "'theta'?"),
        (Aircraft, "airspeed", "'vc' or 'vt'?"),
        (Aircraft, "rate of climb", "'hdot'?"),
        (ISAtmosphere, "rho", "'density'?"),
        (ISAtmosphere, "h", "'altitude'?"),
        (lambda: RollHold(gains="c172p"), "roll", "'phi'?"),
    ],
)
def test_a_port_is_found_by_what_it_is_called_elsewhere(block, called, port):
    with pytest.raises(BlocksError, match=re.escape(f"{called!r}; did you mean {port}")):
        block()[called]


def commanded(port, value):
    """A c172p with a constant input, and the simulation of both."""
    plane, source = Aircraft("c172p", altitude=5000, speed=90), Constant(value)
    wires = [Connection(source, plane[port])]
    return plane, Simulation([plane, source], wires, dt=plane.T, log=False)


@pytest.mark.parametrize(("port", "value"), [("rudder", -10.0), ("throttle", 70.0)])
def test_a_command_in_degrees_or_percent_is_told_once(port, value):
    _, sim = commanded(port, value)
    with pytest.warns(RuntimeWarning, match=f"{value:g} at '{port}' exceeds the full") as all_:
        sim.run(0.1)
    sim.reset()
    sim.run(0.05)
    assert len(all_) == 1
    assert all_[0].filename == __file__


@pytest.mark.parametrize(("port", "value"), [("elevator", -1.5), ("throttle", 1.0)])
def test_a_command_beyond_its_stop_is_none_in_degrees(port, value):
    plane, sim = commanded(port, value)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sim.run(0.1)
    assert plane.outputs[{"elevator": "elev_sat", "throttle": "thr_sat"}[port]] != 0.0


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ("</mass_balance>", "</mass_balanc>", "is not well-formed XML: mismatched tag"),
        (r'version="1.0"\?>', 'version="1.0" encoding="nonsense"?>', "not well-formed"),
        ('name="CG" unit="IN"', 'name="CG" unit="MILES"', "unknown unit 'MILES'"),
        ('name="CG" unit="IN"', 'name="X" unit="IN"', "no empty-weight CG"),
        (".*", "", "not well-formed XML: no element found"),
    ],
)
def test_a_malformed_model_with_another_empty_cg(before, after, message, tmp_path):
    root = changed(tmp_path, "c172p", (before, after))
    with pytest.raises(AircraftError, match=re.escape(message)) as error:
        Aircraft("c172p", condition=TrimCondition(speed=90, empty_cg_x=41.0), root=root)
    assert error.value.aircraft == "c172p"
    assert "\n" not in str(error.value)


ONE = {"altitude": [5000], "speed": [90]}


@pytest.mark.parametrize(
    ("call", "parameter"),
    [
        (lambda: Autopilot(pitch_mode=1), "pitch_mode"),  # an input port
        (lambda: Aircraft("c172p", T=120), "T / substeps"),
        (lambda: trim("c172p", LEVEL), "airframe"),
        (lambda: flying_qualities("c172p"), "model"),
        (lambda: fly(PitchHold(), 1.0), "sim"),
        (lambda: TrimCondition(engines_off=np.array([[0, 1]])), "engines_off"),
        (lambda: TrimCondition(engines_off=np.array(["a"])), "engines_off"),
        *(
            (lambda x=x: Aircraft("c172p", speed=90, create=x), "create")
            for x in (np.array([]), np.array([1.0]), 5)
        ),
        *(
            (lambda x=x: Aircraft(altitude=x, condition=LEVEL), "altitude")  # both
            for x in (np.array([1.0, 2.0]), "high", None)
        ),
        # a flag or a sign that is an array or text
        *(
            (lambda call=call, x=x: call(x), parameter)
            for x in (np.array([True, False]), "no")
            for call, parameter in (
                (lambda x: trim(Airframe("c172p"), LEVEL, hint=x), "hint"),
                (lambda x: trim_sweep("c172p", ONE, jobs=1, progress=x), "progress"),
                (lambda x: fly(Simulation(log=False), 1, progress=x), "progress"),
                (lambda x: DoubletSource(polarity=x), "polarity"),
                (lambda x: OneMinusCosineGust(polarity=x), "polarity"),
            )
        ),
    ],
)
def test_an_argument_of_another_kind_is_refused(call, parameter):
    with pytest.raises(ParameterError) as error:
        call()
    assert error.value.parameter == parameter


def test_engines_may_be_given_as_an_array():
    assert TrimCondition(engines_off=np.array([1, 0])) == TrimCondition(engines_off=[0, 1])
    assert TrimCondition(engines_off=np.array([])) == TrimCondition()
