"""Scripts built with other constants and parameters than their own."""

import sys
import types

import pytest
from how_many import EXPORTED, first

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.catalogue import diagram_names, load_diagram
from pathsim_jsbsim_blocks.scripts.script import Script, main_program
from pathsim_jsbsim_blocks.scripts.settings import Text

SCRIPT = """
\"\"\"A first-order lag.\"\"\"
import math
from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Integrator, Scope

GAIN, START = 2.0, 1.0
RATE: float = 2 * GAIN
UNUSED, LOCAL = 1, 2
ONE = TWO = 1
COUNT = 0
COUNT += 1
lag = Integrator(START)
first = second = Amplifier(-RATE)
gains = [Amplifier(k) for k in (1, 2)]
scope = Scope()

def make(gain, *, sign=ONE, LOCAL=TWO):
    LOCAL += LOCAL
    inner = Amplifier(sign * gain)
    return inner

def passing(**options):
    return make(**options)

made = make(3.0)
passed = passing(gain=3.0)
if COUNT > 5:
    never = Amplifier(1.0)
sim = Simulation([lag, first, scope],
                 [Connection(lag, first, scope), Connection(first, lag)], dt=0.01, log=False)
changed = Amplifier(1.0)
changed.gain = 3.0
IS_MAIN = __name__ == "__main__"
"""


def built(tmp_path, settings, text=SCRIPT):
    script = tmp_path / "lag.py"
    script.write_text(text)
    module = types.ModuleType("lag")
    Script(script, settings).run(module)
    return module


def test_what_is_derived_from_a_constant_follows(tmp_path):
    module = built(tmp_path, {"GAIN": 5.0})
    assert (module.GAIN, module.START, module.RATE) == (5.0, 1.0, 10.0)
    assert module.first.gain == -10.0


def test_parameters_given_by_place_by_name_and_not_at_all(tmp_path):
    module = built(
        tmp_path, {"first.gain": 7.0, "lag.initial_value": 3.0, "sim.dt": 0.02, "sim.dt_max": 9.0}
    )
    assert module.first.gain == 7.0
    assert module.second is module.first
    assert (module.lag.initial_value, module.sim.dt, module.sim.dt_max) == (3.0, 0.02, 9.0)


def test_arguments_of_functions_that_build(tmp_path):
    assert built(tmp_path, {"made.sign": -2}).made.gain == -6.0
    assert built(tmp_path, {"passed.gain": 4.0}).passed.gain == 4.0
    assert built(tmp_path, {"inner.gain": 8.0}).made.gain == 8.0


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("GAN", r"lag.py has no constant 'GAN' that it assigns once; did you mean 'GAIN'"),
        (
            "ZZZ",
            r"constant 'ZZZ' .*; available: GAIN, START, RATE, .* and parameters of lag, first, second",
        ),
        ("dt", r"lag.py has no constant 'dt' that it assigns once; did you mean 'sim.dt'"),
        ("lga.initial_value", r"assigns no block to 'lga'; did you mean 'lag'"),
        ("lag.initial", r"Integrator has no parameter 'initial'; did you mean 'initial_value'"),
        ("made.sgn", r"make has no parameter 'sgn'; did you mean 'sign'"),
        ("passed.sign", r"passing has no parameter 'sign'; available: gain"),
        ("lag", r"it is of class Integrator: set one of its parameters, such as lag.initial_value"),
        ("gains.gain", r"assigns no block to 'gains'; available: lag, first, second, scope"),
        ("UNUSED", "lag.py never uses it"),
        ("LOCAL", "lag.py never uses it"),
        ("ONE", "no constant 'ONE' that it assigns once"),
        ("COUNT", "no constant 'COUNT' that it assigns once"),
        ("never.gain", "did not execute the line that uses it"),
        ("changed.gain", "lag.py sets it itself, in line 33"),
        ("a-b", "a name is NAME or BLOCK.PARAMETER"),
        ("first.gain.x", "a name is NAME or BLOCK.PARAMETER"),
        (3, "a name is NAME or BLOCK.PARAMETER"),
    ],
)
def test_a_setting_without_a_place_is_refused(tmp_path, name, said):
    with pytest.raises(ParameterError, match=said) as caught:
        built(tmp_path, {name: 1.0})
    assert caught.value.parameter == name
    assert caught.value.value == 1.0


@pytest.mark.parametrize(
    "change",
    [
        "def LAW(t): return t",
        "from math import pi as LAW",
        "import math as LAW",
        "LAW += [5.0]",
        "LAW, other = [5.0], 2",
        "for LAW in ([5.0],): pass",
        "del LAW",
        "def f():\n    global LAW\n    LAW = 5.0",
    ],
)
def test_what_the_script_binds_again_is_no_constant(tmp_path, change):
    text = f"LAW = [1.0]\nprint(LAW)\n{change}\n"
    with pytest.raises(ParameterError) as error:
        built(tmp_path, {"LAW": [2.0]}, text)
    assert (error.value.parameter, error.value.value) == ("LAW", [2.0])


def test_changes_of_other_names_are_none_of_it(tmp_path):
    text = """
LAW = [1.0]
def f(LAW):
    LAW[0] = 3.0
    import math as LAW
def make(k):
    return {"k": k}
block = make(k=LAW)
block["LAW"] = 7.0
block[LAW[0]] = 7.0
"""
    module = built(tmp_path, {"LAW": [2.0], "block.k": 4.0}, text)
    assert (module.LAW, module.block["k"]) == ([2.0], 4.0)


def test_errors_of_the_script_are_at_its_own_lines(tmp_path):
    text = SCRIPT + "\n\n1 / 0\n"
    with pytest.raises(ZeroDivisionError) as caught:
        built(tmp_path, {"GAIN": 5.0, "first.gain": 1.0}, text)
    assert caught.traceback[-1].lineno + 1 == text.rstrip().count("\n") + 1
    # the call itself says what is wrong with its arguments
    with pytest.raises(TypeError, match=r"__init__\(\) takes .* positional arguments"):
        built(tmp_path, {"first.gain": 1.0}, SCRIPT.replace("(-RATE)", "(-RATE, 1, 2, 3)"))


@pytest.mark.parametrize(
    ("text", "replaced", "value"),
    [
        ("5", 3.0, 5),
        ("-1e3", None, -1e3),
        ("1/120", 0.01, 1 / 120),
        ("True", False, True),
        ("[1, 2.5]", [0.0], [1, 2.5]),
        ("{'Kp': 1}", "c172p", {"Kp": 1}),
        ("737", "c172p", "737"),
        ("'737'", "c172p", "737"),
        ("round", None, "round"),
        ("WGS-84", None, "WGS-84"),
    ],
)
def test_a_text_is_read_as_what_it_replaces(text, replaced, value):
    read = Text(text).read("x", replaced)
    assert read == value
    assert type(read) is type(value)


@pytest.mark.parametrize(
    "text", ["abc", "__import__('os')", "1/0", "9**9**9**9", "1 + 'a'", "[x for x in (1,)]", "1;2"]
)
def test_a_text_in_place_of_a_number_is_refused(text):
    with pytest.raises(ParameterError) as error:
        Text(text).read("x", 1.0)
    assert error.value.parameter == "x"


def test_as_the_main_program(tmp_path):
    script = tmp_path / "main.py"
    script.write_text(
        "import sys\nX = 1.0\nclass A: pass\n"
        "if __name__ == '__main__':\n    seen = X, sys.modules['__main__'].__dict__ is globals()\n"
    )
    before = sys.modules["__main__"]
    with main_program(script) as module:
        Script(script, {"X": 2.0}).run(module)
    assert module.seen == (2.0, True)
    assert sys.modules["__main__"] is before


@pytest.mark.parametrize("name", first([*EXPORTED, *diagram_names()], len(EXPORTED)))
def test_every_diagram_takes_settings(name):
    assert load_diagram(name, {"DURATION": 2.0, "sim.log": False}).DURATION == 2.0


def test_a_script_is_loaded_as_it_would_run(tmp_path):
    (tmp_path / "beside_it.py").write_text("K = 2.0")
    script = tmp_path / "loaded.py"
    script.write_text(
        "from __future__ import annotations\nimport sys\nfrom dataclasses import dataclass\n"
        "from beside_it import K\n@dataclass\nclass P:\n    k: float = K\nARGS = sys.argv[1:]\n"
        "def make(index, make):\n    return index\nmade = make(index=1, make=2)\n"
    )
    before = list(sys.path)
    module = load_diagram(str(script), {"made.make": 5})
    assert (module.P().k, module.ARGS, module.__name__) == (2.0, [], "loaded")
    assert (set(sys.modules) & {"beside_it", "loaded"}, list(sys.path)) == (set(), before)


def test_settings_are_a_mapping():
    with pytest.raises(ParameterError) as error:
        load_diagram("pitch_hold", [("DURATION", 1.0)])
    assert (error.value.parameter, error.value.value) == ("settings", [("DURATION", 1.0)])
