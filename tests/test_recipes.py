"""The recipes of CONTRIBUTING are followed in a copy of the tree, and its tests pass there."""

import inspect
import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from how_many import EXPORTED

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.control.holds import lateral

pytestmark = pytest.mark.long

ROOT = Path(__file__).parents[1]
LEFT_OUT = shutil.ignore_patterns(".git", ".venv*", "__pycache__", "site", ".*_cache")


@pytest.fixture
def tree(tmp_path):
    """A copy, in which commands run."""
    return Path(shutil.copytree(ROOT, tmp_path / "tree", ignore=LEFT_OUT))


def python(tree, *arguments):
    """Output of a command in the copy, which imports the package from there."""
    done = subprocess.run(
        [sys.executable, *arguments],
        cwd=tree,
        env={**os.environ, "PYTHONPATH": str(tree / "src"), "MPLBACKEND": "agg"},
        capture_output=True,
        text=True,
    )
    return done.returncode, done.stdout + done.stderr


def run_tests(tree, *arguments):
    # whole files, deep ones too
    options = "-q", "-p", "no:cacheprovider", "-m", "not long"
    status, said = python(tree, "-m", "pytest", *options, *arguments)
    assert status == 0, said[-3000:]


def edit(file, old, new):
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1, f"{file}: {old!r}"
    file.write_text(text.replace(old, new), encoding="utf-8")


def promise(tree, name):
    """Append what a class promises to the table."""
    table = tree / "tests" / "data" / "promises.json"
    show = f"""
import json, sys
sys.path.insert(0, "tests")
import pathsim_jsbsim_blocks, test_promises
print(json.dumps(test_promises.promise(pathsim_jsbsim_blocks.{name})))
"""
    status, said = python(tree, "-c", show)
    assert status == 0, said
    promises = json.loads(table.read_text())
    promises["blocks"][name] = json.loads(said)
    table.write_text(json.dumps(promises))


GUARDS = ("tests/test_conventions.py", "tests/test_promises.py", "tests/test_documentation.py")


def test_a_hold(tree):
    source = inspect.getsource(lateral.RollHold).replace("RollHold", "BankHold")
    file = tree / "src" / package.__name__ / "control" / "holds" / "lateral.py"
    edit(file, '__all__ = ["', '__all__ = ["BankHold", "')
    file.write_text(f"{file.read_text(encoding='utf-8')}\n\n@fill\n{source.removeprefix('@fill')}")
    stub = tree / "src" / package.__name__ / "__init__.pyi"
    line = "from .control.holds.lateral import HeadingHold as HeadingHold\n"
    edit(stub, line, line.replace("HeadingHold", "BankHold") + line)
    _, said = python(tree, "-m", "pytest", "-q", "-p", "no:cacheprovider", *GUARDS)
    # each names a place of step 4
    assert set(re.findall(r"^FAILED .*::(\w+)", said, re.M)) == {
        "test_every_block_is_in_the_table",
        "test_the_block_reference_has_every_public_name",
        "test_pages_have_every_folder_and_every_hold",
        "test_generated_pages_are_current_and_made_by_one_command",
    }
    promise(tree, "BankHold")
    edit(
        tree / "docs" / "reference" / "control.rst",
        ".. autoclass:: RollHold\n",
        ".. autoclass:: RollHold\n\n.. autoclass:: BankHold\n",
    )
    page = tree / "docs" / "autopilots.md"
    (row,) = [line for line in page.read_text("utf-8").splitlines() if "| `RollHold` |" in line]
    edit(page, row, f"{row}\n{row.replace('RollHold', 'BankHold')}")
    status, said = python(tree, "docs/generate.py", "pages")
    assert status == 0, said
    places = ("BankHold", "table", "reference", "every_hold", "generated")
    again = ("tests/control/test_gains.py", "tests/linear/test_every_block.py", *GUARDS)
    run_tests(tree, *again, "-k", " or ".join(places))


def test_a_diagram(tree):
    pytest.importorskip("playwright")
    pytest.importorskip("pathview")
    folder = tree / "diagrams" / "beyond"
    text = (folder / "heading_hold.py").read_text(encoding="utf-8")
    (folder / "heading_trial.py").write_text(text.replace("heading_hold", "heading_trial"))
    status, said = python(tree, "docs/add_diagram.py", "heading_trial")
    assert status == 0, said
    assert (folder / "heading_trial.pvm").is_file()
    count = len(list(folder.parent.glob("*/*.py")))
    edit(tree / "README.md", f"all {count - 1} diagrams", f"all {count} diagrams")
    guards = ("tests/test_documentation.py", "tests/test_catalogue.py")
    run_tests(tree, *guards, "-k", "heading_trial or diagram or generated or links or readme")
    run_tests(tree, "tests/pathview/test_committed.py", "-k", "heading_trial or every_model")


def test_a_port(tree):
    pytest.importorskip("pathview")
    flight = tree / "src" / package.__name__ / "flight"
    edit(
        flight.parent / "_core" / "aircraft_ports.py",
        '"thr_sat"), EXCESS),\n',
        '"thr_sat"), EXCESS),\n    "ny": Port("accelerations/Ny"),\n',
    )
    for file in (flight / "aircraft.py", flight.parent / "linear" / "aircraft.py"):
        edit(file, "    nx, nz\n", "    nx, ny, nz\n")
    promise(tree, "Aircraft")
    promise(tree, "LinearAircraft")
    run_tests(tree, *GUARDS, "tests/linear/test_every_block.py", "-k", "Aircraft or generated")
    for script in (tree / "diagrams").glob("*/*.py"):
        if script.stem not in EXPORTED:  # a tenth of the models takes a tenth of the time
            script.unlink()
            script.with_suffix(".pvm").unlink()
    status, said = python(tree, "docs/add_diagram.py", "--models")
    assert status == 0, said
    run_tests(tree, "tests/pathview/test_committed.py", "-m", "not long", "-n", "2")
