"""Bounds that are physics, in every block that has such a parameter: built, and set later."""

import dataclasses
import math

import pytest
from public_blocks import BLOCKS

from pathsim_jsbsim_blocks import Actuator, AltitudeHold, Autopilot, DiscretePID, ParameterError
from pathsim_jsbsim_blocks.control.gains import EnvelopeLimits, HeadingGains

NAN, INF = math.nan, math.inf
NEVER = (NAN, INF, -INF, "5", True)

# of each kind: names, values at the ends and inside, values beyond. "authority" stands for all
# that end in it
KINDS = {
    "authority": (
        ("authority",),
        (1e-3, 2.0, (-0.5, 0.0), (0.0, 2.0), [-2, 1]),
        (0.0, -1.0, 2.01, 20.0, (0.0, 0.0), (0.1, 0.5), (-0.5, -0.1), (-3.0, 1.0), (1,), *NEVER),
    ),
    "attitude": (
        ("theta_ref", "phi_ref", "theta_min", "theta_max"),
        (-9.0, 9, 10.0),
        (90.1, -91.0, 360.0, *NEVER),
    ),
    "angle of attack": (("alpha_max",), (1e-3, 90.0), (0.0, -5.0, 91.0, *NEVER)),
    "largest bank": (("bank_max",), (1.0, 30.0), (-1.0, 81.0, 90.0, *NEVER)),
    "airspeed": (("vc_ref", "airspeed"), (1e-3, 90, 600.0), (0.0, -90.0, *NEVER)),
    "heading": (
        ("psi_ref", "chi_ref", "course", "direction"),
        (0.0, 359.0, 360.0, -10.0, 1e6),
        NEVER,
    ),
    "path": (("angle",), (0.1, 3, 20.0), (0.0, -3.0, 30.0, *NEVER)),
    "rate of climb": (("hdot_max", "climb", "sink"), (0.1, 10), (0.0, -5.0, *NEVER)),
    "rate of climb demanded": (("hdot_ref",), (-10.0, 0, 10.0), NEVER),
    "time": (("T", "tau", "lookahead"), (0.5, 1), (0.0, -1.0, *NEVER)),
    "altitude": (("h_ref", "elevation"), (-100.0, 0, 5e3), NEVER),
}
# blocks with parameters of an aircraft's condition, which `TrimCondition` checks
CONDITIONS = ("Aircraft", "JSBSimFDM", "LinearAircraft")


def kind_of(name):
    name = "authority" if name.endswith("authority") else name
    return next((kind for kind, (names, *_) in KINDS.items() if name in names), None)


CASES = [
    (block, field.name)
    for name, block in BLOCKS.items()
    if dataclasses.is_dataclass(block) and name not in CONDITIONS
    for field in dataclasses.fields(block)
    if kind_of(field.name)
]


def test_each_kind_is_there():
    names = {name for _, name in CASES}
    assert {name for names_, *_ in KINDS.values() for name in names_} <= names | {"authority"}
    assert len(CASES) > 75


@pytest.mark.parametrize(("block", "name"), CASES, ids=lambda x: getattr(x, "__name__", x))
def test_values_beyond_are_refused_and_those_within_are_not(block, name):
    _, within, beyond = KINDS[kind_of(name)]
    if block.__name__ == "DaveML":  # outputs that follow the inputs at all times
        within, beyond = (), [x for x in beyond if x != 0.0]
    built = block()
    for bad in beyond:
        before = getattr(built, name)
        for act in (lambda x=bad: block(**{name: x}), lambda x=bad: setattr(built, name, x)):
            with pytest.raises(ParameterError) as error:
                act()
            assert error.value.parameter == name
        assert getattr(built, name) is before
    for good in within:
        block(**{name: good})
        setattr(built, name, good)


@pytest.mark.parametrize("angle", [0.0, 359.5, 360.0, -10.0, 725.0, -1e-20, 1e6])
def test_headings_are_reduced_to_a_turn(angle):
    for block, name in CASES:
        if kind_of(name) == "heading":
            built = block()
            setattr(built, name, angle)
            assert getattr(built, name) == angle
            reduced = getattr(built._checked, name)
            assert 0.0 <= reduced < 360.0
            assert math.cos(math.radians(reduced - angle)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("block", "values", "parameter"),
    [
        (DiscretePID, {"low": 2.0, "high": 1.0}, "low"),
        (DiscretePID, {"Tt": 0.5, "T": 1.0}, "Tt"),
        (Actuator, {"low": 2.0, "high": 1.0}, "low"),
        (Actuator, {"initial": 3.0}, "initial"),
        (AltitudeHold, {"theta_min": 5.0, "theta_max": 4.0}, "theta_min"),
        (AltitudeHold, {"theta_min": 80.0}, "theta_min"),  # above that of the gains
        (Autopilot, {"theta_min": 5.0, "theta_max": 4.0}, "theta_min"),
    ],
)
def test_limits_that_exclude_each_other_are_refused(block, values, parameter):
    with pytest.raises(ParameterError) as error:
        block(**values)
    assert error.value.parameter == parameter
    built = block()
    before = dict(vars(built.clock), now=None, events=None)
    with pytest.raises(ParameterError) as error:
        built.set(**values)
    assert error.value.parameter == parameter
    assert dict(vars(built.clock), now=None, events=None) == before
    assert all(getattr(built, n) == getattr(block(), n) for n in values)


@pytest.mark.parametrize(
    ("gains", "values", "parameter"),
    [
        (EnvelopeLimits, (10.0, 200.0, 10.0, 10.0, 180.0), "vc_min"),
        (EnvelopeLimits, (3.0, 50.0, 10.0, 10.0, 180.0, 1.0, 4.0), "alpha_zero"),
        (EnvelopeLimits, (95.0, 50.0, 10.0, 10.0), "alpha_max"),
        (HeadingGains, (1.0, 0.0, 95.0), "bank"),
    ],
)
def test_gains_that_no_aircraft_has(gains, values, parameter):
    with pytest.raises(ParameterError) as error:
        gains(*values)
    assert error.value.parameter == parameter
