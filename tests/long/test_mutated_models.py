"""20,000 mutated models: nothing executes, and no script says something else."""

import pytest
from mutated_models import convert_mutants

pytest.importorskip("pathview")


@pytest.mark.long
@pytest.mark.parametrize("seed", range(1, 11))
def test_mutated_models_execute_nothing(seed, tmp_path):
    convert_mutants(2_000, seed, tmp_path)
