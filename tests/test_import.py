"""What an import loads, and what the package offers before and after it has loaded."""

import sys

import pytest
from test_without_jsbsim import run


def fresh(code):
    """The JSON that a process of its own prints."""
    return run(f"import json, sys\n{code}")


LOADED = 'sorted({name.partition(".")[0] for name in set(sys.modules) - before})'


def test_the_commands_help_brings_only_the_standard_library():
    # importing pathsim takes ten times as long as all the rest
    printed, brought = fresh(f"""
import contextlib, io
before = set(sys.modules)
from pathsim_jsbsim_blocks.cli import main
with contextlib.redirect_stdout(io.StringIO()) as printed, contextlib.suppress(SystemExit):
    main(["--help"])
print(json.dumps([printed.getvalue(), {LOADED}]))
""")
    assert "trim an aircraft" in printed
    assert set(brought) - sys.stdlib_module_names == {"pathsim_jsbsim_blocks"}


def test_trims_do_without_pathsim():
    printed, brought = fresh(f"""
import contextlib, io
before = set(sys.modules)
import pathsim_jsbsim_blocks.studies
from pathsim_jsbsim_blocks.cli import main
with contextlib.redirect_stdout(io.StringIO()) as printed:
    main(["trim", "c172p", "--speed", "90"])
print(json.dumps([printed.getvalue(), {LOADED}]))
""")
    assert "alpha" in printed
    assert {"pathsim", "scipy", "pandas", "joblib"}.isdisjoint(brought)


@pytest.fixture(scope="module")
def asked():
    """What each of these finds in a package that was not imported before.

    In one process: what takes long to import is not this package.
    """
    return fresh(f"""
import pathsim, pathsim_flight

def forget():
    for name in [n for n in sys.modules if n.partition(".")[0] == "pathsim_jsbsim_blocks"]:
        del sys.modules[name]

before = set(sys.modules)
from pathsim_jsbsim_blocks import Aircraft
brought = {LOADED}

offered = []
for first in (
    "dir(package)",
    "from pathsim_jsbsim_blocks import *\\nAircraft, fly, PitchHold",
    "package.control.holds.PitchHold",
    "import pathsim_jsbsim_blocks.studies",
):
    forget()
    import pathsim_jsbsim_blocks as package
    assert "Aircraft" not in vars(package)
    exec(first, {{"package": package}})
    offered.append([dir(package), sorted(package.__all__), sorted({{*vars(package)}} & {{*dir(package)}})])

forget()
import pathsim_jsbsim_blocks as package
replaced = []
package.fly = "before the package loads"
replaced += [package.Aircraft.__name__, package.fly]
package.Aircraft = "after it"
hasattr(package, "Aircaft"), dir(package)
replaced += [package.Aircraft, package.fly]

forget()
said = []
try:
    from pathsim_jsbsim_blocks import Aircaft
except ImportError as error:
    said.append(str(error))
try:
    import pathsim_jsbsim_blocks
    pathsim_jsbsim_blocks.Aircaft
except AttributeError as error:
    said += [str(error), error.name]
try:
    from pathsim_jsbsim_blocks.flight import Aircraft, Airframes
except ImportError as error:
    said.append(str(error))
print(json.dumps([brought, offered, replaced, said]))
""")


def test_the_import_brings_no_heavy_module(asked):
    # pathsim itself brings numpy, scipy and matplotlib.pyplot
    heavy = [
        "pandas",
        "joblib",
        "dask",
        "pathview",
        "flask",
        "pymap3d",
        "docutils",
        "tqdm",
        "gymnasium",
    ]
    brought = asked[0]
    assert "pathsim_jsbsim_blocks" in brought
    assert set(brought).isdisjoint(heavy)


def test_what_the_package_offers_is_there_whatever_is_asked_first(asked):
    dir_first, star_first, attribute_first, submodule_first = asked[1]
    assert len(dir_first[0]) > 30
    assert dir_first == star_first == attribute_first == submodule_first
    assert dir_first[0] == dir_first[1] == dir_first[2]


def test_a_name_that_was_replaced_stays_so(asked):
    replaced = asked[2]
    assert replaced == ["Aircraft", "before the package loads", "after it", replaced[1]]


def test_a_name_that_is_not_there(asked):
    said = asked[3]
    assert said[0].startswith("cannot import name 'Aircaft' from 'pathsim_jsbsim_blocks'")
    assert said[1:3] == ["module 'pathsim_jsbsim_blocks' has no attribute 'Aircaft'", "Aircaft"]
    assert said[3].startswith("cannot import name 'Airframes' from 'pathsim_jsbsim_blocks.flight'")
