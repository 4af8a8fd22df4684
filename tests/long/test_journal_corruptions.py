"""Many corruptions of a study's file: each gives the same table or a typed error."""

import pytest
from corruptions import resumed_from_corruptions


@pytest.mark.long
def test_corrupted_files_of_a_study(tmp_path):
    seed, count = 20, 300
    refused = resumed_from_corruptions(tmp_path, seed, count)
    print(
        f"journal, seed {seed}: {count} corruptions, {refused} refused, "
        f"{count - refused} gave the same table"
    )
