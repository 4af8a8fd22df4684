"""Parameters declared as fields: constructor, attributes, checks and what introspection shows."""

import contextlib
import copy
import inspect
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations

import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Block, Scope

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import BlocksError, ParameterError, PitchHold, RampSource, TrimCondition
from pathsim_jsbsim_blocks._core.checks import number, numbers, positive
from pathsim_jsbsim_blocks._core.parameters import Parametric, parameter
from pathsim_jsbsim_blocks.control.gain_tables import table


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
    given[0] = 9
    assert block.weights.tolist() == [1, 2, 3]
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


# what a parameter that can be edited may be, by its name; a test fails for one that is not here
_ALL_LOOPS = asdict(table("c172p").points[0].gains)
_EDITABLE = {
    "gains": [*_ALL_LOOPS.values()]
    + [dict(part) for n in range(1, 8) for part in combinations(_ALL_LOOPS.items(), n)],
    "authority": [[-0.5, 0.5]],
    "setup": [{"fcs/flap-cmd-norm": 0.0}],
    "properties": [{"fcs/flap-cmd-norm": 0.0}],
    "create": [{"a/b": 1.0}],
    "integrators": [{"rate_rotational": "euler"}],
    "planet": [{"J2": 0.00108}],
    "input_properties": [["fcs/flap-cmd-norm"]],
    "output_properties": [["fcs/flap-cmd-norm"]],
    "waypoints": [[[47.0, 8.0], [47.5, 8.0]], np.array([[47.0, 8.0], [47.5, 8.0]])],
    "fly_over": [[1]],
    "arcs": [{}],
    "holding": [[90.0, "left", 9000.0, 30_000.0]],
    "signals": [["a", "b"]],
    "station": [[47.0, 8.0]],
    "threshold": [[47.0, 8.0]],
    "widths": [[3, 2], np.array([3.0, 2.0])],
    "signs": [[1, -1, 1, -1], np.array([1.0, -1.0, 1.0, -1.0])],
    "payload": [{0: 180.0}, [180.0]],
    "fuel": [{0: 100.0}, [100.0]],
    "engines_off": [[0]],
}
_ALSO = {
    "MultistepSource": {"widths": {"signs": [1, -1]}},
    "CourseHold": {"fly_over": {"waypoints": [(47, 8), (48, 8)]}}
    | {"holding": {"waypoints": [(47, 8), (48, 8)]}},
    "TrimCondition": {"engines_off": {"mode": "glide"}},
    "LinearAircraft": {None: {"method": "algebraic", "speed": 90}},
    "Aircraft": {None: {"speed": 90}},
    "JSBSimFDM": {None: {"aircraft_model": "c172p", "trim_airspeed": 90}},
}


def editable():
    """Every public class of blocks and conditions, with each parameter that can be edited."""
    kinds = [getattr(package, name) for name in package.__all__]
    for kind in kinds:
        if inspect.isclass(kind) and (issubclass(kind, Block) or kind is TrimCondition):
            for name, value in inspect.signature(kind).parameters.items():
                if re.search("Mapping|Sequence|[Ll]ist|[Dd]ict|[Tt]uple|Gains|Authority|Any|array",
                             str(value.annotation)):  # fmt: skip
                    yield pytest.param(kind, name, id=f"{kind.__name__}-{name}")


def emptied(value):
    """Edit all of a value in place."""
    if isinstance(value, dict):
        for part in value.values():
            emptied(part)
        value.clear()
    elif isinstance(value, np.ndarray):
        value[:] = np.nan
    elif isinstance(value, list):
        for part in value:
            emptied(part)
        value.clear()


def described(block):
    return repr({name: getattr(block, name) for name in inspect.signature(type(block)).parameters})


@pytest.mark.parametrize(("kind", "name"), [*editable()])
def test_a_parameter_is_the_blocks_own(kind, name):
    more = _ALSO.get(kind.__name__, {})
    more = {**more.get(None, {}), **more.get(name, {})}
    tried = 0
    kind_of_value = "authority" if name.endswith("_authority") else name
    for sample in _EDITABLE[kind_of_value]:
        value = copy.deepcopy(sample)
        try:
            block = kind(**{**more, name: value})
        except BlocksError:
            continue  # the gains of another loop
        tried += 1
        before = described(block)
        emptied(value)
        assert described(block) == before
        if isinstance(block, Block):
            block.set()  # checks and applies all parameters again
        for edit in (emptied, lambda x: x.update(a=1), lambda x: x.append(1)):
            with contextlib.suppress(TypeError, ValueError, AttributeError):
                edit(getattr(block, name))
        assert described(block) == before
        if isinstance(block, Block):
            block.reset()
            assert described(block) == before
    assert tried


def test_a_misspelt_attribute_is_refused_and_a_free_one_is_not():
    hold = PitchHold()
    for name, close in (("theta_rf", "theta_ref"), ("gain", "gains"), ("elevatr", "elevator")):
        with pytest.raises(ParameterError) as error:
            setattr(hold, name, 7.0)
        assert error.value.parameter == name
        assert f"did you mean {close!r}" in str(error.value)
        assert not hasattr(hold, name)
    with pytest.raises(ParameterError, match="no parameter 'elevator': 'elevator' is a port"):
        hold.elevator = 7.0
    for name in ("note", "speed_log", "name", "number", "color", "_theta_rf", "alpha_f"):
        setattr(hold, name, 1)
        setattr(hold, name, 2)
        assert getattr(hold, name) == 2


def test_a_block_of_ones_own_keeps_its_attributes():
    class Counting(Gain):
        def build(self):
            super().build()
            self.factors = getattr(self, "factors", 0) + 1  # near a parameter

    block = Counting(2.0)
    block.factor = 3.0
    block.factors = 7
    assert block.factors == 7
