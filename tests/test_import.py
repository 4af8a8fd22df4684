"""What an import loads, and what the package offers before and after it has loaded."""

import sys

import pytest
from test_without_jsbsim import run

# each imported in the same process after the one before; pathsim takes ten times as long as the rest
STEPS = """
import contextlib, io, json, sys
def now():
    return sorted({name.partition(".")[0] for name in sys.modules})
loaded = [now()]
from pathsim_jsbsim_blocks.cli import main
with contextlib.redirect_stdout(io.StringIO()) as printed:
    with contextlib.suppress(SystemExit):
        main(["--help"])
    loaded.append(now())
    import pathsim_jsbsim_blocks.studies
    main(["trim", "c172p", "--speed", "90"])
    loaded.append(now())
import pathsim_jsbsim_blocks.pathview
from pathsim_jsbsim_blocks import Aircraft
print(json.dumps([printed.getvalue(), *loaded, now()]))
"""
# pathsim itself brings numpy, scipy and matplotlib.pyplot
HEAVY = "pandas joblib dask pathview flask docutils gymnasium"


def test_nothing_heavy_is_imported_before_it_is_needed():
    printed, before, by_help, by_trim, by_import = run(STEPS)
    assert "trim an aircraft" in printed
    assert "alpha" in printed
    assert {*by_help} - {*before} - sys.stdlib_module_names == {
        "lazy_loader",
        "pathsim_jsbsim_blocks",
    }
    assert {"pathsim", "scipy", "pandas", "joblib"}.isdisjoint(by_trim)
    assert "pathsim" in by_import
    assert {*HEAVY.split()}.isdisjoint(by_import)


ASKED = """
import json, sys
import pathsim, pathsim_flight

def forget():
    for name in [n for n in sys.modules if n.partition(".")[0] == "pathsim_jsbsim_blocks"]:
        del sys.modules[name]

offered = []
for first in (
    "dir(package)",
    "from pathsim_jsbsim_blocks import *\\nAircraft, fly, PitchHold",
    "from pathsim_jsbsim_blocks.control.holds import PitchHold",
    "import pathsim_jsbsim_blocks.studies",
):
    forget()
    import pathsim_jsbsim_blocks as package
    assert "Aircraft" not in vars(package)
    exec(first, {"package": package})
    offered.append([dir(package), sorted(package.__all__)])

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
print(json.dumps([offered, replaced, said]))
"""


@pytest.mark.long
def test_names_of_the_package_whatever_is_asked_first():
    offered, replaced, said = run(ASKED)
    shown, names = offered[0]
    assert len(shown) > 30
    assert names == shown
    assert offered == [offered[0]] * 4
    # a name that was replaced stays so
    assert replaced == ["Aircraft", "before the package loads", "after it", replaced[1]]
    # a name that is not there
    assert said[0].startswith("cannot import name 'Aircaft' from 'pathsim_jsbsim_blocks'")
    assert said[1:3] == ["module 'pathsim_jsbsim_blocks' has no attribute 'Aircaft'", "Aircaft"]
    assert said[3].startswith("cannot import name 'Airframes' from 'pathsim_jsbsim_blocks.flight'")


LOADED = """
import json, sys
from pathsim_jsbsim_blocks import DoubletSource, fly
ours = {n: m for n, m in sys.modules.items() if n.partition(".")[0] == "pathsim_jsbsim_blocks"}
lines = sum(len(open(m.__file__, encoding="utf-8").readlines()) for m in ours.values())
print(json.dumps([[*ours], lines]))
"""


def test_a_source_and_fly_load_little_of_the_package():
    modules, lines = run(LOADED)
    assert lines <= 2500
    core = "pathsim_jsbsim_blocks._core."
    assert {f"{core}sampling", f"{core}continuous", f"{core}aircraft_ports"}.isdisjoint(modules)
