"""What tells a model's diagram from its script's: two texts that simulate the same, or do not."""

import ast

import pytest
from pathsim_jsbsim_blocks.pathview.same import Comparison, Functions

SCRIPT = """
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Function, Scope
from pathsim.solvers import RKCK54, SSPRK33

class Gain(Amplifier):
    def __init__(self, gain):
        super().__init__(gain)

part = Amplifier(2.0)
{}
scope = Scope()
sim = Simulation([part, scope], [Connection(part, scope)], Solver=SSPRK33, log=False)
{}
"""


def built(name, before="", after=""):
    """A simulation, its parts and its functions."""
    text = SCRIPT.format(before, after)
    namespace = {"__name__": name}
    exec(compile(text, name, "exec"), namespace)
    parts = {name: namespace[name] for name in ("part", "scope")}
    return namespace["sim"], parts, Functions(ast.parse(text), name)


def differences(one, other):
    """Paths of what is different in the second."""
    (here, parts, functions), (there, parts_there, functions_there) = (
        built(name, *(text if isinstance(text, tuple) else (text,)))
        for name, text in (("script", one), ("rebuilt", other))
    )
    found = Comparison(here, there, parts, parts_there, functions, functions_there)
    return ["".join(d.path) for d in found.differences]


GLOBAL = "{0} = 0\ndef f(u):\n    global {0}\n    {0} += 1\n    return u\npart = Function(f)"


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("", ""),
        ("part.kind = Amplifier", "part.kind = Amplifier"),
        ("part.table = {'a': 1.0, 'b': [2.0]}", "part.table = {'b': [2.0], 'a': 1.0}"),
        *[(f"part.rng = np.random.{rng}(3)",) * 2 for rng in ("RandomState", "default_rng")],
        (GLOBAL.format("n"), GLOBAL.format("m")),
        # a class of the script that only adds __init__ may keep what its base does not have
        ("part = Gain(2.0)\npart.note = 'mine'", ""),
    ],
)
def test_these_simulate_the_same(one, other):
    assert differences(one, other) == []


@pytest.mark.parametrize(
    ("one", "other", "path"),
    [
        ("part = Amplifier(2.5)", "", ".gain"),
        ("part.kind = Amplifier", "part.kind = Adder", ".kind"),
        ("part.table = {'a': 1.0}", "part.table = {'a': 1.5}", ".table['a']"),
        ("part.table = {'a': 1.0}", "part.table = {'b': 1.0}", ".table"),
        ("part.note = 'mine'", "", ".note"),
        ("part.rng = np.random.RandomState(3)", "part.rng = np.random.RandomState(4)", ".rng"),
        (GLOBAL.format("n"), GLOBAL.format("n").replace("+= 1", "+= 2"), ""),
        (("", "sim._set_solver(RKCK54)"), "", ".Solver"),
    ],
)
def test_these_do_not(one, other, path):
    found = differences(one, other)
    assert found
    assert any(p.startswith(path) for p in found), found
