"""What an import loads."""

import sys

import pytest
from test_without_jsbsim import run

import pathsim_jsbsim_blocks as package

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


def test_a_name_that_is_not_there():
    with pytest.raises(AttributeError, match="blocks' has no attribute 'Aircaft'") as error:
        package.Aircaft  # noqa: B018
    # Python itself adds both, and looks among the names of the object: "Did you mean: 'Aircraft'?"
    assert (error.value.name, error.value.obj) == ("Aircaft", package)
    with pytest.raises(ImportError, match="cannot import name 'Airframes' from"):
        from pathsim_jsbsim_blocks.flight import Airframes  # noqa: F401


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
