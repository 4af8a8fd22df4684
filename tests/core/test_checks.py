"""Checks of arguments: what passes comes back in its plain form, the rest is refused by name."""

import math
import os
import threading

import numpy as np
import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks._core import checks


def refuse(check, *arguments, text=None, **keywords):
    with pytest.raises(ParameterError, match=text) as info:
        check(*arguments, **keywords)
    return info.value


def test_a_new_file_is_not_left_behind(tmp_path):
    assert checks.writable("file", tmp_path / "new.csv") == tmp_path / "new.csv"
    assert list(tmp_path.iterdir()) == []


def test_a_file_keeps_its_contents(tmp_path):
    path = tmp_path / "old.csv"
    path.write_text("kept")
    checks.writable("file", str(path))
    assert path.read_text() == "kept"


@pytest.mark.skipif(os.name == "nt" or not hasattr(os, "mkfifo"), reason="no pipes in folders")
def test_a_pipe_is_not_opened(tmp_path):
    path = tmp_path / "pipe"
    os.mkfifo(path)
    # opening it to write would wait for a reader
    checking = threading.Thread(target=checks.writable, args=("file", path), daemon=True)
    checking.start()
    checking.join(10)
    assert not checking.is_alive()


def test_no_file_can_be_written_there(tmp_path):
    error = refuse(checks.writable, "file", tmp_path, text="is a directory")
    assert (error.parameter, error.value) == ("file", str(tmp_path))
    refuse(checks.writable, "file", tmp_path / "none" / "x.csv", text="no directory")
    refuse(checks.writable, "file", tmp_path / ("x" * 300), text="cannot write")
    refuse(checks.writable, "file", 3)


def test_paths():
    assert checks.as_path("file", "a/b").parts == ("a", "b")
    for value in (3, None, b"x", "a\0b"):
        assert refuse(checks.as_path, "file", value, text="must be a path").parameter == "file"


def test_a_bound_that_does_not_pass_is_open():
    with pytest.raises(ParameterError) as error:
        checks.number("bank", 90.0, above=0.0, high=80.0)
    assert (error.value.parameter, error.value.value) == ("bank", 90.0)


def test_a_single_bound_is_named_alone():
    refuse(checks.number, "x", -1.0, low=0.0, text="^x must be at least 0, not -1$")
    refuse(checks.number, "x", 1.0, high=0.0, text="^x must be at most 0, not 1$")


def test_a_number_lies_within_its_bounds_and_the_bounds_pass():
    assert checks.number("x", 2, low=2.0, high=3.0) == 2.0
    assert checks.number("x", 3.0, low=2.0, high=3.0) == 3.0
    assert type(checks.number("x", np.float32(2.5))) is float
    assert checks.number("x", 1e-300, above=0.0) == 1e-300
    for value in (math.nextafter(2.0, 0.0), math.nextafter(3.0, 4.0)):
        refuse(checks.number, "x", value, low=2.0, high=3.0, text=r"\[2, 3\]")
    error = refuse(checks.number, "x", 0.0, above=0.0, text="x must be greater than 0, not 0")
    assert (error.parameter, error.value) == ("x", 0.0)
    refuse(checks.positive, "x", 0)
    assert checks.positive("x", 3) == 3.0


@pytest.mark.parametrize("value", ["1", True, None, [1.0], np.ones(1), 1j])
def test_what_is_no_number(value):
    refuse(checks.number, "x", value, text="must be a number")


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 10**400])
def test_infinities_pass_where_they_may_and_no_number_never(value):
    refuse(checks.number, "x", value, text="must be finite")
    if value == value:
        assert math.isinf(checks.number("x", value, infinite=True))
    else:
        refuse(checks.number, "x", value, infinite=True, text="must be finite")


def test_limits_may_touch_and_be_infinite():
    assert checks.check_range(-math.inf, math.inf) == (-math.inf, math.inf)
    assert checks.check_range(1, 1.0) == (1.0, 1.0)
    error = refuse(checks.check_range, 2, 1, text="lower limit 2 must not be above the upper, 1")
    assert (error.parameter, error.value) == ("low", 2)


def test_whole_numbers_keep_every_digit():
    assert checks.integer("n", 4.0, low=4) == 4
    assert checks.integer("n", 2**53 + 1, low=1) == 2**53 + 1
    refuse(checks.integer, "n", 4.5, low=1, text="whole number")
    refuse(checks.integer, "n", 3, low=4)


def test_lists_of_numbers():
    for value in ([1, 2.5], (1, 2.5), np.array([1, 2.5])):
        assert checks.numbers("x", value) == [1.0, 2.5]
    for value in ("12", 3.0, np.array(1.0), None):
        refuse(checks.numbers, "x", value, text="must be a list of numbers")
    assert refuse(checks.numbers, "x", [1, "a"], text="must be a number").parameter == "x[1]"


def test_choices_and_switches():
    assert checks.one_of("mode", "full", ["full", "none"]) == "full"
    error = refuse(checks.one_of, "mode", "ful", ["full", "none"], text="did you mean 'full'")
    assert (error.parameter, error.value) == ("mode", "ful")
    refuse(checks.one_of, "mode", 3, ["full"])
    assert checks.flag("on", np.True_) is True
    assert checks.flag("on", False) is False
    for value in ("no", 1, None):
        refuse(checks.flag, "on", value, text="True or False")


def test_nearest_names():
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


def test_mappings():
    given = {"a": 1}
    assert checks.mapping("properties", given) == given
    assert checks.mapping("properties", given) is not given
    assert checks.mapping("properties", None) == {}
    refuse(checks.mapping, "properties", [("a", 1)], text="must be a dict")


def test_arrays_take_their_common_shape_and_are_copies():
    given = np.array([1.0, 2.0])
    x, y = checks.arrays(x=given, y=[[1], [2]])
    assert (x.tolist(), y.tolist()) == ([[1, 2], [1, 2]], [[1, 1], [2, 2]])
    x[0, 0] = 9.0
    assert (x[1, 0], given[0]) == (1.0, 1.0)
    assert checks.arrays(x=1, y=2.5) == [1.0, 2.5]
    error = refuse(checks.arrays, x=[1, 2], y=[1, 2, 3], z=1, text=r"x \(2,\), y \(3,\)$")
    assert error.parameter == "x, y, z"
    for value in ("1", True, None, 1j, [[1], [1, 2]]):
        refuse(checks.arrays, x=value, text="must be a real number")


def test_finite_numbers_keep_their_own_shapes():
    x, y = checks.finite(x=3, y=[1.0, 2.0])
    assert (x, type(x), y.shape) == (3.0, float, (2,))
    assert checks.finite(x=1.5, y=-2.0) == [1.5, -2.0]
    error = refuse(checks.finite, x=1.0, y=[1.0, math.inf, math.nan], text="y must be finite.* inf")
    assert error.parameter == "y"
    refuse(checks.finite, x=math.nan, text="x must be finite, not nan")
    refuse(checks.finite, x=True)
