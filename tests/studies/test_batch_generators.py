"""A case that draws from a generator which outlives it is refused, wherever the generator is."""

import functools
import random
import sys

import joblib
import numpy as np
import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.studies import run_batch

CASES = {"x": [0.0, 1.0, 2.0, 3.0]}
RNG = np.random.default_rng(1)
OLD = np.random.RandomState(1)
PYTHON = random.Random(1)
SEEDS = np.random.SeedSequence(1)


def batch(build, cases=CASES, jobs=1, **options):
    return run_batch(build, cases, jobs=jobs, progress=False, **options)


def modern(x):
    return {"y": RNG.normal()}


class Settings:
    rng = np.random.default_rng(1)


TOOLS = {"rng": np.random.default_rng(1)}
draw = np.random.default_rng(1).normal


def before_it_fails(x):
    raise ValueError(RNG.normal())


def bound(rng, x):
    return {"y": rng.normal()}


class Study:
    def __init__(self):
        self.rng = np.random.default_rng(1)

    def __call__(self, x):
        return {"y": self.rng.normal()}

    def method(self, x):
        return self(x)


def enclosed():
    rng = np.random.default_rng(1)
    return lambda x: {"y": rng.normal()}


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (modern, "RNG"),
        (lambda x: {"y": OLD.normal()}, "OLD"),
        (lambda x: {"y": PYTHON.random()}, "PYTHON"),
        (lambda x: {"y": np.random.default_rng(SEEDS.spawn(1)[0]).normal()}, "SEEDS"),
        (lambda x: modern(x), "RNG"),  # through a helper
        (lambda x: {"y": Settings.rng.normal()}, "Settings.rng"),
        (lambda x: {"y": TOOLS["rng"].normal()}, "TOOLS.rng"),
        (lambda x: {"y": draw()}, "draw"),
        (before_it_fails, "RNG"),
        (lambda x, rng=np.random.default_rng(1): {"y": rng.normal()}, "default 0"),  # noqa: B008
        (functools.partial(bound, np.random.default_rng(1)), "argument 0"),
        (Study(), "attribute rng"),
        (Study().method, "attribute rng"),
        (enclosed(), "rng"),
    ],
)
def test_a_generator_that_outlives_a_case_is_refused_by_name(build, name):
    with pytest.raises(ParameterError, match=r"default_rng\(seed\)") as refused:
        batch(build)
    assert refused.value.parameter == "build"
    assert refused.value.value == name


@pytest.mark.long
def test_it_is_refused_from_workers_too():
    with pytest.raises(ParameterError) as refused:
        batch(modern, jobs=2)
    assert refused.value.value == "RNG"


def test_a_generator_of_a_module_beside_is_refused(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "gusts70.py").write_text("import numpy as np\nRNG = np.random.default_rng(1)\n")
    (tmp_path / "study70.py").write_text(
        "import gusts70\ndef build(x):\n    return {'y': gusts70.RNG.normal()}\n"
    )
    import study70

    with pytest.raises(ParameterError) as refused:
        batch(study70.build)
    assert refused.value.value == "gusts70.RNG"
    for name in ("study70", "gusts70"):
        del sys.modules[name]


def test_a_measure_that_draws_is_refused():
    def noisy(diagram):
        return {"y": RNG.normal()}

    with pytest.raises(ParameterError) as refused:
        batch("step_response", {"DURATION": [0.1]}, measure=noisy)
    assert refused.value.value == "RNG"


def of_the_seed(x, seed):
    return {"y": np.random.default_rng(seed).normal() + np.random.normal() + random.random()}  # noqa: NPY002


def beside_it(x):
    return {"y": x}


@pytest.mark.parametrize("build", [of_the_seed, beside_it])
def test_other_generators_are_left_alone(build):
    """A generator beside the function, which draws the cases, is no concern of a case."""
    cases = {"x": RNG.uniform(0, 1, 3)}
    table = batch(build, cases)
    assert table.completed.all()
    last = batch(build, table[["x", *(["seed"] if "seed" in table else [])]].iloc[2:])
    assert last.y.iloc[0] == table.y.iloc[2]


@pytest.mark.parametrize("backend", ["threading", "multiprocessing"])
def test_only_loky_and_dask_run_a_batch(backend):
    # Ray's backend of joblib is a subclass of that for multiprocessing
    with joblib.parallel_config(backend), pytest.raises(ParameterError, match=r"loky or .* Dask"):
        batch(beside_it, jobs=2)
