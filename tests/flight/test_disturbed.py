"""Random diagrams keep time while they are looked at, ended in mid-run and changed."""

import pytest
from disturbed_diagrams import fly_disturbed


@pytest.mark.parametrize("first", range(0, 200, 20))
def test_disturbed_diagrams(first):
    for seed in range(first, first + 20):
        fly_disturbed(seed)


@pytest.mark.long
def test_two_thousand_disturbed_diagrams():
    ended = sum(fly_disturbed(seed) for seed in range(1000, 3000))
    print(f"disturbed diagrams, seeds 1000 to 2999: 2000 diagrams, {ended} runs ended in mid-step")
