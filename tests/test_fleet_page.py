"""The page on the fleet, and the documentation's tool that makes its table."""

import importlib
import math
from pathlib import Path

import pytest
from fleet_conditions import FLYING, NOT_FLYING

from pathsim_jsbsim_blocks.flight import aircraft_names

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture
def fleet(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    return importlib.import_module("fleet_table")


def test_an_aircraft_that_does_not_stay_level_is_no_success(fleet):
    # 20 deg of bank after 30 s
    (row,) = fleet.fleet_table(["DHC6"])
    assert row.drift < -100.0
    assert row.verdict == "trims, then departs"


def test_rows_of_the_table(fleet):
    flies, created, refused, broken = fleet.fleet_table(["c172p", "L17", "SGS", "blank"],
                                                        duration=2.0)
    line = fleet.format_row(flies)
    assert line.startswith("| c172p | 1 | 5000 | 89 | as is | 1.39 | 0.690 | +0.0 |")
    assert created.verdict == "trims with `fcs/flaps-pos-deg` created"
    assert refused.verdict == "no trim: thrust"
    assert math.isnan(refused.drift)
    assert broken.verdict == "does not load"
    assert broken.engines is None


def test_the_page_is_up_to_date():
    page = (DOCS / "fleet.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")[1:-1]]
            for line in page.splitlines() if line.startswith("| ")][1:]
    assert [row[0] for row in rows] == aircraft_names()
    for name, _, altitude, speed, *_, verdict in rows:
        if name in FLYING:
            assert (float(altitude), float(speed)) == FLYING[name][:2]
            assert verdict.startswith("trims")
        else:
            assert verdict in (f"no trim: {NOT_FLYING[name]}", "does not load")
