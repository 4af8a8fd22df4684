"""What type checkers know of the parameters of blocks."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

SCRIPT = """\
from dataclasses import dataclass

from pathsim_jsbsim_blocks import (
    Aircraft,
    CAStoTAS,
    DoubletSource,
    JSBSimFDM,
    LinearAircraft,
    PitchHold,
)
from pathsim_jsbsim_blocks.design import design_gains, design_schedule
from pathsim_jsbsim_blocks.flight import TrimCondition, linear_model

PitchHold("737", theta_ref=3.0, T=0.02)
PitchHold(theta_rf=3.0)  # unexpected
PitchHold(theta_ref="up")  # incompatible
PitchHold().theta_rf = 3.0  # has no attribute
PitchHold().theta_ref = "up"  # incompatible
PitchHold().theta_ref = 3.0
Aircraft("c172p", altitude=5000, speed=90, output_properties=["h_agl"])
Aircraft("c172p", altitud=5000)  # unexpected
DoubletSource(amplitud=0.2)  # unexpected
JSBSimFDM(aircraft="c172p")  # unexpected
LinearAircraft(model=None)  # unexpected
CAStoTAS(altitude_knd="geometric")  # unexpected
design_gains("c172p", create="missing", root=None)
design_gains("c172p", creat="missing")  # unexpected
design_gains("c172p", create=3)  # incompatible
design_schedule("c172p", TrimCondition(), [5000], [90], T=0.02, setup={})
design_schedule("c172p", TrimCondition(), [5000], [90], substep=2)  # unexpected
linear_model("c172p", alow_files=True)  # unexpected


@dataclass(eq=False)
class Wider(PitchHold):
    width: float = 3.0


Wider(theta_ref=3.0, width=2.0).width = 4.0
Wider(widht=2.0)  # unexpected
"""


def mypy(*arguments):
    """Exit status and report, of a process of its own: mypy raises Python's limit of recursion."""
    pytest.importorskip("mypy")
    command = [sys.executable, "-m", "mypy", *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.long
def test_mypy_without_configuration_reports_a_misspelt_keyword(tmp_path, monkeypatch):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    monkeypatch.setenv("MYPYPATH", str(ROOT / "src"))
    cache = ROOT / ".mypy_cache" / "users"
    _, report = mypy("--config-file=", "--cache-dir", cache, script)
    kinds = r"(nexpected keyword|ncompatible type|no attribute)"
    errors = re.findall(rf"script\.py:(\d+): error: .*?{kinds}", report)
    expected = [
        (str(number), kind)
        for number, line in enumerate(SCRIPT.splitlines(), 1)
        for kind in ("nexpected keyword", "ncompatible type", "no attribute")
        if kind.split()[0] in line.partition("#")[2]
    ]
    assert errors == expected, report


@pytest.mark.long
def test_mypy_reports_nothing_in_the_diagrams():
    status, report = mypy("--config-file", ROOT / "pyproject.toml", ROOT / "diagrams")
    assert status == 0, report
