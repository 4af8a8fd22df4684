"""Parameters of an aircraft that are set while it flies: checked at once, flown from its next reset."""

import math
import warnings

import numpy as np
import pytest
from models_from_outside import changed
from pathsim import Connection, Simulation
from pathsim.blocks import Constant

from pathsim_jsbsim_blocks import (
    Aircraft,
    AircraftError,
    BlocksError,
    DoubletSource,
    JSBSimFDM,
    LinearAircraft,
    ParameterError,
    TrimCondition,
    TrimError,
    fly,
)
from pathsim_jsbsim_blocks.catalogue import load_diagram

pytestmark = pytest.mark.matrix

LEVEL = {"altitude": 5000, "speed": 90}
NAN = math.nan

# what the constructors refuse, of Aircraft and under the names of JSBSimFDM
REFUSED = [
    ("speed", "foo"),
    ("speed", 20),  # no trim
    ("speed", np.array([90.0, 95.0])),
    ("altitude", None),
    ("altitude", 1e7),
    ("gamma", 91.0),
    ("heading", math.inf),
    ("mode", "levl"),
    ("gear", 7),
    ("flaps", "full"),
    ("aircraft", "nope"),
    ("aircraft", "L17"),  # which needs a property from outside
    ("root", "/nowhere"),
    ("T", 0.5),
    ("T", "fast"),
    ("substeps", 2.5),
    ("substeps", 10**6),
    ("condition", {"speed": 90}),
    ("condition", TrimCondition(speed=95)),  # beside the other parameters
    ("setup", {"fuel": 10.0}),
    ("properties", {"atmosphere/turb-type": NAN}),
    ("create", {"fcs/flaps-pos-deg": "x"}),
    ("integrators", "exact"),
    ("planet", "Mars"),
    ("gravity", "none"),
    ("allow_network", "no"),
    ("allow_files", 1),
    ("flightgear", 5550),
    ("input_properties", ["fcs/flap-cmd-norm"]),
    ("output_properties", "alpha"),
    ("sink_max", -1.0),
    ("scrape_max", "deep"),
    ("solver", "fast"),
    ("latitude", 91.0),
    ("mach", 0.0),
]
NAMES = {"aircraft": "aircraft_model", "root": "JSBSim_path"}
NAMES |= {name: f"trim_{name}" for name in ("altitude", "gamma", "heading", "mode")}
NAMES["speed"] = "trim_airspeed"


def flying(plane):
    source = DoubletSource(amplitude=0.02, start=0.1, width=0.1)
    return Simulation([plane, source], [Connection(source, plane["elevator"])], dt=plane.T, log=0)


def test_a_new_speed_says_once_that_it_acts_at_the_next_reset():
    plane = Aircraft("c172p", **LEVEL)
    sim = flying(plane)
    fly(sim, 0.1)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        plane.speed = 110
        plane.set(speed=105, altitude=4000)
        plane.heading = 30
    assert [str(w.message) for w in caught] == [
        "plane.speed = 110 acts at the next reset: sim.reset(), sim.run(..., reset=True), "
        "or Run in PathView"
    ]
    assert caught[0].filename == __file__
    fly(sim, 0.1)
    assert plane.outputs["vc"] == pytest.approx(90, abs=0.5)
    sim.reset()
    assert plane.outputs["vc"] == pytest.approx(105, abs=0.5)
    assert plane.outputs["h"] == pytest.approx(4000, abs=0.5)
    assert plane.outputs["psi"] == pytest.approx(30, abs=1e-9)
    with pytest.warns(RuntimeWarning, match="plane.speed = 95 acts at the next reset"):
        plane.speed = 95


def test_nothing_is_said_where_the_flight_has_the_value_or_a_script_is_set():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plane = Aircraft("c172p", **LEVEL)
        plane.speed = 90
        sim = flying(plane)
        fly(sim, 0.1)
        sim.reset()
        diagram = load_diagram("pitch_hold", {"aircraft.speed": 95.0})
        fly(diagram.sim, 0.1)
    assert diagram.aircraft.outputs["vc"] == pytest.approx(95, abs=0.5)


def motion(plane, k):
    u = [0.02, 0.01, *(len(plane.inputs) - 2) * [0.0]]
    return [plane.advance(i, u) for i in range(k, k + 30)]


def refusals(plane, other, values):
    """What is refused is refused as by the constructor, and changes nothing of the flight."""
    expected = motion(other, 1) + motion(other, 31)
    flight = motion(plane, 1)
    for name, bad in values:
        before = getattr(plane, name)
        with pytest.raises(BlocksError) as error:
            setattr(plane, name, bad)
        assert getattr(plane, name) is before, name
        if name != "input_properties":  # the ports cannot change
            with pytest.raises(type(error.value)) as built:
                type(plane)(**{**parameters(plane), name: bad})
            assert str(built.value) == str(error.value)
    assert flight + motion(plane, 31) == expected
    plane.reset()
    assert motion(plane, 1) == expected[:30]


def parameters(plane):
    names = [*NAMES, *NAMES.values()]
    return {n: getattr(plane, n) for n in names if n in type(plane).__dataclass_fields__}


@pytest.mark.filterwarnings("error")
def test_what_the_constructor_refuses_is_refused_when_it_is_set():
    refusals(Aircraft("c172p", **LEVEL), Aircraft("c172p", **LEVEL), REFUSED)


@pytest.mark.filterwarnings("error")
def test_and_of_the_fdm():
    def fdm():
        ports = {"input_properties": ["fcs/elevator-cmd-norm", "fcs/aileron-cmd-norm"]}
        ports["output_properties"] = ["attitude/theta-deg"]
        flight = {"trim_airspeed": 90, "trim_altitude": 5000}
        return JSBSimFDM(1 / 120, **ports, aircraft_model="c172p", **flight)

    known = {NAMES.get(n, n): n for n, _ in REFUSED}
    kept = [n for n in known if n in JSBSimFDM.__dataclass_fields__]
    values = [(NAMES.get(n, n), x) for n, x in REFUSED if NAMES.get(n, n) in kept]
    assert len(values) > 28
    refusals(fdm(), fdm(), values)


def test_values_that_fit_together_only_are_set_together():
    plane = Aircraft("c172p", **LEVEL)
    with pytest.raises(TrimError):
        plane.aircraft = "737"
    with pytest.warns(RuntimeWarning, match="acts at the next reset"):
        plane.set(aircraft="737", altitude=20000, speed=280, gear=0.0)
    with pytest.raises(ParameterError):  # one that is right beside one that is not
        plane.set(altitude=15000, gear=2.0)
    assert (plane.airframe.aircraft, plane.altitude) == ("c172p", 20000)
    plane.reset()
    assert (plane.airframe.aircraft, plane.trim.altitude) == ("737", pytest.approx(20000))


def test_a_linear_aircraft_refuses_what_it_cannot_take():
    plane = LinearAircraft("c172p", **LEVEL, method="algebraic")
    plane.altitude = 5000  # as it is
    for name, bad in [*REFUSED, ("altitude", 3000)]:
        if name in LinearAircraft.__dataclass_fields__:
            before = getattr(plane, name)
            with pytest.raises(ParameterError) as error:
                setattr(plane, name, bad)
            assert error.value.parameter == name
            assert getattr(plane, name) is before


def test_a_reset_that_fails_leaves_the_flight_as_it_was(tmp_path):
    def diagram():
        plane, kick = Aircraft("c172p", **LEVEL, root=root), Constant(0.02)
        wires = [Connection(kick, plane["elevator"], plane["aileron"])]
        sim = Simulation([plane, kick], wires, dt=1 / 120, log=False)
        sim.run(0.5)
        return sim, plane

    def shown(sim, plane):
        sim.run(0.5)
        return [plane.outputs[name] for name in ("h", "theta", "phi", "psi", "elev_sat")]

    root, model = changed(tmp_path, "c172p"), tmp_path / "aircraft/c172p/c172p.xml"
    (sim, plane), other = diagram(), diagram()
    text, trim = model.read_text(), plane.trim
    model.write_text(text.replace("</fdm_config>", ""))
    for _ in range(2):
        with pytest.raises(AircraftError):
            sim.reset()
    # PathSim's clock is at 0 then, and the aircraft where it was
    assert (sim.time, plane.trim) == (0.0, trim)
    assert shown(sim, plane) == shown(*other)
    assert shown(sim, plane) == shown(*other)
    model.write_text(text)
    sim.reset()
    assert shown(sim, plane) == shown(other[0].reset() or other[0], other[1])
