"""Many mutated models, in full 20,000: nothing executes, and no script says something else."""

import pytest
from how_many import bounded
from mutated_models import convert_mutants

pytest.importorskip("pathview")


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 1 + bounded(2, 10)))
def test_mutated_models_execute_nothing(seed, tmp_path):
    convert_mutants(2_000, seed, tmp_path)
