"""The flights behind docs/monte-carlo.md."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from pathsim_jsbsim_blocks.studies import run_batch

DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture
def monte_carlo(monkeypatch):
    monkeypatch.syspath_prepend(DOCS)
    import monte_carlo

    yield monte_carlo
    sys.modules.pop("monte_carlo")


def rows():
    """Cells of the page's table by the name of the row."""
    lines = re.findall(r"^\| (.*) \|$", (DOCS / "monte-carlo.md").read_text(encoding="utf-8"), re.M)
    return {cells[0]: cells[1:] for cells in (line.split(" | ") for line in lines)}


def test_the_first_cases_are_within_what_the_page_says(monte_carlo):
    table = rows()
    for column, name in enumerate(table["median / worst of"][:-1]):
        cases = monte_carlo.draw(name, 100)[:2]
        found = run_batch(monte_carlo.flight, cases, jobs=1, progress=False)
        assert found.completed.all()
        for key, (label, limit) in monte_carlo.LIMITS.items():
            worst = float(table[label][column].split(" / ")[1])
            assert 0.0 < found[key].max() < worst + 0.06, (name, label)
            assert float(table[label][-1]) == limit


def test_almost_all_cases_are_within_all_limits():
    for cell in rows()["within all limits"][:-1]:
        inside, cases = map(int, cell.split(" of "))
        assert cases == 100
        assert inside >= 95
