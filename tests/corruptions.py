"""Seeded corruptions of files, and what a study and a checkpoint make of them."""

import json
import math
import random
from functools import partial
from pathlib import Path

import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Integrator, Scope, Source

from pathsim_jsbsim_blocks import Aircraft, BlocksError, PitchHold
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
    died={},
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


def flight():
    """A diagram with blocks of ours and of PathSim, some in a subsystem, and its scope."""
    plane = Aircraft("c172p", altitude=5000, speed=90, record_inputs=True)
    hold, wobble = PitchHold(gains="c172p", theta_ref=3.0), Source(lambda t: math.sin(2 * t) / 50)
    port, integrator, scope = Interface(), Integrator(0.0), Scope()
    part = Subsystem(
        [port, integrator], [Connection(port, integrator), Connection(integrator, port)]
    )
    return Simulation(
        [hold, plane, wobble, part, scope],
        [
            Connection(plane["theta"], hold["theta"], part, scope[0]),
            Connection(plane["q"], hold["q"]),
            Connection(hold["elevator"], plane["elevator"]),
            Connection(wobble, plane["aileron"]),
            Connection(part, scope[1]),
        ],
        dt=1 / 120,
        log=False,
    ), scope


def changed_in_json(text, draw):
    """One value of a JSON file made another one, and the file written as it was."""
    data = json.loads(text)
    places = []

    def walk(node):
        for key, value in node.items() if isinstance(node, dict) else enumerate(node):
            places.append((node, key))
            if isinstance(value, (dict, list)):
                walk(value)

    walk(data)
    node, key = draw.choice(places)
    value = node[key]
    if isinstance(node, dict) and draw.random() < 0.2:
        del node[key]
    elif isinstance(value, bool) or value is None:
        node[key] = draw.choice([not value, 1.0, "x"])
    elif isinstance(value, (int, float)):
        node[key] = draw.choice([value + 1, -value - 1, value * 2 + 1e-9, None, "x", math.nan])
    else:
        node[key] = draw.choice([None, {}, [], "x", 3])
    return json.dumps(data, indent=2)


def loaded_from_corruptions(folder, seed, count):
    """Number of typed errors among ``count`` corruptions, all others flew the same flight."""
    draw = random.Random(seed)
    whole, scope = flight()
    whole.run(0.5)
    base = Path(folder) / "flight"
    files = base.with_suffix(".json"), base.with_suffix(".npz")
    whole.save_checkpoint(str(base))
    whole.run(0.5)
    recorded, contents, refused = scope.read(), [file.read_bytes() for file in files], 0
    for _ in range(count):
        which = draw.randrange(3)
        if which == 2:
            files[0].write_text(changed_in_json(contents[0], draw))
        else:
            files[which].write_bytes(corrupted(contents[which], draw))
        again, other = flight()
        try:
            again.load_checkpoint(str(base))
        except BlocksError:
            refused += 1
            assert again.time == 0.0
        else:
            again.run(0.5)
            assert all(map(np.array_equal, other.read(), recorded))
        for file, content in zip(files, contents, strict=True):
            file.write_bytes(content)
    return refused
