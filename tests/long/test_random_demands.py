"""Some of the random demands of docs/demands.py, with every table of the fleet."""

from pathlib import Path

import pytest
from how_many import bounded

pytestmark = pytest.mark.long


def test_random_demands(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[2] / "docs")
    import demands

    flown = [demands.fly(case) for case in range(bounded(28, 1000))]
    kept = [missed in ("", "no trim") for _, missed, _ in flown]
    assert sum(kept) >= 0.9 * len(kept), [row for row in flown if row[1]]
