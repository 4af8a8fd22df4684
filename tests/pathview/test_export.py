"""Scripts of PathSim's usual form become models: structure, names, expressions, values."""

import json
import random
import re
from pathlib import Path

import numpy as np
import pytest
from scripts_of_tests import HEAD, OSCILLATOR, code, names, node, script, wires

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import export_script
from pathsim_jsbsim_blocks.pathview.first_run import FirstRun


def test_structure_comes_from_the_live_diagram_and_expressions_from_the_source(written):
    model = written(OSCILLATOR)
    params = [
        {k: v for k, v in n["params"].items() if not k.startswith("_")}
        for n in model["graph"]["nodes"]
    ]
    kinds = [n["type"] for n in model["graph"]["nodes"]]
    assert [*zip(names(model), kinds, params, strict=True)] == [
        ("velocity", "Integrator", {}),
        ("position", "Integrator", {"initial_value": "x0"}),
        ("spring", "Amplifier", {"gain": "-k"}),
        ("damper", "Amplifier", {"gain": "-d"}),
        ("force", "Adder", {}),
        ("scope", "Scope", {"labels": '["v", "x"]'}),
    ]
    assert [p["name"] for p in node(model, "scope")["inputs"]] == ["v", "x"]
    assert wires(model) == {
        ("velocity", 0, "position", 0),
        ("velocity", 0, "damper", 0),
        ("velocity", 0, "scope", 0),
        ("position", 0, "spring", 0),
        ("position", 0, "scope", 1),
        ("spring", 0, "force", 0),
        ("damper", 0, "force", 1),
        ("force", 0, "velocity", 0),
    }
    assert code(model) == "# initial position\nx0 = 2.0  # m\nk = 0.8\nd = 0.2"
    # as written, and PathSim's defaults otherwise
    assert model["simulationSettings"] == {
        "solver": "RKCK54",
        "duration": "10 * np.pi",
        "dt": "1 / 100",
        "dt_min": "1e-16",
        "dt_max": "",
        "rtol": "1e-6",
        "atol": "1e-08",
        "ftol": "1e-10",
        "adaptive": True,
        "ghostTraces": 0,
        "plotResults": True,
        "log": False,
    }
    assert model["graph"]["annotations"][0]["content"] == (
        "# Oscillator\n\nA mass on a spring.\n\nSecond paragraph with `code`."
    )


def test_a_docstring_in_rest_becomes_markdown(written):
    docstring = r"""
Title
=====

One :math:`x^2` and
two:
- a
- b

.. math::

    x + 1 = v
"""
    model = written(f'r"""{docstring}"""\n' + script("a = Constant(1)"))
    assert model["graph"]["annotations"][0]["content"] == (
        "# Title\n\nOne $x^2$ and two:\n- a\n- b\n\n$$ x + 1 = v $$"
    )
    assert written(script("a = Constant(1)"))["graph"]["annotations"] == []


@pytest.mark.parametrize(
    ("blocks", "listed", "shown"),
    [
        ("parts = [Constant(1), Scope()]", "*parts", ["Constant", "Scope"]),
        ("", "Constant(1), Constant(2)", ["Constant", "Constant 2"]),
    ],
)
def test_blocks_without_a_variable_get_a_name_of_their_class(blocks, listed, shown, written):
    assert names(written(script(blocks, names=listed))) == shown


def test_names_that_pathview_would_confuse_are_changed_also_in_functions(written):
    """PathView's variables are lower case: Int would hide int, K hides the parameter k, and X is x,
    which ``height`` has as a variable of its own."""
    model = written(
        script(
            "Int = Integrator(k)\nX = Integrator()\nx = Integrator()\nK = Amplifier(k)\n"
            "Lambda = Amplifier()\nφ = Amplifier()\nblocks_ = Constant()\nsimulation = Constant()",
            before="k = 2.0\ndef height(t):\n    x = Int.engine.state\n    return x - k * len(X())\n",
            events="[ZeroCrossing(height, lambda t: X.engine.set(K.gain))]",
        )
    )
    first = ["Int block", "X block", "x block 2", "K block", "Lambda block"]
    assert names(model) == [*first, "Amplifier", "blocks block", "simulation"]
    assert "x = int_block.engine.state\n    return x - k * len(x_block())" in code(model)
    assert model["events"][0]["params"] == {
        "func_evt": "height",
        "func_act": "lambda t: x_block.engine.set(k_block.gain)",
    }


def test_a_text_of_several_lines_survives_pathviews_indentation(written):
    text = code(
        written(
            script(
                "s = Source(lambda t: len(TEXT) + len(f()))",
                before='''
TEXT = """one
two"""
def f():
    """Doc
    string."""
    return f"""a{TEXT}
b"""
''',
            )
        )
    )
    assert "TEXT = 'one\\ntwo'" in text
    assert "return f'a{TEXT}\\nb'" in text
    assert '"""Doc\n    string."""' in text


def test_a_function_that_a_block_decorates(written):
    model = written(
        script(
            "@Source\ndef wave(t):\n    return np.sin(w * t)\ns = Scope()",
            before="w = 3.0",
            names="wave, s",
        )
    )
    assert node(model, "wave")["params"] == {"func": "wave_function"}
    assert code(model) == "w = 3.0\n\ndef wave_function(t):\n    return np.sin(w * t)"


def test_subsystems_nest_with_interfaces_events_and_port_names(written):
    model = written(
        script(
            """
inner_port = Interface()
inner_gain = Amplifier(2)
inner = Subsystem([inner_port, inner_gain],
                  [Connection(inner_port, inner_gain), Connection(inner_gain, inner_port)])
plant_port = Interface()
plant_port.register_port_map({"y": 0, "x": 1}, {"u": 0})
plant_state = Integrator(1.0)
crossing = ZeroCrossing(lambda t: plant_state.engine.state - 0.5, None)
plant = Subsystem([plant_port, plant_state, inner],
                  [Connection(plant_port["u"], inner), Connection(inner, plant_state),
                   Connection(plant_state, plant_port["x"])], [crossing])
source = Constant(-1.0)
scope = Scope()
""",
            "Connection(source, plant), Connection(plant[1], scope)",
            names="source, plant, scope",
        )
    )
    plant = node(model, "plant")
    assert [p["name"] for p in plant["inputs"]] == ["u"]
    assert [p["name"] for p in plant["outputs"]] == ["y", "x"]
    assert names(plant) == ["Interface", "state", "inner"]
    assert [p["name"] for p in node(plant, "Interface")["inputs"]] == ["y", "x"]
    assert names(node(plant, "inner")) == ["Interface", "gain"]
    event = plant["graph"]["events"][0]
    assert event["params"]["func_evt"] == "lambda t: plant_state.engine.state - 0.5"
    # PathView imports the events of the top level only
    assert code(model) == "from pathsim.events import ZeroCrossing"


@pytest.mark.parametrize(
    ("imports", "blocks", "order"),
    [
        (
            "from pathsim_flight import ISAtmosphere\n"
            "from pathsim_jsbsim_blocks import DoubletSource",
            "air = ISAtmosphere()\nd = DoubletSource()",
            ["pathsim-jsbsim-blocks", "pathsim-flight"],
        ),
        (
            "from pathsim_jsbsim_blocks import ISAtmosphere\n"
            "from pathsim_flight import JSBSimWrapper",
            "air = ISAtmosphere()\nfdm = JSBSimWrapper(input_properties=['fcs/elevator-cmd-norm'],"
            "output_properties=['attitude/theta-deg'])",
            ["pathsim-flight", "pathsim-jsbsim-blocks"],
        ),
    ],
)
def test_toolboxes_stand_in_an_order_in_which_the_right_class_wins(written, imports, blocks, order):
    """ISAtmosphere is in both; PathView takes the class of the toolbox that is registered last."""
    required = written(script(blocks, before=imports))["requiredToolboxes"]
    assert [toolbox["displayName"] for toolbox in required] == order


@pytest.mark.parametrize(
    ("imports", "blocks", "message"),
    [
        ("ISAtmosphere as Other", "b = Other()", "same class name 'ISAtmosphere'"),
        ("CAStoTAS", "b = CAStoTAS()", "hide each other"),
    ],
)
def test_classes_that_hide_each_other_are_refused(imports, blocks, message, written):
    both = f"from pathsim_jsbsim_blocks import ISAtmosphere\nfrom pathsim_flight import {imports}"
    with pytest.raises(DiagramError, match=message):
        written(script(f"a = ISAtmosphere()\n{blocks}", before=both))


def test_a_second_export_keeps_positions_and_notes(export, tmp_path):
    small = OSCILLATOR.replace("10 * np.pi", "0.1")
    model = export(small, "oscillator")
    node(model, "spring")["position"] = {"x": 1230, "y": -450}
    node(model, "spring")["params"]["gain"] = "99"
    model["graph"]["annotations"].append({"id": "mine", "content": "note"})
    (tmp_path / "oscillator.pvm").write_text(json.dumps(model))
    again = export(small, "oscillator")
    assert node(again, "spring")["position"] == {"x": 1230, "y": -450}
    assert node(again, "spring")["params"]["gain"] == "-k"
    assert again["graph"]["annotations"][1]["content"] == "note"


def test_files_that_an_export_cannot_read_or_write_are_named(saved, tmp_path):
    with pytest.raises(DiagramError, match=r"nowhere.*cannot be written"):
        export_script(saved(script("a = Constant(1)")), tmp_path / "nowhere" / "a.pvm")
    for missing in (tmp_path / "missing.py", ""):
        with pytest.raises(DiagramError, match="cannot be read"):
            export_script(missing)


# values -------------------------------------------------------------------------------------------


VALUES = (Path(__file__).parents[1] / "data" / "exported_values.txt").read_text(encoding="utf-8")
VALUES = re.findall(r"^## (.+) -> (.+)\n((?:(?!## ).*\n)*)", VALUES, re.M)


@pytest.mark.parametrize(("late", "value", "before"), VALUES)
def test_what_functions_need_is_written_as_it_is_when_the_run_begins(late, value, before, written):
    model = written(script(f"a = Source(lambda t: {late})", before=before))
    there = {"np": np, "__name__": "pathview", "__file__": "model"}
    exec(code(model), there)
    assert eval(node(model, "a")["params"]["func"], there)(7.0) == float(value)


def test_comments_above_and_beside_definitions_stay(written):
    before = """
# gravity
g = 9.81  # m/s2

# two lines
# on a wave
@lru_cache  # of few values
def wave(t):
    # inside
    return np.sin(g * t)  # no unit

# with a state
class Law:
    def __call__(self, t):
        return t

def build():
    # inside a function
    def third(t):
        return t
    return third
"""
    parts = "a, b, c = [Source(f) for f in (wave, Law(), build())]"
    text = code(
        written(script(parts, before="from functools import lru_cache" + before, names="a, b, c"))
    )
    comments = re.findall("#.*", before.replace("# of few values", ""))
    assert sorted(re.findall("#.*", text)) == sorted(comments)
    for above, line in (
        ("on a wave", "def wave(t):"),
        ("with a state", "class Law:"),
        ("inside a function", "def third(t):"),
    ):
        assert f"# {above}\n{line}" in text


def test_what_is_not_needed_is_not_written(written):
    before = "import math\nfrom os import sep\nnp.random.seed(1)\nnote = 1\nroot = math.sqrt\n"
    assert code(written(script("a = Amplifier(root(9.0))", before=before))) == (
        "import math\n\nroot = math.sqrt"
    )


@pytest.mark.parametrize(
    ("after", "state"),
    [
        ("a.engine.set(3.0)", 3.0),
        ("parts = {'a': a}\nparts['a'].engine.set(3.0)", 3.0),
        ("sim.steadystate()", 1.0),
    ],
)
def test_a_state_before_the_run_is_the_initial_value(after, state, written):
    model = written(
        script(
            "one = Constant(1.0)\nb = Amplifier(-1.0)\na = ODE(lambda x, u, t: u[0:1] + u[1], 0.0)",
            "Connection(a, b), Connection(b, a[0]), Connection(one, a[1])",
            after=after + "\nsim.run(0.5)",
        )
    )
    value = eval(node(model, "a")["params"]["initial_value"], {"np": np})
    np.testing.assert_allclose(value, state, atol=1e-6)


DYNAMIC = """
one = Constant(1.0)
a, b, c = TransferFunctionNumDen([1.0], [1.0, 1.0]), PT2(K=2.0), ButterworthLowpassFilter(2.0)
d, e = TransferFunctionPRC([-1.0], [1.0]), AllpassFilter(2.0)
s = Scope()
"""
WIRES = "Connection(one, a, b, c, d, e), *[Connection(x, s[i]) for i, x in enumerate((a, b, c))]"


@pytest.mark.parametrize("before_the_run", ["", "sim.steadystate()", "b.engine.set([0.5, -1.0])"])
def test_linear_blocks_that_pathview_lacks_or_that_have_a_state_are_state_space_models(
    before_the_run, export
):
    run = f"{before_the_run}\nsim.run(0.5)"
    model = export(script(DYNAMIC, WIRES, names="one, a, b, c, d, e, s", after=run))
    kinds = {n["name"]: n["type"] for n in model["graph"]["nodes"]}
    assert kinds["d"] == kinds["e"] == "StateSpace"
    assert kinds["b"] == ("StateSpace" if before_the_run else "PT2")
    assert kinds["a"] == ("StateSpace" if "steady" in before_the_run else "TransferFunctionNumDen")
    if "steady" in before_the_run:  # the output, C x, is the gain
        texts = node(model, "b")["params"]
        matrix, state = (eval(texts[name], {"np": np}) for name in ("C", "initial_value"))
        np.testing.assert_allclose(matrix @ state, 2.0, atol=1e-6)


@pytest.mark.parametrize(
    ("call", "cause"),
    [("sim.steadystate()", r"which steadystate\(\) in line 10 has set"), ("", "")],
)
def test_blocks_for_which_pathview_has_no_initial_value_are_named_together(call, cause, export):
    blocks = "one, r, w, p = Constant(1.0), RateLimiter(), AntiWindupPID(Kp=1, Ki=1), PT1()"
    run = f"{call}\nr.engine.set(1.0); w.engine.set([1.0, 1.0])\nsim.run(0.5)"
    wires = "Connection(one, r, p)"
    with pytest.raises(DiagramError, match=rf"'r' \(RateLimiter\), 'w' \(AntiWindupPID\).*{cause}"):
        export(script(blocks, wires, names="one, r, w, p", after=run))


@pytest.mark.parametrize(
    ("blocks", "expected"),
    [
        ("k = 2.0\na = Amplifier(3 * k)", "3 * k"),
        ("k = 2.0\na = Amplifier(k)\na.gain += 0.5", "2.5"),
        ("a = Amplifier(1)\na.gain = 7.0", "7.0"),
        ("a = Amplifier(gain=(k := 3.0))", "3.0"),
        ("a = Amplifier(1.0)\na.gain = np.ones(1)", "np.array([1.0])"),
        (
            "a = Amplifier(1.0)\na.gain = np.array([1, 2], dtype='float32')",
            "np.array([1.0, 2.0], dtype='float32')",
        ),
        (
            "def late(t):\n    gain[0] = 9.0\ngain = np.ones(1)\nfor k in (gain,):\n    a = Amplifier(k)",
            "gain",
        ),
    ],
)
def test_an_expression_stays_where_it_gives_the_live_value(blocks, expected, written):
    assert node(written(script(blocks, names="a")), "a")["params"] == {"gain": expected}


def test_modules_beside_two_scripts_may_have_the_same_name(written, tmp_path):
    (tmp_path / "other").mkdir()
    for folder, value in (("", 2.0), ("other", 3.0)):
        (tmp_path / folder / "beside_the_script.py").write_text(f"K = {value}")
    beside = script("a = Amplifier(K)", before="from beside_the_script import K")
    assert [code(written(beside, name)) for name in ("a", "other/a")] == ["K = 2.0", "K = 3.0"]


@pytest.mark.long
def test_draws_before_the_run_are_numbers_and_blocks_without_a_seed_fly_alike(export):
    with pytest.warns(UserWarning, match="random numbers without a seed .* are fixed"):
        model = export(
            HEAD + "k = np.random.rand()\na = Amplifier(k)\nw, p = WhiteNoise(), PinkNoise()\n"
            "r = RandomNumberGenerator()\n"
            "sim = Simulation([a, w, p, r], [Connection(w, a)], log=False)\nsim.run(0.1)"
        )
    assert 0 < float(code(model).removeprefix("k = ")) < 1
    assert "seed" not in node(model, "w")["params"]


@pytest.mark.parametrize(
    ("before", "drawn"),
    [
        ("k = np.random.rand()", True),
        ("k = np.random.normal(size=100_000)[0]", True),
        ("import random\nk = random.gauss(0, 1)", True),
        ("import random as dice\nk = dice.Random().random()", True),
        ("k = np.random.default_rng().normal()", True),
        ("np.random.seed(3)\nk = np.random.rand()", False),
        ("k = np.random.default_rng(3).normal()", False),
        ("import random\nrandom.seed(3)\nk = random.random()", False),
        ("k = 1.0\nr = RandomNumberGenerator()", False),
    ],
)
def test_a_script_that_has_drawn_random_numbers_of_no_seed(before, drawn, saved):
    random.gauss(0, 1)  # leaves a number for the next call
    diagram = FirstRun(saved(script("a = Amplifier(k)", before=before)))
    assert diagram.generators.drawn == drawn


@pytest.mark.parametrize(
    ("before", "draw", "seed"),
    [
        ("from numpy.random import seed as s, rand as r\ns(4)", "r()", 4),
        ("np.random.set_state(np.random.RandomState(5).get_state())", "np.random.rand()", 5),
        ("np.random.seed(1)\nnp.random.seed(2**32 - 1)", "np.random.rand()", 2**32 - 1),
        ("def start(x):\n    np.random.seed(x)\nstart(6)", "np.random.rand()", 6),
        ("np.random.seed([1, 2])", "np.random.rand()", None),  # of no single number
        ("np.random.seed(8)\nk = np.random.rand()", "np.random.rand()", None),
        ("import random\nrandom.seed(9)", "random.random()", None),
        ("from scipy.stats import norm\nnp.random.seed(3)", "norm.rvs()", None),  # in a library
    ],
)
def test_a_state_of_the_shared_generators_is_in_the_model_or_refused(before, draw, seed, export):
    text = script(f"a = Source(lambda t: {draw})", before=before, after="sim.run(0.1)")
    if seed is None:
        with pytest.raises(DiagramError, match="the state of a generator of random numbers"):
            export(text)
    else:
        assert code(export(text)).endswith(f"np.random.seed({seed})")


def test_functions_of_the_shared_generators_under_other_names(export):
    """Their own generator in the model would draw other numbers."""
    before = "import random\nnp.random.seed(4)\nnormal, gauss = np.random.normal, random.gauss"
    parts = "a, b = Source(lambda t: normal()), Source(lambda t: gauss(0, 1))"
    text = code(export(script(parts, names="a, b", before=before, after="sim.run(0.1)")))
    assert text == "import random\nnp.random.seed(4)"
