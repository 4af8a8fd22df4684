"""What a script shows when Python runs it, and whether another shows the same; knows no exporter."""

import inspect
import random
import runpy
import sys
import time

import numpy as np
from pathsim import Simulation, Subsystem
from pathsim.blocks import Block

LATE = (7.0, 60.0)  # s, after all runs


class Done(BaseException):
    pass


def said(function, t):
    """What a function of a block returns, or which error it raises."""
    try:
        parameters = inspect.signature(function).parameters.values()
        n = sum(p.kind is not p.KEYWORD_ONLY and p.default is p.empty for p in parameters)
        return np.array(function(*[t] * n), float).tolist()
    except Exception as error:
        return type(error).__name__


def recorders(blocks):
    """Scopes and spectra, those in subsystems first, as PathView's scripts have them."""
    for block in blocks:
        if type(block) is Subsystem:
            yield from recorders(block.blocks)
    yield from (b for b in blocks if type(b).__name__ in ("Scope", "Spectrum"))


def facts(simulation):
    """What a simulation has recorded, its blocks' plain values, and what their functions say."""
    recorded, held = [r.read() for r in recorders(simulation.blocks)], []
    for block in simulation.blocks:
        for name, value in vars(block).items():
            if name == "initial_value":
                continue  # a state that was set before the run is the model's
            if isinstance(value, (bool, int, float, np.ndarray)) and not name.startswith("_"):
                held.append((name, type(value).__name__, np.array(value).tolist()))
        function = getattr(block, "func", None)
        if inspect.isfunction(function) or inspect.ismethod(function):
            held.append([said(function, t) for t in LATE])
    return recorded, held


def first_run(path, monkeypatch):
    """`facts` at the end of a script's first run; without `run` at the end of the script."""
    found, built = [], []
    run, build, rng = Simulation.run, Simulation.__init__, np.random.default_rng

    def observed(simulation, *args, **kwargs):
        run(simulation, *args, **kwargs)
        found.append(facts(simulation))
        raise Done

    def noted(simulation, blocks=(), *args, **kwargs):
        for place, block in enumerate(blocks):
            block._place = place  # PathSim orders sources by their hash
        build(simulation, blocks, *args, **kwargs)
        built.append(simulation)

    with monkeypatch.context() as patched:
        patched.setattr(Simulation, "run", observed)
        patched.setattr(Simulation, "__init__", noted)
        patched.setattr(Block, "__hash__", lambda b: getattr(b, "_place", id(b)), raising=False)
        patched.setattr(sys, "argv", [str(path)])
        patched.setattr(time, "time", lambda: 1e9)
        patched.setattr(
            np.random, "default_rng", lambda seed=None: rng(8 if seed is None else seed)
        )
        np.random.seed(8)  # noqa: NPY002
        random.seed(8)
        try:
            runpy.run_path(str(path), run_name="__main__")
            found.append(facts(built[0]))
        except Done:
            pass
    return found[0]


def assert_equal(script, model, skip=0):
    """The first ``skip`` samples of the script are not of its run."""
    (recorded, held), (recorded_there, held_there) = script, model
    # PathView lists subsystems first; nan is equal to itself, 0.0 is not -0.0
    assert sorted(map(repr, held)) == sorted(map(repr, held_there))
    assert len(recorded) == len(recorded_there) > 0
    for (t, signals), (t_there, signals_there) in zip(recorded, recorded_there, strict=True):
        assert len(t) >= 5
        t, signals = t[skip:], np.array(signals)[:, skip:]
        first = list(t_there).index(t[0])  # a loop of steps samples no t = 0, and has no end
        here = slice(first, first + len(t))
        np.testing.assert_array_equal(t_there[here], t)
        np.testing.assert_array_equal(np.array(signals_there)[:, here], signals)
