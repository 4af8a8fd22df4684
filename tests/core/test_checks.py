"""Checks of arguments: what passes comes back in its plain form, the rest is refused by name."""

import math
from functools import partial

import numpy as np
import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks._core import checks, files

NO_NUMBERS = ["1", True, None, [1.0], np.ones(1), 1j, math.nan]
INFINITIES = [math.inf, -math.inf, 10**400]


@pytest.mark.parametrize(
    ("check", "values", "kind"),
    [
        (partial(checks.number, low=2.0, high=3.0), [2, 2.5, 3.0, np.float32(2.5)], float),
        (partial(checks.number, above=0.0), [1e-300], float),
        (partial(checks.number, infinite=True), [1.0, math.inf, -math.inf], float),
        (checks.positive, [3], float),
        (partial(checks.integer, low=1), [4.0, 2**53 + 1], int),  # every digit
        (partial(checks.one_of, choices=["full", "none"]), ["full", np.str_("none")], str),
        (checks.flag, [np.True_, False], bool),
    ],
)
def test_what_passes_comes_back_in_its_plain_form(check, values, kind):
    for value in values:
        plain = check("x", value)
        assert plain == value
        assert type(plain) is kind


@pytest.mark.parametrize(
    ("check", "values"),
    [
        (checks.number, [*NO_NUMBERS, *INFINITIES]),
        (partial(checks.number, infinite=True), NO_NUMBERS),
        (
            partial(checks.number, low=2.0, high=3.0),
            [math.nextafter(2.0, 0.0), math.nextafter(3.0, 4.0)],
        ),
        (partial(checks.number, above=0.0, high=80.0), [0.0, 90.0]),
        (partial(checks.number, low=0.0), [-1.0]),
        (partial(checks.number, high=0.0), [1.0]),
        (checks.positive, [0]),
        (partial(checks.integer, low=4), [4.5, 3]),
        (checks.numbers, ["12", 3.0, np.array(1.0), None]),
        (partial(checks.one_of, choices=["full", "none"]), ["ful", 3]),
        (checks.flag, ["no", 1, None]),
        (files.as_path, [3, None, b"x", "a\0b"]),
        (files.writable, [3]),
        (checks.mapping, [[("a", 1)]]),
        (lambda name, value: checks.arrays(**{name: value}), ["1", True, None, 1j, [[1], [1, 2]]]),
        (lambda name, value: checks.finite(**{name: value}), [True, math.nan, [1.0, math.inf]]),
    ],
)
def test_the_rest_is_refused_with_its_name_and_value(check, values):
    for value in values:
        with pytest.raises(ParameterError) as error:
            check("x", value)
        assert error.value.parameter == "x"
        assert error.value.value is value


def test_limits_may_touch_and_be_infinite():
    assert checks.check_range(-math.inf, math.inf) == (-math.inf, math.inf)
    assert checks.check_range(1, 1.0) == (1.0, 1.0)
    with pytest.raises(ParameterError) as error:
        checks.check_range(2, 1)
    assert (error.value.parameter, error.value.value) == ("low", 2)


def test_the_nearest_names_contain_it_are_in_it_or_are_spelt_like_it():
    names = ["attitude/theta-deg", "attitude/phi-deg", "velocities/vt-fps", "ic/theta-deg"]
    # those that contain it, the shortest first
    assert checks.nearest("theta-deg", names) == ["ic/theta-deg", "attitude/theta-deg"]
    assert checks.nearest("attitude/theta-dge", names, 1) == ["attitude/theta-deg"]
    # by the last part alone
    assert checks.nearest("vt-fsp", names) == ["velocities/vt-fps"]
    # two letters are contained in too much
    assert checks.nearest("at", names) == []
    # without regard to capital letters
    assert checks.nearest("ATTITUDE/P", names)[0] == "attitude/phi-deg"
    assert checks.nearest("PA-28", ["OV10", "pa28"]) == ["pa28"]
    # those that it contains, the longest first
    aircraft = ["A320", "A4", "c172", "c172p"]
    assert checks.nearest("Airbus A320", aircraft) == ["A320"]
    assert checks.nearest("c172p-slow.json", aircraft)[:2] == ["c172p", "c172"]
    assert len(checks.nearest("deg", names)) == 3
    assert checks.did_you_mean(["a", "b"]) == "; did you mean 'a' or 'b'?"
    assert checks.did_you_mean([]) == ""


def test_a_mapping_is_copied_and_none_is_empty():
    given = {"a": 1}
    assert checks.mapping("properties", given) == given
    assert checks.mapping("properties", given) is not given
    assert checks.mapping("properties", None) == {}


def test_arrays_take_their_common_shape_and_are_copies():
    given = np.array([1.0, 2.0])
    x, y = checks.arrays(x=given, y=[[1], [2]])
    assert (x.tolist(), y.tolist()) == ([[1, 2], [1, 2]], [[1, 1], [2, 2]])
    x[0, 0] = 9.0
    assert (x[1, 0], given[0]) == (1.0, 1.0)
    assert checks.arrays(x=1, y=2.5) == [1.0, 2.5]
    with pytest.raises(ParameterError) as error:
        checks.arrays(x=[1, 2], y=[1, 2, 3], z=1)
    assert error.value.parameter == "x, y, z"


def test_finite_numbers_keep_their_own_shapes():
    x, y = checks.finite(x=3, y=[1.0, 2.0])
    assert (x, type(x), y.shape) == (3.0, float, (2,))
    assert checks.finite(x=1.5, y=-2.0) == [1.5, -2.0]
