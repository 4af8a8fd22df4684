"""Scripts and models written for version 0.2.0 fly as they did, or end with the way on.

The numbers are those that version 0.2.0 printed, and the last rows of the tables that its
``run --csv`` wrote (``data/v0_2_0/flown.json``).
"""

import csv
import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.cli import main

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "tests" / "data" / "v0_2_0"
FLOWN = json.loads((FOLDER / "flown.json").read_text())

# what is gone: the error names it, and "Removed" in CHANGELOG.md says what to do instead
GONE = {
    "as_xml.py": "to_jsbsim_xml",
    "systems.py": "systems",
    "curves.py": "exact_curves",
    "own_aircraft.py": "write_aircraft",
    "restored.py": "restart",
    "checkpoint.py": "record_inputs",
    "thinned.py": "thinned",
}


def near(values):
    # the default trim is another search since, which ends within 1e-4 of a command's travel
    return pytest.approx(values, rel=2e-3, abs=2e-2)


def run(script, folder):
    return subprocess.run(
        [sys.executable, str(FOLDER / script)],
        capture_output=True,
        text=True,
        cwd=folder,
        env={**os.environ, "MPLBACKEND": "agg"},
    )


def test_every_script_and_model_is_tested():
    assert {p.name for p in FOLDER.glob("*.py")} == {n for n in FLOWN if n[-3:] == ".py"} | {*GONE}
    assert [len([*FOLDER.glob(kind)]) for kind in ("*.py", "*.pvm")] == [20, 20]


@pytest.mark.long
@pytest.mark.parametrize("script", [name for name in FLOWN if name.endswith(".py")])
def test_a_script_prints_the_same(script, tmp_path):
    done = run(script, tmp_path)
    assert done.returncode == 0, done.stderr
    assert [float(x) for x in done.stdout.split()] == near(FLOWN[script])


@pytest.mark.long
@pytest.mark.parametrize(("script", "name"), GONE.items())
def test_what_is_gone_is_named_and_the_changelog_says_what_to_do(script, name, tmp_path):
    done = run(script, tmp_path)
    said = [
        s for s in done.stderr.splitlines() if re.match(r"\S*(Error|Warning)\b|.*: \w*Warning: ", s)
    ]
    assert any(name in line for line in said), done.stderr
    changes = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").partition("## [0.2.0]")[0]
    assert name in changes


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:.*the landing gear is down")
@pytest.mark.parametrize("model", [name for name in FLOWN if name.endswith(".pvm")])
def test_a_model_flies_the_same(model, tmp_path):
    table = tmp_path / "flight.csv"
    assert main(["run", str(FOLDER / model), "--trust", "--csv", str(table)]) == 0
    *_, last = csv.DictReader(table.read_text().splitlines())
    assert {name: float(value) for name, value in last.items()} == near(FLOWN[model])
