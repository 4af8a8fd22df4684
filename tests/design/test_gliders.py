"""Gains of aircraft without an engine, flown by the holds."""

import numpy as np
import pytest
from pathsim import Connection, Simulation

from pathsim_jsbsim_blocks import (
    Aircraft,
    AirspeedHold,
    AltitudeHold,
    ParameterError,
    PitchHold,
    RollHold,
    TrimCondition,
)
from pathsim_jsbsim_blocks.design import DesignedSchedule, design_gains

GLIDE = TrimCondition(altitude=5000, speed=45, mode="glide", gear=0.0)


@pytest.fixture(scope="module")
def designed():
    return design_gains("sgs126", GLIDE)


def test_pitch_and_roll_are_designed_and_the_rest_is_left_out(designed):
    report = {row.loop: row for row in designed.report}
    assert report["pitch"].flown_settling <= 4.0
    assert report["roll"].flown_settling <= 5.0
    assert {"speed", "altitude"} == {loop for loop, row in report.items() if np.isnan(row.Ms)}
    assert all(report[loop].relaxed for loop in ("speed", "altitude"))
    assert designed.altitude is designed.speed is designed.envelope is None


def test_holds_fly_a_glider_with_them(designed):
    plane = Aircraft("sgs126", condition=GLIDE)
    theta = plane.trim.theta
    pitch = PitchHold(gains=designed, reference="absolute", theta_ref=theta + 2.0)
    roll = RollHold(gains=designed, phi_ref=15.0)
    sim = Simulation(
        [plane, pitch, roll],
        [
            Connection(plane[["theta", "q"]], pitch[["theta", "q"]]),
            Connection(plane[["phi", "p"]], roll[["phi", "p"]]),
            Connection(pitch["elevator"], plane["elevator"]),
            Connection(roll["aileron"], plane["aileron"]),
        ],
        dt=1 / 120,
        log=False,
    )
    sim.run(15)
    assert plane.outputs["theta"] == pytest.approx(theta + 2.0, abs=0.2)
    assert plane.outputs["phi"] == pytest.approx(15.0, abs=0.5)


def test_a_file_keeps_what_is_left_out(designed, tmp_path):
    path = str(tmp_path / "glider.json")
    DesignedSchedule((designed,), 0, ()).save(path)
    assert PitchHold(gains=path).gains == path
    for hold in (AltitudeHold, AirspeedHold):
        with pytest.raises(ParameterError) as error:
            hold(gains=path)
        assert error.value.parameter == "gains"
