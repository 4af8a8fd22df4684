"""Random diagrams keep time while they are looked at, ended in mid-run and changed."""

import pytest
from disturbed_diagrams import fly_disturbed
from how_many import bounded


@pytest.mark.parametrize("count", [6, pytest.param(bounded(120, 400), marks=pytest.mark.long)])
def test_disturbed_diagrams(count):
    for seed in range(count):
        fly_disturbed(seed)
