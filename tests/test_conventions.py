"""What every public name keeps to; who may import whom is checked by `lint-imports`."""

import ast
import dataclasses
import functools
import importlib
import inspect
import pickle
import pkgutil
import re

import pytest
from package_source import SOURCE, nodes
from pathsim.blocks import Block
from public_blocks import BLOCKS

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import BlocksError, ParameterError, PitchHold, TrimCondition
from pathsim_jsbsim_blocks.control import gains
from pathsim_jsbsim_blocks.errors import KeywordError

# LinearAircraft() is the c172p, whose elevator is asymmetric
pytestmark = pytest.mark.filterwarnings(
    "ignore:c172p. the response of vt to elevator is not linear"
)

PUBLIC = {n: getattr(package, n) for n in package.__all__ if n != "fly"}
DATA = {n: o for n, o in PUBLIC.items() if n in ("TrimCondition", "TrimState")}

GAINS = [
    o
    for o in vars(gains).values()
    if dataclasses.is_dataclass(o) and o.__module__ == gains.__name__ and o.__name__[0] != "_"
]


# a linear aircraft flies for seconds until it is there
BUILT = [pytest.param(n, marks=[pytest.mark.long] * (n == "LinearAircraft")) for n in BLOCKS]


@functools.cache
def made(name):
    """A block with its defaults."""
    return BLOCKS[name]()


def parameters(cls):
    return [p for p in inspect.signature(cls.__init__).parameters if p != "self"]


def section(text, title):
    """The body of a NumPy-style section."""
    found = re.search(rf"^{title}\n-+\n(.*?)(?=^\w[\w ]*\n---|\Z)", text, re.M | re.S)
    return found[1] if found else ""


def documented(text):
    """Names explained in a section: at its margin, with the text on indented lines below.

    A text on the name's own line would run together with the next in PathView.
    """
    names = re.findall(r"^([*\w, `]+?)(?: : .*)?\n +\S", text, re.M)
    return {n.strip(" `*") for group in names for n in group.split(",")}


def test_every_block_is_public():
    assert len(BLOCKS) > 20
    # the bases of blocks, which have subclasses in the package, are not
    for part in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        for name, block in inspect.getmembers(importlib.import_module(part.name), inspect.isclass):
            if not issubclass(block, Block) or block.__module__ != part.name or name[0] == "_":
                continue
            base = any(c.__module__.startswith(package.__name__) for c in block.__subclasses__())
            assert base or BLOCKS.get(name) is block, f"{name} is missing in __all__"


def test_dir_shows_the_public_names_and_no_others():
    # PathView finds the blocks by dir()
    assert dir(package) == sorted(package.__all__)
    assert all(
        inspect.isclass(o) and o.__module__.startswith(package.__name__) for o in PUBLIC.values()
    )


@pytest.mark.parametrize("name", BUILT)
def test_a_port_that_does_not_exist_is_refused(name):
    block = made(name)
    with pytest.raises(ParameterError) as error:
        block["no_such_port"]
    assert (error.value.parameter, error.value.value) == ("port", "no_such_port")
    for ports in (block.inputs, block.outputs):
        for known in [*ports._mapping][:5]:
            said = f"no port '{known}_'; did you mean .*{known!r}"
            with pytest.raises(BlocksError, match=said):
                block[0, f"{known}_"]
            with pytest.raises(ParameterError, match=said):
                ports[f"{known}_"]
            with pytest.raises(ParameterError, match=said):
                ports[f"{known}_"] = 1.0


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_a_one_line_summary(name):
    summary, _, rest = inspect.getdoc(PUBLIC[name]).partition("\n")
    assert 10 < len(summary) <= 120
    assert summary.endswith(".") or name.endswith("Error")
    assert rest == "" or rest.startswith("\n")


@pytest.mark.parametrize("name", [*BLOCKS, *DATA])
def test_parameters_are_documented_and_no_others(name):
    text = inspect.getdoc({**BLOCKS, **DATA}[name])
    titles = ["Attributes"] if name == "TrimState" else ["Parameters", "Other Parameters"]
    sections = [section(text, title) for title in titles]
    # PathView's dialog shows the text of a shared line at the last name only
    assert name in DATA or not re.search(r"^\w+, .*", "\n".join(sections), re.M)
    found = set().union(*map(documented, sections))
    assert found == set(parameters({**BLOCKS, **DATA}[name]))


@pytest.mark.parametrize("name", [n for n in BLOCKS if n not in ("JSBSimFDM", "DaveML")])
def test_ports_are_documented(name):
    block = BLOCKS[name]
    text = inspect.getdoc(block)
    assert documented(section(text, "Inputs")) == set(block.input_port_labels)
    assert documented(section(text, "Outputs")) == set(block.output_port_labels)


@pytest.mark.parametrize("name", BUILT)
def test_parameters_are_attributes_and_set_by_name_and_no_others(name):
    block = made(name)
    for parameter in parameters(BLOCKS[name]):
        default = inspect.signature(BLOCKS[name].__init__).parameters[parameter].default
        value = getattr(block, parameter)
        kept = value is None or value == default or list(value) == list(default or [])
        assert kept, f"{parameter} is {value!r}, not {default!r}"
    block.set(**{parameter: getattr(block, parameter) for parameter in parameters(BLOCKS[name])})
    for parameter in parameters(BLOCKS[name])[:1]:
        with pytest.raises(BlocksError, match=f"no parameter '{parameter}_'.*'{parameter}'"):
            block.set(**{f"{parameter}_": 1.0})


@pytest.mark.parametrize(
    "make", [*BLOCKS.values(), TrimCondition, *GAINS], ids=lambda c: c.__name__
)
def test_a_misspelt_keyword_is_refused_naming_the_nearest(make):
    known = [*inspect.signature(make).parameters]
    said = f"^{make.__name__} has no parameter 'XYZ_'; it has {', '.join(known) or 'none'}$"
    with pytest.raises(KeywordError, match=said):
        make(XYZ_=1.0)
    for name in known:
        with pytest.raises(TypeError, match=f"no parameter '{name}_'; did you mean .*'{name}'"):
            make(**{f"{name}_": 1.0})


# a misspelt keyword, and a function as a value
@pytest.mark.parametrize(("name", "value"), [("gans", "737"), ("theta_ref", lambda: 1)])
def test_an_error_has_name_and_value_and_is_pickled(name, value):
    with pytest.raises(ParameterError) as error:
        PitchHold(**{name: value})
    assert (error.value.parameter, error.value.value) == (name, value)
    again = pickle.loads(pickle.dumps(error.value))
    expected = type(error.value), name, str(error.value)
    assert (type(again), again.parameter, str(again)) == expected


@pytest.mark.parametrize("name", BLOCKS)
def test_port_names_can_be_told_apart_in_the_editor(name):
    for side in ("input_port_labels", "output_port_labels"):
        ports, shown = getattr(BLOCKS[name], side), BLOCKS[name].info()[side]
        if ports is None:
            assert shown is None
            continue
        # PathView cuts port names to 8 characters
        assert max(map(len, shown), default=0) <= 8
        assert [*shown.values()] == [*ports.values()]


def test_no_name_is_a_module_and_something_else():
    for part in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
        folder, _, name = part.name.rpartition(".")
        module = importlib.import_module(part.name)
        assert getattr(importlib.import_module(folder), name) is module, part.name


# lines of code; what goes on in one function fits on a screen
LONGEST = 60


def lines_of_code(file, function):
    """Lines of a function without its docstring, comments and empty lines."""
    lines = (SOURCE / file).read_text(encoding="utf-8").splitlines()
    body = set(range(function.lineno, function.end_lineno + 1))
    if ast.get_docstring(function) is not None:
        body -= set(range(function.body[0].lineno, function.body[0].end_lineno + 1))
    return sum(bool(re.match(r"\s*[^\s#]", lines[i - 1])) for i in body)


def test_a_function_fits_on_a_screen_and_units_and_the_refusal_of_a_parameter_stand_once():
    # m per ft; m per nautical mile; ft/s, m/s and km/h per kt
    units = (0.3048, 1852, 1.68781, 0.514444, 1.852)
    long, with_units, raising = {}, set(), set()
    for file, node in nodes():
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
            if node.end_lineno - node.lineno >= LONGEST:
                long[f"{file}:{node.name}"] = lines_of_code(file, node)
        elif isinstance(node, ast.Constant) and isinstance(node.value, float):
            if any(abs(node.value / unit - 1) < 1e-4 for unit in units):
                with_units.add(file)
        elif isinstance(node, ast.Raise) and "ParameterError" in ast.dump(node.exc or node):
            raising.add(file)
    assert {name: size for name, size in long.items() if size > LONGEST} == {}
    assert with_units == {"_core/units.py"}
    assert raising == {"_core/checks.py"}


# participles and adverbs: variables are nouns of the domain
WORDS = {"found", "given", "known", "wanted", "kept", "seen", "made", "here", "there", "near",
         "shown", "whole", "told", "said"}  # fmt: skip
MOST = 9  # keywords and arguments whose names are public, such as `near`


def test_variables_are_nouns():
    names = [getattr(node, "id", getattr(node, "arg", "")) for _, node in nodes()]
    assert sum(name in WORDS for name in names) <= MOST
