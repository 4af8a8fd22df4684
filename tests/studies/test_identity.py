"""The identity of a study: the same in any process, another for what gives other rows."""

import os
import subprocess
import sys

import pytest

from pathsim_jsbsim_blocks.studies.identity import code, differences, study_key

SCRIPT = """
import math
from functools import partial

LIMIT = 3.0

class Filter:
    gain = 1.0

    def step(self, x):
        return self.gain * x

def rms(values):
    return math.sqrt(sum(v * v for v in values) / len(values))

def factory(factor):
    def measure(m, bias=0.5):
        if m.kind in {"left", "right", "both"}:
            return {"rms": factor * rms(m.y), "late": [t for t in m.time if t > LIMIT]}
        return {"rms": Filter().step(m.rms.x + bias)}
    return measure

measure = partial(factory(2.0), bias=0.5)
"""


def measured(script):
    variables = {"__name__": "own"}
    exec(script, variables)
    return code(variables["measure"])


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("LIMIT = 3.0", "LIMIT = 4.0"),
        ("factory(2.0)", "factory(2)"),
        ("bias=0.5)\n", "bias=0.6)\n"),
        ("gain = 1.0", "gain = -1.0"),
        ("self.gain * x", "self.gain + x"),
        ("v * v for", "v + v for"),
        ("math.sqrt(", "math.cbrt("),
        ("m.rms.x", "m.rms.z"),
        ('"left"', '"Left"'),
        ("t > LIMIT", "t >= LIMIT"),
    ],
)
def test_what_gives_other_rows_has_another_identity(before, after):
    assert SCRIPT.count(before) == 1
    assert measured(SCRIPT.replace(before, after)) != measured(SCRIPT)


def test_the_place_of_the_code_does_not_matter():
    moved = "import os\n# a comment\n\n" + SCRIPT.replace("def rms", "OTHER = 1\n\ndef rms")
    assert measured(moved) == measured(SCRIPT)


def test_the_identity_is_the_same_in_another_process():
    program = f"""
from pathsim_jsbsim_blocks.studies.identity import code
variables = {{"__name__": "own"}}
exec({SCRIPT!r}, variables)
print(code(variables["measure"]))
"""
    said = subprocess.run(
        [sys.executable, "-c", program],
        env={**os.environ, "PYTHONHASHSEED": "5"},
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert said == measured(SCRIPT) + "\n"


def test_recursion_ends():
    values = []
    values.append(values)

    def even(n):
        return n == 0 or odd(n - 1), values

    def odd(n):
        return n > 0 and even(n - 1)

    assert code(even) == code(even)
    assert code(even) != code(odd)


def test_parts_that_differ_are_named():
    kept = study_key({"seed": 1, "cases": list(range(100))})
    assert differences(kept, study_key({"seed": 1, "cases": list(range(100))})) == ""
    assert differences(kept, study_key({"seed": 2, "cases": list(range(100))})) == (
        "seed (kept 1, now 2)"
    )
    assert differences(kept, study_key({"seed": 1, "cases": list(range(99))})) == "cases"
    assert differences(kept, study_key({"points": 3})) == ""
