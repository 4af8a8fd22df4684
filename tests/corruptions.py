"""Seeded corruptions of files, and what a study makes of them."""

import random
from functools import partial
from pathlib import Path

from pathsim_jsbsim_blocks import BlocksError
from pathsim_jsbsim_blocks.studies.workers import run_parts


def corrupted(content, draw):
    """A copy of ``content`` with one fault: bytes changed, lost, doubled, inserted or moved."""
    i, j = sorted(draw.randrange(len(content)) for _ in range(2))
    j = min(j, i + draw.choice([1, 4, 64, len(content)]))
    return draw.choice(
        [
            lambda: content[:i] + bytes([content[i] ^ 1 << draw.randrange(8)]) + content[i + 1 :],
            lambda: (
                content[:i]
                + draw.choice(b"0123456789,.-\r\n\0").to_bytes(1, "big")
                + content[i + 1 :]
            ),
            lambda: content[:i],
            lambda: content[:i] + content[j:],
            lambda: content[:i] + content[i:j] + content[i:],
            lambda: content[:i] + draw.randbytes(draw.randrange(1, 9)) + content[i:],
            lambda: content[:i] + bytes(j - i) + content[j:],
            lambda: content[j:] + content[:j],
        ]
    )()


PARTS = [[x, x + 1] for x in range(0, 16, 2)]


def thirds(part):
    return [{"third": x / 3, "name": f"point {x}", "found": x != 3} for x in part]


run = partial(
    run_parts,
    thirds,
    PARTS,
    describe=str,
    title="thirds",
    job=lambda: {"study": "thirds"},
    jobs=1,
    progress=False,
    death={},
)


def resumed_from_corruptions(folder, seed, count):
    """Number of typed errors among ``count`` corruptions, all others gave the table."""
    draw = random.Random(seed)
    path = Path(folder) / "thirds.jsonl"
    table = run(resume=path)
    content, refused = path.read_bytes(), 0
    for _ in range(count):
        damaged = corrupted(content, draw)
        path.write_bytes(damaged)
        try:
            assert run(resume=path) == table
        except BlocksError:
            refused += 1
            assert path.read_bytes() == damaged
    return refused
