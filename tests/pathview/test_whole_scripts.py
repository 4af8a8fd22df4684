"""Whole scripts of users become models that fly as they do; their files are in tests/data/scripts.

One of each kind: nested subsystems, events that set blocks, a module beside the script, a file, a
Jacobian, a steady state, classes, a state machine, vectors.
"""

import shutil
import sys
import warnings
from pathlib import Path

import pytest
from how_many import first
from oracle import assert_equal, first_run

from pathsim_jsbsim_blocks.pathview import convert_model, export_script

FOLDER = Path(__file__).parents[1] / "data" / "scripts"
NAMES = sorted(path.stem for path in FOLDER.glob("[0-9]*.py"))
ALWAYS = ("36_two_tanks_class_sim", "52_thermostat_state_machine", "68_local_package")


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # of a script that ends in NaN
@pytest.mark.parametrize("name", first([*ALWAYS, *(n for n in NAMES if n not in ALWAYS)], 3))
def test_a_whole_script_becomes_a_model_that_flies_as_it_does(name, tmp_path, monkeypatch):
    folder = tmp_path / "scripts"
    shutil.copytree(FOLDER, folder)
    monkeypatch.chdir(folder)  # some name a file beside them
    script = folder / f"{name}.py"
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*the model is the diagram of the first run")
        model = export_script(script, tmp_path / "model.pvm")
    again = convert_model(model, tmp_path / "again.py")
    monkeypatch.chdir(tmp_path)  # the model needs no file
    there = first_run(again, monkeypatch)
    monkeypatch.chdir(folder)
    monkeypatch.syspath_prepend(str(folder))
    try:
        # `steadystate` samples before its last iteration
        skip = "steadystate" in name
        assert_equal(first_run(script, monkeypatch), there, skip)
    finally:
        sys.modules.pop("plantlib", None)
