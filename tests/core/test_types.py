"""What type checkers know of the parameters of blocks."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

# PathSim has no types: without its sources a block could be anything to mypy
CONFIGURATION = """\
[mypy]
ignore_missing_imports = True
disable_error_code = has-type

[mypy-pathsim.*]
follow_untyped_imports = True

[mypy-pathsim_jsbsim_blocks.*]
follow_imports = silent
"""

SCRIPT = """\
from dataclasses import dataclass

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, JSBSimFDM, LinearAircraft, PitchHold

PitchHold("737", theta_ref=3.0, T=0.02)
PitchHold(theta_rf=3.0)  # unexpected
PitchHold(theta_ref="up")  # incompatible
PitchHold().theta_rf = 3.0  # has no attribute
PitchHold().theta_ref = "up"  # incompatible
PitchHold().theta_ref = 3.0
Aircraft("c172p", altitude=5000, speed=90, output_properties=["h_agl"])
Aircraft("c172p", altitud=5000)  # unexpected
DoubletSource(0.2, width=2.0)
DoubletSource(amplitud=0.2)  # unexpected
JSBSimFDM(1 / 60, ["fcs/elevator-cmd-norm"], aircraft_model="c172p")
JSBSimFDM(aircraft="c172p")  # unexpected
LinearAircraft("c172p", method="algebraic")
LinearAircraft(model=None)  # unexpected


@dataclass(eq=False)
class Wider(PitchHold):
    width: float = 3.0


Wider(theta_ref=3.0, width=2.0).width = 4.0
Wider(widht=2.0)  # unexpected
"""


@pytest.mark.long
def test_mypy_reports_a_misspelt_keyword_and_none_in_the_diagrams(tmp_path):
    api = pytest.importorskip("mypy.api")
    script, configuration = tmp_path / "script.py", tmp_path / "mypy.ini"
    script.write_text(SCRIPT)
    configuration.write_text(CONFIGURATION)
    files = [str(script), str(ROOT / "diagrams")]
    said, _, _ = api.run(
        [
            "--config-file",
            str(configuration),
            "--cache-dir",
            str(ROOT / ".mypy_cache/users"),
            *files,
        ]
    )
    found = {
        int(number): kind
        for number, kind in re.findall(
            r"script\.py:(\d+): error: .*?(nexpected|ncompatible|no attribute)", said
        )
    }
    meant = {
        number: re.search("nexpected|ncompatible|no attribute", line)[0]
        for number, line in enumerate(SCRIPT.splitlines(), 1)
        if "#" in line
    }
    assert found == meant, said
    assert said.count(" error: ") == len(meant), said
