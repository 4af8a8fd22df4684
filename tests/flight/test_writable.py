"""Writing a property never ends the process; values that cannot be are refused, in flight too.

JSBSim throws from some properties as they are written, where Python cannot catch it, and follows a
null pointer after others: before they were refused, these tests ended with SIGABRT or SIGSEGV.
"""

import pytest
from pathsim.blocks import Constant
from plane_diagram import diagram
from written_properties import deaths

from pathsim_jsbsim_blocks import (
    Aircraft,
    FlightError,
    JSBSimFDM,
    ParameterError,
    PropertyError,
    TrimCondition,
)
from pathsim_jsbsim_blocks.flight import Airframe, trim
from pathsim_jsbsim_blocks.studies import trim_sweep

C172P = {"altitude": 5000, "speed": 90}
FDM = {"aircraft_model": "c172p", "trim_altitude": 5000, "trim_airspeed": 90}
PAYLOAD = "inertia/pointmass-weight-lbs[1]"
AXIS = "simulation/integrator/rate/rotational"

WAYS_IN = {
    "setup": lambda name, value: Aircraft("c172p", **C172P, setup={name: value}),
    "properties": lambda name, value: Aircraft("c172p", **C172P, properties={name: value}),
    "create": lambda name, value: Aircraft("c172p", **C172P, create={name: value}),
    "condition": lambda name, value: trim(
        Airframe("c172p"), TrimCondition(**C172P, setup={name: value})
    ),
    "sweep": lambda name, value: trim_sweep(
        "c172p", {**C172P, name: [value]}, jobs=1, progress=False
    ),
    "writer": lambda name, value: Airframe("c172p").writer(name)(value),
}


@pytest.mark.parametrize("name", ["propulsion/set-running", "simulation/do_simple_trim"])
@pytest.mark.parametrize("way", WAYS_IN)
def test_what_would_end_the_process_is_refused(way, name):
    with pytest.raises(PropertyError) as error:
        WAYS_IN[way](name, 1)
    assert error.value.name == name


def test_an_engine_without_a_table_of_injection_has_none():
    with pytest.raises(PropertyError) as error:
        Airframe("B747").write({"propulsion/engine[1]/injection_cmd": 1})
    assert error.value.name == "propulsion/engine[1]/injection_cmd"


@pytest.mark.parametrize(
    ("aircraft", "running"), [("c172p", -1), ("c172p", 0), ("737", 0), ("737", 1)]
)
def test_engines_that_a_model_has_may_be_started(aircraft, running):
    plane = Aircraft(
        aircraft,
        altitude=5000,
        speed=250 if aircraft == "737" else 90,
        gear=1,
        mode="none",
        setup={"propulsion/set-running": running},
    )
    # with a number JSBSim starts that engine only
    alone = [running in (-1, i) for i in range(plane.airframe.engines)]
    names = plane.airframe.of_engines("set-running")
    assert [bool(plane.fdm[name]) for name in names] == alone


@pytest.mark.parametrize(
    ("name", "value", "right"),
    [
        ("simulation/gravity-model", 7, "0 (point mass), 1 (J2)"),
        ("atmosphere/turb-type", 5, "3 (milspec), 4 (tustin)"),
        (AXIS, 99, "1 (euler)"),
        # of a quaternion only: JSBSim throws at the first step
        (AXIS, 7, "1 (euler)"),
        ("propulsion/tank/contents-lbs", -1, "0"),
        # JSBSim makes them all, until the memory is full
        ("atmosphere/updownburst/number-of-cells", 1e9, "1000"),
    ],
)
def test_values_that_cannot_be_are_refused_with_what_can(name, value, right):
    with pytest.raises(ParameterError) as error:
        Airframe("c172p").writer(name)(value)
    assert error.value.value == value
    assert right in str(error.value)


@pytest.mark.parametrize("way", WAYS_IN)
def test_a_value_that_cannot_be_is_refused_however_it_comes(way):
    with pytest.raises(ParameterError) as error:
        WAYS_IN[way](PAYLOAD, -1)
    assert error.value.value == -1


def test_a_refused_value_leaves_the_others_unwritten():
    airframe = Airframe("c172p")
    with pytest.raises(ParameterError):
        airframe.write({"fcs/flap-cmd-norm": 1.0, PAYLOAD: -1.0})
    with pytest.raises(ParameterError):
        airframe.writer_of(["fcs/flap-cmd-norm", PAYLOAD])([1.0, -1.0])
    assert airframe.fdm["fcs/flap-cmd-norm"] == 0.0


@pytest.mark.parametrize(
    ("block", "allowed", "refused"),
    [
        (lambda **k: JSBSimFDM(**FDM, **k), 0.0, -1.0),
        # increments on the weight after the trim
        (lambda **k: Aircraft("c172p", **C172P, setup={PAYLOAD: 100}, **k), -100.0, -101.0),
    ],
)
def test_a_negative_mass_ends_the_flight(block, allowed, refused):
    plane = block(input_properties=[PAYLOAD])
    diagram(plane, sources={PAYLOAD: Constant(allowed)})[0].run(0.1)
    assert plane.fdm[PAYLOAD] == 0.0
    plane.reset()
    sim, _ = diagram(plane, sources={PAYLOAD: Constant(refused)})
    with pytest.raises(FlightError) as error:
        sim.run(0.1)
    assert (error.value.name, error.value.value, error.value.time) == (PAYLOAD, -1.0, 0.0)
    assert plane.fdm[PAYLOAD] >= 0.0


def test_what_jsbsim_throws_in_flight_is_a_flight_error():
    target = "guidance/target_wp_latitude_rad"
    plane = JSBSimFDM(
        aircraft_model="c172x",
        trim_altitude=5000,
        trim_airspeed=103,
        input_properties=[target],
    )
    sim, _ = diagram(plane, sources={target: Constant(2.0)})
    with pytest.raises(FlightError) as error:
        sim.run(0.1)
    assert "waypoint" in str(error.value)


@pytest.mark.long
def test_no_property_of_a_sample_ends_the_process():
    # tests/long has all properties of all models
    sample = "propulsion/(set-running|engine/inj)|simulation/(do_|gravity|integrator)"
    assert deaths("B747", sample) == []
