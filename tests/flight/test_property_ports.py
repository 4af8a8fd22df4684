"""Properties of JSBSim as further ports of `Aircraft`: flaps, gear, single engines, any other."""

import sys

import numpy as np
import pytest
from how_many import first
from pathsim.blocks import Constant, Source, StepSource
from plain_jsbsim import FLIGHTS, fly, trimmed
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, ParameterError, PropertyError
from pathsim_jsbsim_blocks import fly as run
from pathsim_jsbsim_blocks._core.aircraft_ports import SHORT_INPUTS, SHORT_OUTPUTS

T = 1 / 120
ALTITUDE, SPEED = FLIGHTS["737"]
THRUSTS = [f"propulsion/engine[{i}]/thrust-lbs" for i in (0, 1)]


def airliner(**options):
    return Aircraft("737", altitude=ALTITUDE, speed=SPEED, gear=0.0, solver="jsbsim", **options)


def flown(plane, wires, shown, duration):
    """Outputs of a flight with sources at ports."""
    sim, scope = diagram(plane, shown, wires)
    run(sim, duration)
    return scope.read()[1]


def test_the_flight_is_bit_for_bit_that_of_a_plain_loop():
    setup = {"gear/gear-cmd-norm": 0.0}
    fdm = trimmed("737", ALTITUDE, SPEED, setup=setup)
    written = ["fcs/flap-cmd-norm", "fcs/throttle-cmd-norm[1]", "fcs/throttle-cmd-norm"]
    read = ["attitude/phi-deg", "fcs/flap-pos-norm", *THRUSTS]
    rng = np.random.default_rng(2)
    flaps, right, both = rng.uniform(0.1, 0.6, 240), *rng.uniform(-0.05, 0.05, (2, 240))
    at = lambda x: Source(lambda t: x[min(round(t / T), 239)])  # noqa: E731
    plane = airliner(
        input_properties=["flaps", "throttle[1]"],
        output_properties=["flaps", "propulsion/engine/thrust-lbs", "thrust[1]"],
    )
    throttle = plane.trim.throttle
    commands = np.array([flaps, throttle[1] + both + right, throttle[0] + both]).T
    expected = fly(fdm, written, commands, read)
    data = flown(
        plane,
        {"flaps": at(flaps), "throttle[1]": at(right), "throttle": at(both)},
        ["phi", "flaps", "propulsion/engine/thrust-lbs", "thrust[1]"],
        2.0,
    )
    assert np.array_equal(data.T, expected)
    assert abs(data[2, -1] - data[3, -1]) > 10.0  # lbf


def test_ports_without_a_wire_change_nothing():
    names = [n for n in SHORT_INPUTS if "[" not in n and "_brake" not in n]
    plain = flown(airliner(), {}, ["h", "theta", "vc"], 1.0)
    more = airliner(
        input_properties=[*names, "throttle[0]", "fcs/pitch-trim-cmd-norm"],
        output_properties=[n.replace("[i]", "[0]") for n in SHORT_OUTPUTS],
    )
    assert np.array_equal(flown(more, {}, ["h", "theta", "vc"], 1.0), plain)


def test_inputs_are_increments_on_the_trim_and_limited_to_the_range():
    plane = Aircraft("737", altitude=5000.0, speed=190.0, gear=1.0, input_properties=["gear"])
    flown(plane, {"gear": StepSource(-3.0, 0.1)}, ["h"], 0.2)
    assert plane.fdm["gear/gear-cmd-norm"] == 0.0
    plane = airliner(
        flaps=0.5, input_properties=["flaps", "steering", "brakes", "fcs/speedbrake-cmd-norm"]
    )
    wires = {"flaps": 0.2, "steering": -5.0, "brakes": 0.25, "fcs/speedbrake-cmd-norm": 2.0}
    flown(plane, {port: Constant(x) for port, x in wires.items()}, ["h"], 0.1)
    assert plane.fdm["fcs/flap-cmd-norm"] == pytest.approx(0.7)
    assert plane.fdm["fcs/steer-cmd-norm"] == -1.0
    assert plane.fdm["fcs/speedbrake-cmd-norm"] == 1.0
    sides = ("left", "right", "center")
    assert [plane.fdm[f"fcs/{side}-brake-cmd-norm"] for side in sides] == [0.25] * 3


@pytest.mark.parametrize("method", first(["algebraic", "flown"]))
def test_a_linear_model_shows_the_further_outputs_and_moves_the_fixed_inputs(method):
    plane = Aircraft(
        "737",
        altitude=ALTITUDE,
        speed=SPEED,
        gear=0.0,
        input_properties=["flaps"],
        output_properties=["velocities/u-fps", "gear"],
    )
    model = plane.linear_model(method)
    assert model.inputs == ("elevator", "aileron", "rudder", "throttle")
    assert model.outputs[-2:] == ("velocities/u-fps", "gear")
    # u = V cos(alpha) in symmetric flight
    u, vt = model.outputs.index("velocities/u-fps"), model.outputs.index("vt")
    x = [model.states.index("vt")]
    assert model.C[u, x] == pytest.approx(
        model.C[vt, x] * np.cos(np.radians(plane.trim.alpha)), rel=0.01
    )
    assert not model.C[-1].any()
    if method == "flown":
        _, B, C, D = plane.to_statespace(0.0)
        assert (B.shape[1], C.shape[0], D.shape) == (8, 24, (24, 8))
        assert not B[:, 7].any()


@pytest.mark.parametrize(
    ("name", "instead"),
    [
        ("fcs/throttle-cmd-norm[2]", ""),
        # JSBSim would start the engines again at every sample
        ("propulsion/set-running", ""),
        # JSBSim integrates these
        ("position/h-sl-ft", "altitude, latitude and longitude"),
        ("position/long-gc-rad", "altitude, latitude and longitude"),
        # only at the start of a flight
        ("ic/h-sl-ft", "setup={'ic/h-sl-ft': value}"),
    ],
)
def test_what_cannot_be_an_input_is_refused_when_the_block_is_built(name, instead):
    with pytest.raises(PropertyError) as error:
        airliner(input_properties=[name])
    assert error.value.name == name
    assert instead in str(error.value)


@pytest.mark.parametrize(
    ("options", "both"),
    [
        ({"input_properties": ["fcs/elevator-cmd-norm"]}, ["elevator"]),
        ({"input_properties": ["atmosphere/gust-down-fps"]}, ["wind_down"]),
        ({"input_properties": ["left_brake", "brakes"]}, ["brakes", "left_brake"]),
        (
            {"input_properties": ["throttle[0]", "fcs/throttle-cmd-norm"]},
            ["fcs/throttle-cmd-norm", "throttle[0]"],
        ),
        ({"output_properties": ["gear", "gear"]}, ["gear"]),
    ],
)
def test_two_ports_of_one_property_are_refused_by_name(options, both):
    with pytest.raises(ParameterError) as error:
        airliner(**options)
    assert error.value.parameter == next(iter(options))
    assert all(repr(name) in str(error.value) for name in both)


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        ("velocities/p-rad_sec", "Other properties are ports with input_properties=[...]"),
        ("h_agl", "'h_agl' is one with output_properties=['h_agl']"),
        ("flaps", "'flaps' is one with input_properties=['flaps'] or output_properties=['flaps']"),
    ],
)
def test_a_property_that_is_no_port_yet_is_refused(name, hint):
    with pytest.raises(ParameterError) as error:
        airliner()[name]
    assert (error.value.parameter, error.value.value) == ("port", name)
    assert hint in str(error.value)


@pytest.mark.parametrize(
    ("ports", "wrong", "right"),
    [
        ("input_properties", "flap", "flaps"),
        ("output_properties", "thrst[0]", "thrust[i]"),
    ],
)
def test_a_misspelt_port_suggests_short_names_too(ports, wrong, right):
    with pytest.raises(PropertyError) as error:
        airliner(**{ports: [wrong]})
    assert error.value.nearest[0] == right


def test_an_input_that_can_only_be_written_is_0_at_the_trim():
    ports = ["fcs/elevator-cmd-norm", "propulsion/magneto_cmd"]
    block = JSBSimFDM(
        aircraft_model="c172p", input_properties=ports, trim_airspeed=90, trim_altitude=5000
    )
    assert block.trimmed_inputs() == [block.fdm["fcs/elevator-cmd-norm"], 0.0]


TANK = "propulsion/tank[0]/contents-lbs"


def burnt(increment):
    """Fuel of an aircraft's first tank after a pulse on it, lb: each second for 8 s."""
    plane = Aircraft("c172p", altitude=5000, speed=90, input_properties=[TANK])
    pulse = Source(lambda t: increment if 1 <= t < 2.5 else 0.0)
    sim, _ = diagram(plane, sources={TANK: pulse})
    contents = []
    for _ in range(8):
        sim.run(1.0)
        contents.append(plane.fdm[TANK])
    return np.array(contents)


@pytest.mark.parametrize(
    ("increment", "during"),
    [(-5.0, -5.0), (3.0, 3.0), (1e4, None)],
    ids=["less", "more", "beyond full"],
)
def test_an_increment_on_what_the_model_moves_is_neutral_when_it_is_0_again(increment, during):
    usual, pulsed = burnt(0.0), burnt(increment)
    assert np.diff(usual).max() < 0.0
    if during is not None:
        assert pulsed[1] - usual[1] == pytest.approx(during, abs=1e-6)
        # the weight changes the consumption a little for the time of the pulse
        assert pulsed[2:] - usual[2:] == pytest.approx(0.0, abs=1e-3)
    # the tank burns on
    assert np.diff(pulsed[2:]) == pytest.approx(np.diff(usual[2:]), rel=0.01)


def test_on_a_property_that_stays_the_sum_is_bit_for_bit_start_and_increment():
    name = "inertia/pointmass-weight-lbs[1]"
    plane = Aircraft("c172p", speed=90.0, properties={name: 0.1}, input_properties=[name])
    numbers = [0.0, 0.1, 0.1, 0.30000000000000004, -0.05, 0.7, 0.0, 0.2]
    for index, increment in enumerate(numbers, 1):
        plane.advance(index, [0.0] * 7 + [increment])
        assert plane.fdm[name] == 0.1 + increment


def interrupted_at(line, plane, index, row):
    """A period with Ctrl-C at a line of `_Further.move`, and again; whether there is such a line."""

    def trace(frame, event, argument):
        nonlocal line
        if frame.f_code.co_name == "move":
            line -= event == "line"
            if line == 0:
                line = -1
                raise KeyboardInterrupt
        return trace

    sys.settrace(trace)
    try:
        plane.advance(index, row)
    except KeyboardInterrupt:
        sys.settrace(None)
        plane.advance(index, row)
    finally:
        sys.settrace(None)
    return line < 0


def test_ctrl_c_while_an_increment_is_written_counts_it_once():
    def flight(line):
        plane, struck = Aircraft("c172p", speed=90.0, input_properties=[TANK]), False
        for index, x in enumerate((0.0, 0.0, -4.0, -4.0, 1.0, 0.0, 0.0), 1):
            row = [0.0] * 7 + [x]
            if index in (3, 5, 6) and line:
                struck |= interrupted_at(line, plane, index, row)
            else:
                plane.advance(index, row)
        return struck, plane.fdm[TANK], plane.fdm["attitude/theta-rad"]

    _, *whole = flight(0)
    struck, line = True, 0
    while struck:
        line += 1
        struck, *end = flight(line)
        assert end == whole
    assert line > 8
