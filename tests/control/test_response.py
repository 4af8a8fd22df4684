"""Response quality against closed forms and python-control's ``step_info``."""

from __future__ import annotations

import math

import numpy as np
import pytest
from how_many import first

from pathsim_jsbsim_blocks import BlocksError, ParameterError
from pathsim_jsbsim_blocks.control import response_quality

TIME = np.linspace(0.0, 40.0, 40_001)


def second_order(damping, frequency, time=TIME):
    """Unit step response of a second-order system (Ogata, equations 5-12 to 5-17)."""
    z, x = damping, frequency * time
    if z == 1.0:
        return 1.0 - (1.0 + x) * np.exp(-x)
    root = np.emath.sqrt(z * z - 1.0)
    fast, slow = z + root, z - root
    y = 1.0 - (fast * np.exp(-slow * x) - slow * np.exp(-fast * x)) / (2.0 * root)
    return np.real(y)


@pytest.mark.parametrize(
    ("damping", "frequency"),
    first([(0.2, 2.0), (0.7, 0.5), (1.0, 2.0), (1.5, 0.5), (0.5, 2.0), (0.2, 0.5)], 4),
)
def test_second_order_systems_as_python_control_has_them(damping, frequency):
    control = pytest.importorskip("control")
    system = control.tf([frequency**2], [1.0, 2 * damping * frequency, frequency**2])
    info = control.step_info(system, T=TIME, SettlingTimeThreshold=0.02)
    found = response_quality(TIME, second_order(damping, frequency), 1.0)
    step = TIME[1]  # step_info takes the next sample
    assert found.settling == pytest.approx(info["SettlingTime"], abs=1.01 * step)
    assert found.rise == pytest.approx(info["RiseTime"], abs=1.01 * step)
    assert found.overshoot_percent == pytest.approx(info["Overshoot"], abs=1e-6)
    assert found.steady_error == pytest.approx(
        np.max(np.abs(info["SteadyStateValue"] - second_order(damping, frequency)[36_000:])),
        abs=1e-9,
    )


def test_a_first_order_lag_between_its_samples():
    time = np.linspace(0.0, 10.0, 101)  # 0.1 s apart: without interpolation 0.09 s wrong
    found = response_quality(time, 20.0 - 10.0 * np.exp(-time), 20.0)
    assert found.step == 10.0
    # the chord of a curve over 0.1 of its time constant: within 0.1^2 / 8 of its height
    assert found.settling == pytest.approx(math.log(50.0), abs=0.00126)
    assert found.rise == pytest.approx(math.log(9.0), abs=0.00126)
    assert found.overshoot == 0.0
    assert found.steady_error == pytest.approx(10.0 * math.exp(-9.0))


def test_a_step_down_and_in_other_units_is_the_same():
    y = second_order(0.3, 1.0)
    up = response_quality(TIME, y, 1.0)
    down = response_quality(TIME, 5000.0 - 200.0 * y, 4800.0)
    assert down.step == -200.0
    assert down.overshoot == pytest.approx(200.0 * up.overshoot)
    assert down.overshoot_percent == pytest.approx(up.overshoot_percent)
    assert (down.settling, down.rise) == pytest.approx((up.settling, up.rise))
    # the same band as an absolute tolerance, and wider ones in which it settles sooner
    assert response_quality(TIME, y, 1.0, tolerance=0.02).settling == up.settling
    assert response_quality(TIME, y, 1.0, share=0.05).settling < up.settling
    assert response_quality(TIME, y, 1.0, rise=(0.0, 1.0)).rise == pytest.approx(
        (math.pi - math.acos(0.3)) / math.sqrt(1.0 - 0.09), abs=1e-3
    )


@pytest.mark.parametrize("ramp", [0.0, 0.5])
def test_it_starts_where_the_reference_first_changes(ramp):
    time = np.arange(0.0, 30.0, 0.01)
    moves = time > 5.0 - 0.005
    reference = np.where(moves, 7.0, 3.0)
    if ramp:
        reference = np.minimum(reference, 3.0 + np.maximum(time - 5.0, 0.0) * ramp)
    y = 3.0 + 4.0 * (1.0 - np.exp(-np.maximum(time - 5.0, 0.0)))
    found = response_quality(time, y, reference)
    # of a ramp, the first sample that differs may be the one after its start
    assert found.settling == pytest.approx(math.log(50.0), abs=0.0102 if ramp else 1e-4)
    assert found.step == pytest.approx(4.0, abs=0.05)


def test_the_goal_is_the_last_reference():
    t = ramp = np.arange(4.0)
    assert response_quality(t, ramp, ramp).overshoot == 0.0


def test_what_does_not_happen_is_nan():
    y = np.minimum(TIME / 50.0, 0.8)  # stays 20 % away
    found = response_quality(TIME, y, 1.0)
    assert math.isnan(found.settling)
    assert math.isnan(found.rise)
    assert found.overshoot == 0.0
    assert found.steady_error == pytest.approx(0.28, abs=1e-3)  # at 36 s
    assert response_quality(TIME, y, 1.0, last=1e-6).steady_error == pytest.approx(0.2)
    # settled until the last sample
    late = np.append(np.ones(100), 1.5)
    assert math.isnan(response_quality(np.arange(101.0), late, 1.0, tolerance=0.1).settling)


def test_without_a_step_the_return_from_a_disturbance_is_measured():
    y = 100.0 + np.sin(TIME) * np.exp(-TIME)
    found = response_quality(TIME, y, 100.0, tolerance=0.1)
    assert found.step == 0.0
    assert found.settling == pytest.approx(TIME[np.abs(y - 100.0) > 0.1][-1], abs=0.002)
    for nothing in (found.rise, found.overshoot, found.overshoot_percent):
        assert math.isnan(nothing)
    assert response_quality(TIME, y, 100.0, tolerance=2.0).settling == 0.0


def test_an_instant_recorded_twice_does_not_matter():
    time = np.array([0.0, 1.0, 1.0, 2.0, 3.0])
    found = response_quality(time, [0.0, 0.5, 0.5, 1.0, 1.0], 1.0)
    assert (found.settling, found.rise) == pytest.approx((1.96, 1.6))


BAD = {
    "time decreases": ("time", {"time": [0.0, 2.0, 1.0]}),
    "time stands still": ("time", {"time": [1.0, 1.0, 1.0]}),
    "time is NaN": ("time", {"time": [0.0, math.nan, 2.0]}),
    "one sample": ("time", {"time": [0.0], "y": [0.0]}),
    "another length": ("y", {"y": [0.0, 1.0]}),
    "y is NaN": ("y", {"y": [0.0, math.nan, 1.0]}),
    "y is text": ("y", {"y": "abc"}),
    "reference of another length": ("reference", {"reference": [0.0, 1.0]}),
    "reference changes at the end": ("reference", {"reference": [0.0, 0.0, 1.0]}),
    "no step": ("tolerance", {"y": [1.0, 2.0, 1.0]}),
    "tolerance is 0": ("tolerance", {"tolerance": 0.0}),
    "share above 1": ("share", {"share": 2.0}),
    "one share of rise": ("rise", {"rise": 0.1}),
    "shares in the wrong order": ("rise", {"rise": (0.9, 0.1)}),
    "share of rise above 1": ("rise", {"rise": (0.1, 1.1)}),
    "no time at the end": ("last", {"last": 0.0}),
}


@pytest.mark.parametrize("bad", BAD)
def test_bad_input_is_refused(bad):
    parameter, given = BAD[bad]
    good = {"time": [0.0, 1.0, 2.0], "y": [0.0, 1.0, 1.0], "reference": 1.0}
    response_quality(**good)
    with pytest.raises(ParameterError) as caught:
        response_quality(**{**good, **given})
    assert isinstance(caught.value, BlocksError)
    assert caught.value.parameter == parameter
