"""Models written by version 0.2.0 fly as they did: their last rows are in ``data/v0_2_0/flown.json``."""

import csv
import json
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.cli import main

FOLDER = Path(__file__).parent / "data" / "v0_2_0"
FLOWN = json.loads((FOLDER / "flown.json").read_text())


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:.*the landing gear is down")
@pytest.mark.parametrize("model", FLOWN)
def test_a_model_flies_the_same(model, tmp_path):
    table = tmp_path / "flight.csv"
    assert main(["run", str(FOLDER / model), "--trust", "--csv", str(table)]) == 0
    *_, last = csv.DictReader(table.read_text().splitlines())
    # the default trim is another search since, which ends within 1e-4 of a command's travel
    assert {name: float(value) for name, value in last.items()} == {
        name: pytest.approx(value, rel=2e-3, abs=2e-2) for name, value in FLOWN[model].items()
    }
