"""Many corruptions of a checkpoint: each loads the same flight or is refused."""

import pytest
from corruptions import loaded_from_corruptions


@pytest.mark.long
def test_corrupted_checkpoints(tmp_path):
    seed, count = 20, 300
    refused = loaded_from_corruptions(tmp_path, seed, count)
    print(
        f"checkpoints, seed {seed}: {count} corruptions, {refused} refused, "
        f"{count - refused} flew the same flight"
    )
