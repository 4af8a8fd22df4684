"""Gains, references and turns of the autopilot and the altitude hold."""

from __future__ import annotations

import dataclasses
import warnings

import numpy as np
import pytest
from flights import fly, start, step
from hand_tuned import GAINS
from how_many import first

from pathsim_jsbsim_blocks import (
    Aircraft,
    AltitudeHold,
    Autopilot,
    GlideslopeHold,
    ParameterError,
)
from pathsim_jsbsim_blocks.control.gains import DesignPoint, GainSchedule
from pathsim_jsbsim_blocks.flight import level_flight


@pytest.mark.parametrize("hold", [AltitudeHold, Autopilot, GlideslopeHold])
def test_a_lowest_pitch_reference_above_the_highest_names_both(hold):
    with pytest.raises(ParameterError) as error:
        hold(theta_min=16.0)
    assert (error.value.parameter, error.value.value) == ("theta_min", 16.0)
    # at any point of a schedule: the 15 deg are not those of the nominal point
    high = dataclasses.replace(
        GAINS["737"], altitude=dataclasses.replace(GAINS["737"].altitude, theta_max=20.0)
    )
    points = DesignPoint(0.0, 150.0, high), DesignPoint(0.0, 250.0, GAINS["737"])
    with pytest.raises(ParameterError) as error:
        hold(gains=GainSchedule("737", points), theta_min=16.0)
    assert (error.value.parameter, error.value.value) == ("theta_min", 16.0)
    hold(gains=GainSchedule("737", points), theta_min=16.0, theta_max=18.0)


@pytest.mark.parametrize(
    ("port", "value", "warned"),
    [
        ("vc_ref", 20.0, "Autopilot: vc_ref "),
        ("vc_ref", 40.0, ""),  # below it, as in tests of the protection
        ("thr_ref", 75.0, "Autopilot: thr_ref "),
        ("thr_ref", -0.8, ""),
    ],
)
def test_a_reference_far_from_what_can_be_flown_is_warned_of_once(port, value, warned):
    # alpha 3.3 deg at 90 KCAS: the minimum airspeed is about 50 kt
    autopilot = Autopilot("c172p", reference="absolute")
    signals = {"h": 5000.0, "vc": 90.0, "alpha": 3.3, "theta": 3.3, "v_mode": 2.0, port: value}
    signals.setdefault("vc_ref", 90.0)
    for name in ("vc_ref", "thr_ref"):
        autopilot[name].get_inputs()  # as a connection does
    u = [signals.get(name, 0.0) for name in autopilot.input_port_labels]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        state = autopilot.initial_state()
        for _ in range(3):
            _, state = autopilot.law(u, state)
    said = [str(w.message) for w in caught]
    assert len(said) == bool(warned)
    assert all(text.startswith(warned) for text in said)


@pytest.mark.parametrize(
    ("name", "bank"),
    first([("c172p", 25.0), ("737", -25.0), ("global5000", 25.0), ("c172p", -25.0)]),
)
def test_turns_are_coordinated(name, bank):
    ports = {"roll_mode": step(1.0), "phi_ref": lambda t: bank * (1.0 < t < 20.0)}
    record = fly(start(name), 32.0, ports, unwired=())
    assert np.max(np.abs(record["beta"])) < 1.0  # deg
    assert np.max(np.abs(record.before(20.0).after(15.0)["beta"])) < 0.4
    assert np.max(np.abs(record["h"] - record["h"][0])) < 20.0
    assert record.before(20.0)["phi"][-1] == pytest.approx(bank, abs=0.3)


@pytest.mark.parametrize(("name", "speed"), first([("T38", 178.0), ("F80C", 148.0), ("A4", 155.0)]))
def test_turns_are_coordinated_at_a_large_angle_of_attack(name, speed):
    plane = Aircraft(name, altitude=5000.0, speed=speed, gear=0.0)
    record = fly(plane, 20.0, {"psi_ref": step(30.0)}, unwired=())
    assert record["alpha"][0] > 9.0
    assert np.max(np.abs(record["beta"])) < 1.25  # deg
    assert np.max(np.abs(record["h"] - record["h"][0])) < 5.0
    assert record["psi"][-1] > 25.0


def test_level_flight_with_the_nose_high_leaves_room_for_a_climb():
    flight = level_flight("f104")
    slow = dataclasses.replace(flight.condition, speed=219.0)
    plane = Aircraft("f104", condition=slow, create=flight.create)
    record = fly(plane, 25.0, {"h_ref": step(300.0)}, unwired=())
    assert record["theta"][0] > 14.5
    assert record["h"][-1] == pytest.approx(5300.0, abs=10.0)
