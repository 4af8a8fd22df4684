"""What every public name keeps to, and who may import whom."""

import ast
import inspect
import re
from pathlib import Path

import pytest
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks import BlocksError

SOURCE = Path(package.__file__).parent
PUBLIC = {n: o for n, o in vars(package).items()
          if inspect.isclass(o) and o.__module__.startswith(package.__name__)}
BLOCKS = {n: o for n, o in PUBLIC.items() if issubclass(o, Block)}
DATA = {n: o for n, o in PUBLIC.items() if n in ("TrimCondition", "TrimState")}


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


def test_there_are_blocks():
    assert len(BLOCKS) > 20


@pytest.mark.parametrize("name", BLOCKS)
def test_a_port_that_does_not_exist_is_refused(name):
    block = BLOCKS[name]()
    with pytest.raises(BlocksError, match="no port 'no_such_port'"):
        block["no_such_port"]
    for known in [*block.inputs._mapping, *block.outputs._mapping]:
        with pytest.raises(BlocksError, match=f"did you mean .*{known!r}"):
            block[0, known + "_"]


@pytest.mark.parametrize("name", PUBLIC)
def test_a_public_name_has_a_one_line_summary(name):
    summary, _, rest = inspect.getdoc(PUBLIC[name]).partition("\n")
    assert 10 < len(summary) <= 120
    assert summary.endswith(".") or name.endswith("Error")
    assert rest == "" or rest.startswith("\n")


@pytest.mark.parametrize("name", [*BLOCKS, *DATA])
def test_parameters_are_documented_and_no_others(name):
    text = inspect.getdoc({**BLOCKS, **DATA}[name])
    title = "Attributes" if name == "TrimState" else "Parameters"
    assert documented(section(text, title)) == set(parameters({**BLOCKS, **DATA}[name]))


@pytest.mark.parametrize("name", BLOCKS)
def test_each_parameter_has_a_text_of_its_own(name):
    # PathView's dialog shows the text of a shared line at the last name only
    text = section(inspect.getdoc(BLOCKS[name]), "Parameters")
    assert not re.findall(r"^\w+, .*", text, re.M)


@pytest.mark.parametrize("name", [n for n in BLOCKS if n != "JSBSimFDM"])
def test_ports_are_documented(name):
    block = BLOCKS[name]
    text = inspect.getdoc(block)
    assert documented(section(text, "Inputs")) == set(block.input_port_labels)
    assert documented(section(text, "Outputs")) == set(block.output_port_labels)


@pytest.mark.parametrize("name", BLOCKS)
def test_parameters_are_kept_as_attributes(name):
    block = BLOCKS[name]()
    for parameter in parameters(BLOCKS[name]):
        default = inspect.signature(BLOCKS[name].__init__).parameters[parameter].default
        value = getattr(block, parameter)
        kept = value is None or value == default or list(value) == list(default or [])
        assert kept, f"{parameter} is {value!r}, not {default!r}"


@pytest.mark.parametrize("name", [*BLOCKS, *DATA])
def test_unknown_keywords_are_refused(name):
    with pytest.raises(TypeError, match="no_such_parameter"):
        {**BLOCKS, **DATA}[name](no_such_parameter=1)


@pytest.mark.parametrize("name", BLOCKS)
def test_port_names_can_be_told_apart_in_the_editor(name):
    # PathView cuts port names to 8 characters
    for labels in (BLOCKS[name].input_port_labels, BLOCKS[name].output_port_labels):
        shown = [label[:8] for label in labels or ()]
        assert len(set(shown)) == len(shown)


FLOORS = [  # each may import what stands above it, and its own floor
    {"errors"},
    {"checks", "catalogue", "console", "ports"},
    {"sampling", "atmosphere", "sources", "axes", "plots"},
    {"airframe", "airspeed", "atmosphere_blocks", "trim_condition"},
    {"trim", "airspeed_blocks", "calibrated_airspeed_blocks", "control"},
    {"fdm"},
    {"aircraft", "fleet"},
    {"studies", "pathview"},
    {"cli"},
]


def imported_modules(path):
    """Modules of this package that a file imports, by their first name."""
    depth = len(path.relative_to(SOURCE).parts)
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == depth:
            names = [node.module.split(".")[0]] if node.module else [a.name for a in node.names]
            yield from names
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith(
                package.__name__ + "."):
            yield node.module.split(".")[1]


def floor(module):
    return next((i for i, names in enumerate(FLOORS) if module in names), None)


FILES = [p for p in sorted(SOURCE.rglob("*.py")) if p != SOURCE / "__init__.py"
         and "diagrams" not in p.relative_to(SOURCE).parts]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_no_import_upward_in_the_house(path):
    module = path.relative_to(SOURCE).parts[0].removesuffix(".py")
    assert floor(module) is not None, f"{module} has no floor in the house"
    for other in imported_modules(path):
        if floor(other) is not None:
            assert floor(other) <= floor(module), f"{module} imports {other}"
        if module == "pathview":
            # the bridge knows blocks only through Block.info() and the live diagram
            assert other in ("pathview", "errors", "checks", "catalogue", "__version__"), other


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_a_file_holds_one_idea(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 420
