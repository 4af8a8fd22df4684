"""Seeds of a batch reach all that is random in a script."""

import numpy as np
import pandas as pd
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import PinkNoise, Scope, WhiteNoise

from pathsim_jsbsim_blocks.studies import run_batch

HEAD = """
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import (
    Block, Constant, PinkNoise, RandomNumberGenerator, Scope, SinusoidalPhaseNoiseSource, WhiteNoise
)
from pathsim_jsbsim_blocks import DrydenTurbulence, Sensor
DURATION = 0.5
X = 1.0
one, scope = Constant(1.0), Scope()
"""
SIM = """
wires = [Connection(b, scope[i]) for i, b in enumerate([{0}])]
wires += [Connection(one, b[port]) for b in [{0}] for port in getattr(b, "measured", ())]
sim = Simulation([one, {0}, scope], wires, dt=0.1, log=False)
Y = X
"""


def recorded(module):
    return {"y": module.scope.read()[1].tolist()}


def batch(folder, blocks, cases, measure=recorded, sim=SIM, **options):
    """A batch of a script that builds ``blocks``, a dict of names and code."""
    script = folder / "own.py"
    code = "\n".join(f"{name} = {text}" for name, text in blocks.items())
    script.write_text(HEAD + code + sim.format(", ".join(blocks)))
    return run_batch(script, cases, measure=measure, jobs=1, progress=False, **options)


def children(seed, n):
    return [int(child.generate_state(1)[0]) for child in np.random.SeedSequence(seed).spawn(n)]


TURBULENT = {
    "turbulence": "DrydenTurbulence(T=0.1)",
    "first": "Sensor(noise=1.0, T=0.1)",
    "second": "Sensor(noise=1.0, seed=7, T=0.1)",
}


def test_every_seeded_block_gets_a_seed_of_its_own_from_that_of_the_row(tmp_path):
    names = list(TURBULENT)

    def seeds(module):
        return {**recorded(module), **{name: getattr(module, name).seed for name in names}}

    table = batch(tmp_path, TURBULENT, {"X": [1.0, 1.0, 1.0]}, seeds)
    assert table.columns.tolist() == ["X", "seed", "completed", "reason", "y", *names]
    for row in table.to_dict("records"):
        assert [row[name] for name in names] == children(row["seed"], 3)
        assert len({tuple(y) for y in row["y"]}) == 3
    assert len({str(y) for y in table.y}) == 3
    again = batch(tmp_path, TURBULENT, {"X": [1.0], "seed": [int(table.seed[1])]}, seeds)
    pd.testing.assert_series_equal(again.loc[0], table.loc[1], check_names=False)


@pytest.mark.parametrize("period", [None, 0.2])
@pytest.mark.parametrize("kind", [WhiteNoise, PinkNoise])
def test_noise_of_pathsim_is_as_if_built_with_the_seed(kind, period, tmp_path):
    built = f"{kind.__name__}(sampling_period={period})"
    table = batch(tmp_path, {"a": built, "b": built}, {"X": [1.0, 1.0]})
    assert table.y[0] != table.y[1]
    for row in table.itertuples():
        a, b = (kind(sampling_period=period, seed=seed) for seed in children(row.seed, 2))
        scope = Scope()
        connections = [Connection(a, scope[0]), Connection(b, scope[1])]
        sim = Simulation([a, b, scope], connections, dt=0.1, log=False)
        sim.run(0.5)
        assert row.y == scope.read()[1].tolist()


@pytest.mark.parametrize(
    "block", ["RandomNumberGenerator()", "SinusoidalPhaseNoiseSource(sig_white=0.1)"]
)
def test_blocks_that_draw_from_the_global_generator_follow_the_row(block, tmp_path):
    # a seed written in the script does not win
    blocks = {"_": "np.random.seed(1)", "noise": block}
    sim = SIM.replace("{0}", "noise")
    before = np.random.get_state()[1].tolist()  # noqa: NPY002
    table = batch(tmp_path, blocks, {"X": [1.0, 1.0], "seed": [3, 4]}, sim=sim)
    assert table.y[0] != table.y[1]
    again = batch(tmp_path, blocks, {"X": [1.0], "seed": [4]}, sim=sim)
    assert again.y[0] == table.y[1]
    assert np.random.get_state()[1].tolist() == before  # noqa: NPY002


def test_a_block_of_the_scripts_own_and_one_in_a_subsystem(tmp_path):
    gusts = """None
class Gusts(Block):
    def __init__(self, seed=1):
        super().__init__()
        self.rng = np.random.default_rng(seed)
    def sample(self, t, dt):
        self.outputs[0] = self.rng.normal()
port = Interface()
inner = WhiteNoise()
"""
    blocks = {
        "_": gusts,
        "own": "Gusts()",
        "box": "Subsystem([port, inner], [Connection(inner, port)])",
    }
    table = batch(tmp_path, blocks, {"X": [1.0, 1.0]}, sim=SIM.replace("{0}", "own, box"))
    first, second = table.y
    assert first[0] != second[0]
    assert first[1] != second[1]
    own = np.random.default_rng(children(table.seed[0], 2)[0])
    assert first[0][1:] == [own.normal() for _ in first[0][1:]]


def test_a_seed_in_the_cases_wins(tmp_path):
    blocks = {
        "START": "1",
        "LATER": "[START + i for i in range(3)]",
        **TURBULENT,
        "third": "Sensor(noise=1.0, seed=LATER[2], T=0.1)",
    }

    def seeds(module):
        return {name: getattr(module, name).seed for name in (*TURBULENT, "third")}

    sim = SIM.replace("{0}", "turbulence, first, second, third")
    table = batch(tmp_path, blocks, {"START": [10, 20], "first.seed": [5]}, seeds, sim=sim)
    assert table.third.tolist() == [12, 22]
    assert table["first"].tolist() == [5, 5]
    for row in table.itertuples():
        drawn = children(row.seed, 4)
        assert (row.turbulence, row.second) == (drawn[0], drawn[2])


@pytest.mark.parametrize(
    ("blocks", "cases"),
    [
        ({"_": "np.random.seed(1)", "sensor": "Sensor(T=0.1)"}, {}),
        ({"sensor": "Sensor(noise=1.0, T=0.1)"}, {"sensor.seed": [1, 2]}),
    ],
)
def test_no_column_of_seeds_where_they_decide_nothing(blocks, cases, tmp_path):
    table = batch(tmp_path, blocks, {"X": [1.0], **cases}, sim=SIM.replace("{0}", "sensor"))
    assert table.completed.all()
    assert "seed" not in table


def test_a_row_that_fails_after_a_draw_has_its_seed(tmp_path):
    table = batch(tmp_path, {"noise": "WhiteNoise()"}, {"X": [1.0]}, lambda module: 1 / 0)
    assert table.reason[0].startswith("ZeroDivisionError")
    assert "seed" in table
