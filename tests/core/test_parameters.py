"""Parameters declared as fields: constructor, attributes, checks and what introspection shows."""

import inspect
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import (
    LinearAircraft,
    ParameterError,
    RampSource,
)
from pathsim_jsbsim_blocks._core.checks import number, numbers, positive
from pathsim_jsbsim_blocks._core.parameters import Parametric, parameter


@dataclass(eq=False, repr=False)
class Gain(Parametric):
    """A block with fields of its own."""

    factor: float = parameter(1.0, number, low=-2.0)
    weights: Sequence[float] = parameter((1, 2), numbers)
    label: str = "a"

    def build(self):
        c = self._checked
        if c.factor * len(c.weights) > 10.0:
            raise ParameterError("too much", parameter="factor", value=self.factor)
        self.total = c.factor * sum(c.weights)


@dataclass(eq=False)
class Wider(Gain):
    """One with a further field."""

    width: float = parameter(3.0, positive)


class Own(Gain):
    """One with a constructor, as users write it."""

    def __init__(self, factor=2.0, extra=7.0):
        super().__init__(factor, label="own")
        self.extra = extra


def test_fields_are_the_signature():
    defaults = {name: p.default for name, p in inspect.signature(Gain).parameters.items()}
    assert defaults == {"factor": 1.0, "weights": (1, 2), "label": "a"}
    assert list(inspect.signature(Wider).parameters) == ["factor", "weights", "label", "width"]
    shown = {name: p["default"] for name, p in Gain.info()["parameters"].items()}
    assert shown == defaults
    with pytest.raises(TypeError):
        Gain(1.0, (1,), "b", 2.0)
    # Python 3.11.2 prefers an inherited __new__ to an inherited __init__
    assert str(inspect.signature(type("Same", (Gain,), {}))) == str(inspect.signature(Gain))


def test_attributes_keep_what_was_given_and_the_checked_values_are_beside_them():
    given = np.array([1, 2, 3])
    block = Gain(2, weights=given)
    assert block.weights is given
    assert (repr(block.factor), block.label) == ("2", "a")
    assert type(block._checked.factor) is float
    assert block._checked.weights == [1.0, 2.0, 3.0]
    assert block.total == 12.0
    assert repr(Gain(0.5, label="c")) == "Gain(factor=0.5, label='c')"


@pytest.mark.parametrize(
    ("values", "refused"),
    [
        ({"factor": -3.0}, "factor"),
        ({"factor": "1"}, "factor"),
        ({"weights": 4.0}, "weights"),
        ({"weights": [1.0, None]}, r"weights[1]"),
        ({"factor": 6.0}, "factor"),  # by build
    ],
)
def test_a_bad_value_is_refused_at_construction_and_later(values, refused):
    with pytest.raises(ParameterError) as error:
        Gain(**values)
    assert error.value.parameter == refused
    block = Gain(2.0, label="kept")
    with pytest.raises(ParameterError):
        block.set(label="new", **values)
    ((name, value),) = values.items()
    with pytest.raises(ParameterError):
        setattr(block, name, value)
    assert (block.factor, block.weights, block.label, block.total) == (2.0, (1, 2), "kept", 6.0)


def test_parameters_that_depend_on_each_other_are_set_together():
    block = Gain(4.0)
    block.set(weights=[1.0] * 9, factor=1.0)
    assert block.total == 9.0
    block.weights = [5.0]
    assert block.total == 5.0


def test_a_constructor_of_ones_own_keeps_the_checks_of_the_fields():
    block = Own()
    assert (block.factor, block.label, block.extra) == (2.0, "own", 7.0)
    with pytest.raises(ParameterError) as error:
        block.factor = -5.0
    assert (error.value.parameter, error.value.value) == ("factor", -5.0)
    block.set(extra=8.0)
    assert block.extra == 8.0
    with pytest.raises(ParameterError) as error:
        Own(factor="x")
    assert (error.value.parameter, error.value.value) == ("factor", "x")


def test_a_block_of_ones_own_without_the_decorator_is_told():
    class Bare(Gain):
        width: float = parameter(3.0, positive)

    # equality by value leaves no hash, which PathSim needs
    @dataclass
    class Equal(Gain):
        width: float = parameter(3.0, positive)

    for kind in (Bare, Equal):
        with pytest.raises(
            TypeError, match=rf"{kind.__name__} needs the decorator @dataclass\(eq=False\)"
        ):
            kind()


def test_ctrl_c_while_a_value_is_tried_takes_it_back():
    @dataclass(eq=False)
    class Slow(Gain):
        def build(self):
            super().build()
            if self._checked.factor == 3.0:
                raise KeyboardInterrupt

    block = Slow(2.0)
    with pytest.raises(KeyboardInterrupt):
        block.set(factor=3.0, weights=(5,))
    assert (block.factor, block.weights, block._checked.factor, block.total) == (
        2.0,
        (1, 2),
        2.0,
        6.0,
    )


def test_a_linear_aircraft_stays_the_one_that_was_identified():
    plane = LinearAircraft("c172p", altitude=5000, speed=90, method="algebraic")
    plane.altitude = 5000
    with pytest.raises(ParameterError) as error:
        plane.set(speed=90, altitude=3000)
    assert (error.value.parameter, error.value.value) == ("altitude", 3000)
    assert plane.altitude == 5000


def test_a_start_moved_before_it_is_reached_is_the_start():
    # the pulse began at the old time
    source, scope = RampSource(start=1.0, rise_time=0.5), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.01, log=False)
    sim.run(0.5)
    source.start = 2.0
    sim.run(2.5)
    time, (y,) = scope.read()
    assert y == pytest.approx(np.clip((time - 2.0) / 0.5, 0.0, 1.0), abs=1e-12)
    with pytest.raises(ParameterError) as error:
        source.start = -1.0
    assert (error.value.parameter, error.value.value) == ("start", -1.0)
