"""Random diagrams keep time while they are looked at, ended in mid-run and changed."""

import pytest
from disturbed_diagrams import fly_disturbed
from how_many import bounded, first


@pytest.mark.parametrize("start", first(range(0, 100, 20), count=2))
def test_disturbed_diagrams(start):
    for seed in range(start, start + 20):
        fly_disturbed(seed)


@pytest.mark.long
def test_many_disturbed_diagrams():
    count = bounded(600, 2000)
    ended = sum(fly_disturbed(seed) for seed in range(1000, 1000 + count))
    print(f"disturbed diagrams, seeds from 1000: {count} diagrams, {ended} runs ended in mid-step")
