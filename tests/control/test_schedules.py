"""Gains that follow the airspeed, and references that are absolute."""

from __future__ import annotations

import dataclasses
import warnings

import all_holds
import numpy as np
import pytest
from flights import STATES, start
from hand_tuned import GAINS
from pathsim import Connection, Simulation
from pathsim.blocks import Constant

from pathsim_jsbsim_blocks import ParameterError, PitchHold, RollHold, YawDamper
from pathsim_jsbsim_blocks.control.gains import DesignPoint, GainSchedule

HOLDS = [*all_holds.HOLDS.values()]
N = 400


def scaled(gains, factor):
    """All gains and the highest pitch reference times a factor; the rest as it is."""
    loops = {}
    for loop, part in vars(gains).items():
        if loop != "envelope":
            numbers = {n: factor * x for n, x in vars(part).items() if n[0] == "K"}
            if loop == "altitude":
                numbers["theta_max"] = factor * part.theta_max
            loops[loop] = dataclasses.replace(part, **numbers)
    return dataclasses.replace(gains, **loops)


def between(low, high, name="737"):
    """A schedule from one airspeed to another, with factors on the gains of a table."""
    return GainSchedule(
        name,
        (
            DesignPoint(10_000.0, 200.0, scaled(GAINS[name], low)),
            DesignPoint(10_000.0, 300.0, scaled(GAINS[name], high)),
        ),
        nominal=1,
    )


def outputs(hold, vc, **given):
    """Outputs over random inputs, but for an airspeed and ports with values that are given."""
    rng = np.random.default_rng(3)
    ports = hold.input_port_labels
    u = np.cumsum(rng.normal(size=(N, len(ports))), axis=0)
    # no switches, no saturation, no protection
    u[:, [i for n, i in ports.items() if n.endswith(("_off", "off", "_mode", "_sat", "alpha"))]] = 0
    if "h" in ports:
        u[:, ports["h"]] += 10_000.0
    for name, value in {"vc": vc, **given}.items():
        u[:, ports[name]] = value
    state, y = hold.initial_state(), []
    for row in u.tolist():
        out, state = hold.law(row, state)
        y.append(out)
    return np.array(y)


@pytest.mark.filterwarnings("ignore:FlareHold. no landings")
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize(("vc", "factor"), [(300.0, 1.0), (250.0, 0.75), (180.0, 0.5), (0.0, 1.0)])
def test_a_schedule_at_one_airspeed_is_its_gains_there(hold, vc, factor):
    if hold.__name__ in ("AirspeedHold", "Autopilot", "FlareHold") and vc == 0.0:
        pytest.skip("it always knows the airspeed")
    if hold.__name__ == "FlareHold" and vc == 180.0:
        pytest.skip("below the airspeeds of its gains it flares more slowly")
    followed = outputs(hold(between(0.5, 1.0), T=1 / 20), vc)
    fixed = outputs(hold(scaled(GAINS["737"], factor), T=1 / 20), vc)
    assert np.ptp(fixed[:, 0]) > 0 or hold is YawDamper
    assert followed == pytest.approx(fixed, abs=1e-9)


@pytest.mark.parametrize(("hold", "angle"), [(PitchHold, "theta"), (RollHold, "phi")])
def test_a_change_of_the_airspeed_does_not_move_the_output(hold, angle):
    # at rest at 8 deg; the change of Kp alone would move it by (1 - b) 8 deg dKp, 0.48 and 0.02
    block = hold(between(0.5, 1.0), **{f"{angle}_ref": 8.0})
    ports, u = block.input_port_labels, [0.0] * len(block.input_port_labels)
    u[ports[angle]], u[ports["vc"]] = 8.0, 200.0
    state = block.initial_state()
    for _ in range(200):
        before, state = block.law(u, state)
    u[ports["vc"]] = 300.0
    after, _ = block.law(u, state)
    assert after[0] == pytest.approx(before[0], abs=1e-9)


VALUES = {"theta_ref": 3.0, "phi_ref": 10.0, "psi_ref": 100.0, "h_ref": 10_020.0, "vc_ref": 285.0}
# holds of one reference
REFERENCES = [
    (hold, *ports, VALUES[ports[0]])
    for hold in HOLDS
    if len(ports := [x for x in hold.input_port_labels or () if x.endswith("_ref")]) == 1
    and ports[0] in VALUES
]


@pytest.mark.parametrize(("hold", "port", "value"), REFERENCES)
def test_an_absolute_reference_is_the_parameter(hold, port, value):
    def commanded(wired, **options):
        block = hold("737", **options)
        if wired:
            block[port].get_inputs()  # as a connection does
        return outputs(block, 280.0, **{port: value * wired})

    parameter = commanded(False, **{port: value})
    assert np.array_equal(commanded(True, reference="absolute"), parameter)
    # the parameter gives way to the wire, and stays without one
    other = commanded(True, reference="absolute", **{port: value - 1.0})
    assert np.array_equal(other, parameter)
    unwired = commanded(False, reference="absolute", **{port: value})
    assert np.array_equal(unwired, parameter)


def test_a_misspelt_kind_of_reference_is_refused():
    with pytest.raises(ParameterError) as error:
        PitchHold(reference="absolut")
    assert (error.value.parameter, error.value.value) == ("reference", "absolut")


WARNINGS = [
    # lower than now, and meant as the altitude and the airspeed themselves
    ("AltitudeHold", "h_ref", 4500.0, "4500 ft at h_ref is an increment and commands 9500 ft"),
    ("AltitudeHold", "h_ref", 3900.0, None),
    ("AirspeedHold", "vc_ref", 80.0, "80 kt at vc_ref is an increment and commands 170 kt"),
    ("AirspeedHold", "vc_ref", 44.0, None),
    ("Autopilot", "h_ref", 5500.0, "Autopilot: 5500 ft at h_ref is an increment"),
    ("Autopilot", "vc_ref", 95.0, "reference='absolute' the port is the reference"),
]


@pytest.mark.parametrize(
    ("hold", "port", "value", "warned"),
    [(all_holds.HOLDS[name], *row) for name, *row in WARNINGS if name in all_holds.HOLDS],
)
@pytest.mark.parametrize("reference", ["increment", "absolute"])
def test_a_reference_meant_to_be_absolute_is_warned_of(hold, port, value, warned, reference):
    plane, block, constant = start("c172p"), hold("c172p", reference=reference), Constant(value)
    seen = tuple(n for n in block.input_port_labels if n in STATES)
    sim = Simulation(
        [plane, block, constant],
        [Connection(plane[seen], block[seen]), Connection(constant, block[port])],
        dt=1 / 120,
        log=False,
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim.run(0.1)
    said = [str(w.message) for w in caught if "increment" in str(w.message)]
    if warned and reference == "increment":
        assert len(said) == 1
        assert warned in said[0]
    else:
        assert not said
