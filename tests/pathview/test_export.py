"""Scripts of PathSim's usual form become models; what PathView cannot hold is refused by line."""

import json
import os
import runpy
import subprocess
import sys
import textwrap
import warnings

import numpy as np
import pytest

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.cli import editor, main
from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script, pvm
from pathsim_jsbsim_blocks.pathview.expressions import is_data
from pathsim_jsbsim_blocks.pathview.reader import read_diagram
from pathsim_jsbsim_blocks.scripts.first_run import FirstRun

pytest.importorskip("pathview")

OSCILLATOR = '''
"""Oscillator: a mass on a spring.

Second paragraph with ``code``.
"""
import numpy as np
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope
from pathsim.solvers import RKCK54

# initial position
x0 = 2.0  # m
k, d = 0.8, 0.2

velocity = Integrator()
position = Integrator(x0)
spring = Amplifier(gain=-k)
damper = Amplifier(-d)
force = Adder()
scope = Scope(labels=["v",
                      "x"])  # two signals
sim = Simulation(
    [velocity, position, spring, damper, force, scope],
    [
        Connection(velocity, position, damper, scope[0]),
        Connection(position, spring, scope[1]),
        Connection(spring, force[0]),
        Connection(damper, force[1]),
        Connection(force, velocity),
    ],
    Solver=RKCK54, dt=1 / 100, tolerance_lte_rel=1e-6, log=False)

if __name__ == "__main__":
    sim.run(10 * np.pi)
'''


@pytest.fixture
def written(tmp_path):
    """The model of a script, which does not fly."""

    def written(text, name="script"):
        path = tmp_path / f"{name}.py"
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return FirstRun(path, lambda script: pvm.model(read_diagram(script))).result

    return written


@pytest.fixture
def export(tmp_path):
    """Export the text of a script; returns the model."""

    def export(text, name="script"):
        path = tmp_path / f"{name}.py"
        path.write_text(textwrap.dedent(text), encoding="utf-8")
        return json.loads(export_script(path).read_text(encoding="utf-8"))

    return export


def script(blocks, wires="", before="", names=None, after="", events="[]"):
    """A script that builds the blocks given as statements."""
    names = names or ", ".join(
        line.split(" = ")[0]
        for line in blocks.splitlines()
        if " = " in line and not line.startswith(" ")
    )
    return f"""
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import *
from pathsim.solvers import *
{before}
{blocks}
sim = Simulation([{names}], [{wires}], {events}, log=False)
{after}
"""


def node(model, name):
    return next(n for n in model["graph"]["nodes"] if n["name"] == name)


def wires(model):
    return {
        (c["sourceNodeId"], c["sourcePortIndex"], c["targetNodeId"], c["targetPortIndex"])
        for c in model["graph"]["connections"]
    }


def test_structure_comes_from_the_live_diagram_and_expressions_from_the_source(written):
    model = written(OSCILLATOR)
    assert [(n["name"], n["type"]) for n in model["graph"]["nodes"]] == [
        ("velocity", "Integrator"),
        ("position", "Integrator"),
        ("spring", "Amplifier"),
        ("damper", "Amplifier"),
        ("force", "Adder"),
        ("scope", "Scope"),
    ]
    assert node(model, "position")["params"] == {"initial_value": "x0"}
    assert node(model, "velocity")["params"] == {}
    assert node(model, "spring")["params"]["gain"] == "-k"
    assert node(model, "damper")["params"]["gain"] == "-d"
    assert node(model, "scope")["params"] == {"labels": '["v", "x"]'}
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


def test_only_needed_code_becomes_context_with_its_comments(written):
    model = written(OSCILLATOR)
    assert model["codeContext"]["code"] == "# initial position\nx0 = 2.0  # m\nk = 0.8\nd = 0.2"


def test_settings_are_as_written_and_pathsims_defaults_otherwise(written):
    assert written(OSCILLATOR)["simulationSettings"] == {
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


@pytest.mark.parametrize(
    ("run", "duration"),
    [
        ("sim.run(20)", "20"),
        ("from pathsim_jsbsim_blocks import fly\nfly(sim, 20)", "20"),
        ("sim.run(duration=2 * T)\nsim.plot()", "2 * T"),
        ("sim.run()", "10.0"),
        ("if __name__ == '__main__':\n    tf = 7\n    sim.run(tf)", "tf"),
        ("def main():\n    sim.run(T)\n\nif __name__ == '__main__':\n    main()", "T"),
        ("def main():\n    sim.run(T)\n\nmain()", "T"),
        ("", "10.0"),
        ("DURATION = 3.0", "DURATION"),
    ],
)
def test_duration_is_that_of_the_first_run(written, run, duration):
    model = written(script("a = Constant(1)\ns = Scope()", before="T = 5.0", after=run))
    assert model["simulationSettings"]["duration"] == duration
    names = {"T", "tf", "DURATION"} & {duration.split(" ")[-1]}
    assert all(f"{n} = " in model["codeContext"]["code"] for n in names)


def test_ports_by_slice_list_name_and_several_targets(written):
    model = written(
        script(
            "lut = Function(lambda t: (t, 2*t, 3*t))\nflow = Function(lambda a, b, c: a)\n"
            "compare = GreaterThan()\nclock = Source(lambda t: t)\nscope = Scope()",
            "Connection(clock, lut), Connection(lut[0:3], flow[0:3], scope[0:3]),"
            "Connection(lut[1], compare['b']), Connection(clock['out'], compare['a'])",
        )
    )
    assert wires(model) == {
        ("clock", 0, "lut", 0),
        ("clock", 0, "compare", 0),
        ("lut", 1, "compare", 1),
        *(("lut", i, "flow", i) for i in range(3)),
        *(("lut", i, "scope", i) for i in range(3)),
    }
    assert [p["name"] for p in node(model, "compare")["inputs"]] == ["a", "b"]
    assert [p["name"] for p in node(model, "lut")["outputs"]] == ["out 0", "out 1", "out 2"]


def test_wires_made_in_a_loop_are_read_from_the_live_diagram(written):
    model = written(
        script(
            "a = Constant(1)\nb = Function(lambda x, y: x)\nc = Scope()",
            "*[Connection(a, b[i]) for i in range(2)], Connection(b, c)",
        )
    )
    assert wires(model) == {("a", 0, "b", 0), ("a", 0, "b", 1), ("b", 0, "c", 0)}


def test_blocks_without_a_variable_get_a_name_of_their_class(written):
    model = written(script("parts = [Constant(1), Scope()]", "Connection(*parts)", names="*parts"))
    assert [n["name"] for n in model["graph"]["nodes"]] == ["Constant", "Scope"]
    assert [
        n["name"] for n in written(script("", names="Constant(1), Constant(2)"))["graph"]["nodes"]
    ] == ["Constant", "Constant 2"]


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
    names = [n["name"] for n in model["graph"]["nodes"]]
    assert names == [
        "Int block",
        "X block",
        "x block 2",
        "K block",
        "Lambda block",
        "Amplifier",
        "blocks block",
        "simulation",
    ]
    assert (
        "x = int_block.engine.state\n    return x - k * len(x_block())"
        in model["codeContext"]["code"]
    )
    assert model["events"][0]["params"] == {
        "func_evt": "height",
        "func_act": "lambda t: x_block.engine.set(k_block.gain)",
    }


def test_context_follows_functions_imports_loops_and_changes(written):
    code = written(
        script(
            "a = Amplifier(gain(3))\ns = Source(lambda t: table[int(t / 9)])",
            before="""
import math
from os import path, sep
unused = path.join("a", "b")
table = []
for i in range(4):
    table.append(scale * i) if i else table.append(0.0)
scale = 1.0
@np.vectorize
def gain(x):
    '''Twice
    the root.'''
    return 2 * root(x)
root = math.sqrt
np.random.seed(1)
note = \"\"\"not
needed\"\"\"
""".replace("table = []", "scale = 2.0\ntable = []").replace("scale = 1.0\n", ""),
        )
    )
    code = code["codeContext"]["code"]
    for text in ("table = [0.0, 2.0, 4.0, 6.0]",):
        assert text in code
    for text in ("unused", "sep", "note", "import numpy", "seed", "scale", "gain", "append"):
        assert text not in code


def test_a_text_of_several_lines_survives_pathviews_indentation(written):
    code = written(
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
    )["codeContext"]["code"]
    assert "TEXT = 'one\\ntwo'" in code
    assert "return f'a{TEXT}\\nb'" in code
    assert '"""Doc\n    string."""' in code


def test_decorated_functions(written):
    model = written(
        script(
            "@Source\ndef wave(t):\n    return np.sin(w * t)\ns = Scope()",
            "Connection(wave, s)",
            before="w = 3.0",
            names="wave, s",
        )
    )
    assert node(model, "wave")["params"] == {"func": "wave_function"}
    assert model["codeContext"]["code"] == (
        "w = 3.0\n\ndef wave_function(t):\n    return np.sin(w * t)"
    )


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
    inside = {n["name"]: n for n in plant["graph"]["nodes"]}
    assert list(inside) == ["Interface", "state", "inner"]
    assert [p["name"] for p in inside["Interface"]["inputs"]] == ["y", "x"]
    assert [n["name"] for n in inside["inner"]["graph"]["nodes"]] == ["Interface", "gain"]
    event = plant["graph"]["events"][0]
    assert event["params"]["func_evt"] == "lambda t: plant_state.engine.state - 0.5"
    # PathView imports the events of the top level only
    assert model["codeContext"]["code"] == "from pathsim.events import ZeroCrossing"


@pytest.mark.parametrize(
    ("imports", "blocks", "order"),
    [
        (
            "from pathsim_jsbsim_blocks import ISAtmosphere",
            "air = ISAtmosphere()",
            ["pathsim_jsbsim_blocks"],
        ),
        ("from pathsim_flight import ISAtmosphere", "air = ISAtmosphere()", ["pathsim_flight"]),
        (
            "from pathsim_flight import ISAtmosphere\nfrom pathsim_jsbsim_blocks import DoubletSource",
            "air = ISAtmosphere()\nd = DoubletSource()",
            ["pathsim_jsbsim_blocks", "pathsim_flight"],
        ),
        (
            "from pathsim_jsbsim_blocks import ISAtmosphere\nfrom pathsim_flight import JSBSimWrapper",
            "air = ISAtmosphere()\nfdm = JSBSimWrapper(input_properties=['fcs/elevator-cmd-norm'],"
            "output_properties=['attitude/theta-deg'])",
            ["pathsim_flight", "pathsim_jsbsim_blocks"],
        ),
    ],
)
def test_toolboxes_stand_in_an_order_in_which_the_right_class_wins(written, imports, blocks, order):
    """ISAtmosphere is in both; PathView takes the class of the toolbox that is registered last."""
    required = written(script(blocks, before=imports))["requiredToolboxes"]
    assert [t["importPath"] for t in required] == order
    assert required[-1] == {
        "id": f"pypi:{order[-1].replace('_', '-')}",
        "displayName": order[-1].replace("_", "-"),
        "source": {"type": "pypi", "pkg": order[-1].replace("_", "-")},
        "importPath": order[-1],
    }


def test_classes_that_hide_each_other_are_refused(written):
    with pytest.raises(DiagramError, match="same class name 'ISAtmosphere'"):
        written(
            script(
                "a = ISAtmosphere()\nb = Other()",
                before=(
                    "from pathsim_jsbsim_blocks import ISAtmosphere\n"
                    "from pathsim_flight import ISAtmosphere as Other"
                ),
            )
        )
    with pytest.raises(DiagramError, match="hide each other"):
        written(
            script(
                "a = ISAtmosphere()\nb = CAStoTAS()",
                before=(
                    "from pathsim_jsbsim_blocks import ISAtmosphere\n"
                    "from pathsim_flight import CAStoTAS"
                ),
            )
        )


def test_the_same_script_gives_the_same_file(export, tmp_path):
    export(OSCILLATOR, "oscillator")
    first = (tmp_path / "oscillator.pvm").read_bytes()
    (tmp_path / "oscillator.pvm").unlink()
    export(OSCILLATOR, "oscillator")
    assert (tmp_path / "oscillator.pvm").read_bytes() == first
    export(OSCILLATOR, "oscillator")  # over the existing file
    assert (tmp_path / "oscillator.pvm").read_bytes() == first


def test_positions_in_an_existing_model_are_kept_by_name(export, tmp_path):
    model = export(OSCILLATOR, "oscillator")
    node(model, "spring")["position"] = {"x": 1230, "y": -450}
    node(model, "damper")["params"]["_rotation"] = 1
    node(model, "spring")["params"]["gain"] = "99"
    model["graph"]["annotations"][0]["position"] = {"x": 7, "y": 7}
    model["graph"]["annotations"].append({"id": "mine", "content": "note"})
    (tmp_path / "oscillator.pvm").write_text(json.dumps(model))
    again = export(
        OSCILLATOR.replace("force = Adder()", "force = Adder()\nmore = Amplifier(3)").replace(
            "force, scope]", "force, scope, more]"
        ),
        "oscillator",
    )
    assert node(again, "spring")["position"] == {"x": 1230, "y": -450}
    assert node(again, "spring")["params"]["gain"] == "-k"
    assert node(again, "damper")["params"]["_rotation"] == 1
    more, others = node(again, "more"), [n for n in again["graph"]["nodes"] if n["name"] != "more"]
    assert more["params"]["gain"] == "3"
    assert all(
        abs(more["position"]["x"] - n["position"]["x"]) >= 160
        or abs(more["position"]["y"] - n["position"]["y"]) >= 80
        for n in others
    )
    assert again["graph"]["annotations"][0]["position"] == {"x": 7, "y": 7}
    assert again["graph"]["annotations"][1]["content"] == "note"


def test_the_docstring_becomes_an_annotation(written):
    assert written(OSCILLATOR)["graph"]["annotations"][0]["content"] == (
        "# Oscillator\n\nA mass on a spring.\n\nSecond paragraph with `code`."
    )
    model = written(
        r'''
"""Title
=====

One :math:`x^2` and
two:
- a
- b

.. math::

    x + 1 = v
"""
'''
        + script("a = Constant(1)")
    )
    assert model["graph"]["annotations"][0]["content"] == (
        "# Title\n\nOne $x^2$ and two:\n- a\n- b\n\n$$ x + 1 = v $$"
    )
    assert written(script("a = Constant(1)"))["graph"]["annotations"] == []


BLOCK = "a = Amplifier(2.0)"

HEAD = """
import numpy as np
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import *
from pathsim.events import *
from pathsim.solvers import *
"""

REFUSED = {
    "own class": (
        script(
            "class Mine(Amplifier):\n    def update(self, t):\n        pass\na = Mine()", names="a"
        ),
        11,
        "does not know the block 'Mine'.*installed package",
    ),
    "JSBSim in a function": (
        script(
            "import jsbsim\nfdm = jsbsim.FGFDMExec(None)\n"
            "a = DynamicalFunction(lambda u, t: fdm.run())",
            names="a",
        ),
        10,
        "runs ahead of the clock in a function: use Aircraft or JSBSimFDM",
    ),
    "core block that PathView lacks": (
        script("a = Comparator()"),
        8,
        "does not know the block 'Comparator'",
    ),
    "core block that PathView lacks, in a script with JSBSim": (
        script("import jsbsim\na = Comparator()"),
        9,
        "does not know the block 'Comparator'(?!.*runs ahead)",
    ),
    "switched off": (
        script(BLOCK + "\nb = Scope()\nc = Connection(a, b)\nc.off()", "c", names="a, b"),
        8,
        "a connection of 'a' is switched off when the run begins",
    ),
    "event switched off": (
        script(f"{BLOCK}\ne = ZeroCrossing(len, None)\ne.off()", names="a", events="[e]"),
        9,
        "'e' is switched off when the run begins",
    ),
    "absent block": (
        script(f"{BLOCK}\nb = Constant(1)\ns = Source(lambda t: b.value)", names="a, s"),
        None,
        "'b', which is not in the simulation",
    ),
    "not listed": (
        script(f"{BLOCK}\nb = Scope()", "Connection(a, b)", names="a"),
        None,
        "'b' is wired but not in the list",
    ),
    "twice": (
        script(BLOCK, names="Subsystem([Interface(), a]), a"),
        8,
        "'a' is in the diagram twice",
    ),
    "not adaptive": (
        script(BLOCK, after="sim.run(3, adaptive=False)").replace("log=False", "Solver=RKCK54"),
        10,
        "adaptive",
    ),
    "relative import": ("from . import x", 1, "script fails: ImportError"),
    "error": ("x = 1\ny = x / 0", 2, "script fails: ZeroDivisionError"),
    "exit": ("import sys\nsys.exit(3)", 2, "script fails: SystemExit"),
    "syntax": ("x = (", 1, "not Python"),
    "no simulation": ("x = 1", None, "runs no Simulation"),
    "several simulations": (
        "from pathsim import Simulation\na = Simulation(log=False)\nb = Simulation(log=False)",
        None,
        "builds 2 simulations",
    ),
}


@pytest.mark.filterwarnings("ignore:.*not among the blocks")
@pytest.mark.parametrize("case", REFUSED)
def test_what_pathview_cannot_hold_is_refused_with_file_line_and_reason(case, written, tmp_path):
    text, line, reason = REFUSED[case]
    with pytest.raises(DiagramError, match=reason) as caught:
        written(text)
    assert caught.value.path == str(tmp_path / "script.py")
    if line is not None:
        assert caught.value.line == line
        assert str(caught.value).startswith(f"{tmp_path / 'script.py'}:{line}: ")
    assert os.listdir(tmp_path) == ["script.py"]


def test_settings_are_those_of_the_simulation_that_a_function_returns(written):
    settings = written(
        """
        from pathsim import Simulation
        from pathsim.blocks import Constant
        a = Constant(1.0)
        step = 0.5  # another one than the function's
        def build(step):
            return Simulation([a], [], dt=step, log=False)
        sim = build(0.02)
        sim.run(3)
        """
    )["simulationSettings"]
    assert float(settings["dt"]) == 0.02


def test_a_value_that_a_function_of_the_script_changes(written):
    model = written(
        script(
            "a = Source(lambda t: k[-1] * t)",
            before="k = [1.0]\ndef more(x):\n    k.append(x)\nmore(5)\n",
        )
    )
    assert model["codeContext"]["code"] == "k = [1.0, 5]"


def test_functions_of_a_module_beside_the_script_are_copied(written, tmp_path):
    (tmp_path / "beside_the_script.py").write_text(
        "K = 2.0\nN = [0]\ndef wave(t):\n    N[0] += 1\n    return K * t"
    )
    model = written(script("a = Source(wave)", before="from beside_the_script import wave"))
    assert node(model, "a")["params"]["func"] == "wave"
    assert "def wave(t):\n    N[0] += 1" in model["codeContext"]["code"]
    assert "beside_the_script" not in model["codeContext"]["code"]
    model = written(script("a = Amplifier(K)", before="from beside_the_script import K"))
    assert node(model, "a")["params"]["gain"] == "K"
    assert model["codeContext"]["code"] == "K = 2.0"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "beside_the_script.py").write_text("K = 3.0")
    model = written(script("a = Amplifier(K)", before="from beside_the_script import K"), "other/a")
    assert model["codeContext"]["code"] == "K = 3.0"


def test_a_run_whose_end_the_script_does_not_hear_of(written):
    run = "try:\n    sim.run(0.05)\nexcept BaseException:\n    pass"
    model = written(script("a = Amplifier(2.0)", after=run))
    assert model["simulationSettings"]["duration"] == "0.05"


def test_a_run_in_another_thread_is_not_taken_over(written):
    run = (
        "import threading\nt = threading.Thread(target=sim.run, args=(0.05,))\nt.start()\nt.join()"
    )
    with pytest.raises(DiagramError, match=r"at t = 0\.0\d* when its first run begins"):
        written(script("a = Amplifier(2.0)", after=run))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the pool is of forks")
def test_a_run_in_another_process_is_refused(written):
    run = "from multiprocessing import get_context\nwith get_context('fork').Pool(1) as pool:\n"
    with pytest.raises(DiagramError, match="in a separate process"):
        written(
            script(
                "a = Amplifier(2.0)",
                after=f"def go(k):\n    sim.run(k)\n{run}    pool.map(go, [1])",
            )
        )


@pytest.mark.parametrize(
    ("law", "value"),
    [
        (
            "class Law:\n    def __call__(self, t):\n        return self.k * t\n    k = float(2)",
            "Law()",
        ),
        ("def build(index, make, self):\n    return make", "build(index=1, make=np.sin, self=2)"),
        (
            "from collections import namedtuple\nP = namedtuple('P', 'x')\np = P(2.0)",
            "lambda t: p.x * t",
        ),
        (
            "class C:\n    @classmethod\n    def k(cls):\n        return 2.0\nc = C()",
            "lambda t: c.k() * t",
        ),
        ("k = [2.0]\nif __name__ != '__main__':\n    k.append(3.0)", "lambda t: sum(k) * t"),
    ],
)
def test_ordinary_python_becomes_a_model(law, value, export):
    assert export(script(f"a = Source({value})", before=law, after="sim.run(0.05)"))


@pytest.mark.parametrize(
    ("before", "late", "value"),
    [
        ("laws = {'f': lambda: 1.0}\n_ = laws.__setitem__('f', lambda: 2.0)", "laws['f']()", 2.0),
        ("class C:\n    k = 1.0\nc = C()\n_ = setattr(C, 'k', 9.0)", "c.k", 9.0),
        ("laws = [lambda t: -t]\n_ = laws.__setitem__(0, lambda t: +t)", "laws[0](t)", 7.0),
        ("laws = [lambda: max((1, 2)), lambda: max((1, 3))]", "laws[1]() - laws[0]()", 1.0),
        (
            "def counter():\n    n = 0\n    def up():\n        nonlocal n\n        n += 1\n"
            "        return n\n    return up\nup = counter()\nup()",
            "up()",
            2.0,
        ),
        ("class C:\n    k = 3.0\n    def f(self, t):\n        return self.k\n", "C().f(t)", 3.0),
        ("def parent():\n    return len(__file__) * 0 + 4.0", "parent()", 4.0),
        ("import argparse\nargs = argparse.Namespace(gain=1.5)", "args.gain", 1.5),
        ("from functools import lru_cache\n@lru_cache\ndef f(x):\n    return 2 * x", "f(4)", 8),
        ("from functools import partial\nf = partial(max, 3.0)", "f(1.0)", 3.0),
        ("from collections import deque\nq = deque([1.0, 2.0], 3)", "q[1] + q.maxlen", 5.0),
        ("from enum import Enum\nclass M(Enum):\n    A = 1\nm = M.A", "m.value", 1.0),
        ("rng = np.random.default_rng(3)\nrng.normal()", "rng.normal() * 0 + 1", 1.0),
        ("events = 6.0", "events", 6.0),
    ],
)
def test_what_functions_need_is_written_as_it_is_when_the_run_begins(
    before, late, value, export, tmp_path
):
    export(script(f"a = Source(lambda t: t if t < 5 else {late})", before=before))
    again = convert_model(tmp_path / "script.pvm", tmp_path / "again.py")
    assert runpy.run_path(str(again), run_name="again")["a"].func(7.0) == value


@pytest.mark.parametrize(
    ("after", "state"),
    [
        ("a.engine.set(3.0)", "3.0"),
        ("parts = {'a': a}\nparts['a'].engine.set(3.0)", "3.0"),
        ("sim.steadystate()", None),
    ],
)
def test_a_state_before_the_run_is_the_initial_value(after, state, written):
    wires = "Connection(a, b), Connection(b, a[0]), Connection(one, a[1])"
    model = written(
        script("one = Constant(1.0)\nb = Amplifier(-1.0)\na = ODE(lambda x, u, t: u[0:1] + u[1], 0.0)",
               wires, after=after + "\nsim.run(0.5)")
    )  # fmt: skip
    value = eval(node(model, "a")["params"]["initial_value"], {"np": np})
    np.testing.assert_allclose(value, 1.0 if state is None else float(state), atol=1e-6)


def test_a_state_that_no_initial_value_gives_is_refused_naming_the_call(export):
    with pytest.raises(DiagramError, match=r"steadystate\(\) in line 12 changes its state"):
        export(
            script(
                "one = Constant(1.0)\na = TransferFunctionNumDen([1.0], [1.0, 1.0])\ns = Scope()",
                "Connection(one, a), Connection(a, s)",
                after="sim.steadystate()\nsim.run(0.5)",
            )
        )


def test_an_array_that_an_event_changes_later_stays_the_parameter(written):
    model = written(
        script(
            "for k in (gain,):\n    amp = Amplifier(k)\nscope = Scope()",
            before="gain = np.array([1.0])\ndef late(t):\n    gain[0] = 9.0\n",
            names="amp, scope",
            events="[ScheduleList([3.0], func_act=late)]",
            after="sim.run(0.05)",
        )
    )
    assert node(model, "amp")["params"] == {"gain": "gain"}


def test_what_pathview_lacks_is_no_obstacle_where_the_flight_does_not_need_it(export):
    assert export(script(BLOCK, after="sim.run(0.05)").replace("log=False", "iterations_max=9"))


def test_a_parameter_changed_before_the_flight_needs_it_is_seen(written):
    model = written(script("a = Delay(5.0)\na.tau = 3.0", names="a", after="sim.run(0.05)"))
    assert node(model, "a")["params"] == {"tau": "3.0"}


def test_a_failed_export_leaves_the_old_file_alone(export, tmp_path):
    export(OSCILLATOR)
    before = (tmp_path / "script.pvm").read_bytes()
    with pytest.raises(DiagramError):
        export("x = 1")
    assert (tmp_path / "script.pvm").read_bytes() == before


def test_something_that_is_not_a_model_is_not_overwritten(export, tmp_path):
    (tmp_path / "script.pvm").write_text("precious")
    with pytest.raises(DiagramError, match="not a PathView model"):
        export(OSCILLATOR)
    assert (tmp_path / "script.pvm").read_text() == "precious"


def test_a_model_that_cannot_be_written_is_an_error(export, tmp_path):
    (tmp_path / "a.py").write_text(OSCILLATOR)
    with pytest.raises(DiagramError, match=r"nowhere.*cannot be written"):
        export_script(tmp_path / "a.py", tmp_path / "nowhere" / "a.pvm")
    with pytest.raises(DiagramError, match="cannot be read"):
        export_script(tmp_path / "missing.py")


def test_running_a_script_leaves_the_process_as_it_was(export, tmp_path):
    before = list(sys.path), list(sys.argv), set(sys.modules)
    world = sys.stdout, list(warnings.filters), np.get_printoptions()
    changes = """
import sys, warnings
warnings.simplefilter("error")
np.set_printoptions(precision=2)
sys.stdout = None
"""
    with pytest.warns(UserWarning, match="first run"):
        export(
            script("a = Amplifier(2.0)", before=changes, after="sim.run(0.05)\nsim.run(0.05)"),
            "left_over",
        )
    assert world == (sys.stdout, list(warnings.filters), np.get_printoptions())
    assert (list(sys.path), list(sys.argv)) == before[:2]
    assert not [m for m in set(sys.modules) - before[2] if "left_over" in m]


@pytest.mark.parametrize(("code", "hint"), [(2, True), (3, False)])
def test_a_script_that_wants_arguments_hears_that_there_are_none(code, hint, written):
    with pytest.raises(DiagramError, match="SystemExit") as error:
        written(f"raise SystemExit({code})")
    assert ("PathView passes no arguments" in str(error.value)) == hint


def test_live_values_keep_their_type_and_shape(written):
    model = written(
        script(
            """
a = Amplifier(gain=(k := 3.0))
b = Integrator(1.0)
b.initial_value = np.array([1.0, 2.0], dtype="float32")
c = Amplifier(1.0)
c.gain = np.ones(1)
""",
            names="a, b, c",
        )
    )
    assert node(model, "a")["params"]["gain"] == "3.0"
    assert node(model, "b")["params"]["initial_value"] == "np.array([1.0, 2.0], dtype='float32')"
    assert node(model, "c")["params"]["gain"] == "np.array([1.0])"


def test_no_script_at_all_is_refused():
    with pytest.raises(DiagramError):
        export_script("")


# the model is the diagram when the first run begins ----------------------------------------------

LOOP = """
i = Integrator(1.0)
a = Amplifier(-1.0)
s = Scope()
sim = Simulation([i, a, s], [Connection(i, a, s), Connection(a, i)], dt=0.01, log=False)
"""


def test_expressions_stay_where_they_give_the_diagrams_value(written):
    model = written(
        HEAD + "k = 2.0\na = Amplifier(3 * k)\nb = Amplifier(k)\nc = Amplifier(1)\n"
        "b.gain += 0.5\nc.gain = 7.0\n"
        "sim = Simulation([a, b, c], [], log=False)\nsim.run(2 * k)"
    )
    assert [node(model, n)["params"]["gain"] for n in "abc"] == ["3 * k", "2.5", "7.0"]
    assert model["simulationSettings"]["duration"] == "2 * k"


@pytest.mark.parametrize(
    ("after", "told"),
    [
        ("sim.run(1)\nsim.run(2)", ["line 13: sim.run()"]),
        (
            "sim.run(1)\na.gain = 3\nsim.steadystate()",
            ["line 14: sim.steadystate()"],
        ),
        ("for g in (1.0, 2.0):\n    a.gain = g\n    sim.run(1)", ["line 12: the loop runs"]),
        (
            "sim.run(1)\nother = Simulation([Constant()], log=False)\nother.run(3)",
            ["line 14: other.run()"],
        ),
        ("while sim.time < 1:\n    sim.timestep()", ["line 13: how long timestep() goes on"]),
    ],
)
def test_what_comes_after_the_first_run_is_named(after, told, export):
    with pytest.warns(UserWarning, match="the model is the diagram of the first run") as caught:
        export(HEAD + LOOP + after)
    assert len(caught) == 1
    assert os.path.basename(caught[0].filename) == "script.py"
    assert f"first run (line {caught[0].lineno})" in str(caught[0].message)
    for text in told:
        assert text in str(caught[0].message)


def test_a_look_at_what_was_recorded_changes_nothing(export):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".* no wire leads to it")  # of the run itself
        model = export(
            "from pathsim import Simulation\nfrom pathsim_jsbsim_blocks import FlightRecorder\n"
            "recorder = FlightRecorder()\nsim = Simulation([recorder], [], log=False)\nsim.run(1)\n"
            "recorder.save('flight.kml')\nprint(recorder.to_frame(), recorder.to_track().lat)\n"
        )
    assert node(model, "recorder")["type"] == "FlightRecorder"


@pytest.mark.parametrize("call", ["fly(sim, 7.0)", "fly(duration=7.0, sim=sim)", "b.fly(sim, 7.0)"])
def test_fly_is_a_run(call, written):
    model = written(
        HEAD + "import pathsim_jsbsim_blocks as b\n"
        "from pathsim_jsbsim_blocks import fly\n" + LOOP + call
    )
    assert float(model["simulationSettings"]["duration"]) == 7.0


def test_a_flight_after_the_first_is_named(export):
    with pytest.warns(UserWarning, match=r"fly\(\)"):
        export(
            HEAD + "from pathsim_jsbsim_blocks import fly\n" + LOOP + "fly(sim, 7.0)\nfly(sim, 1.0)"
        )


def test_a_single_run_needs_no_warning(export):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        export(
            HEAD + LOOP + "if __name__ == '__main__':\n    sim.run(1)\n    sim.plot()\n"
            "    print(s.read())"
        )


@pytest.mark.parametrize(
    ("data", "name"),
    [
        (b"\xef\xbb\xbf" + OSCILLATOR.encode(), "byte-order mark"),
        (
            b"# -*- coding: latin-1 -*-\n"
            + OSCILLATOR.replace("on a spring", "on a sp\xe9ring").encode("latin-1"),
            "latin-1",
        ),
    ],
)
def test_encodings_that_python_knows(data, name, tmp_path):
    path = tmp_path / "script.py"
    path.write_bytes(data)
    content = json.loads(export_script(path).read_text(encoding="utf-8"))
    assert len(content["graph"]["nodes"]) == 6, name
    assert "spring" in str(content) or "sp\xe9ring" in content["graph"]["annotations"][0]["content"]


@pytest.mark.parametrize("content", [b"x = 1\0\n", b"name = '\xff\xfe'\n"])
def test_a_script_that_is_no_text_is_refused(content, tmp_path):
    (tmp_path / "script.py").write_bytes(content)
    with pytest.raises(DiagramError, match=r"script\.py: not (a )?Python"):
        export_script(tmp_path / "script.py")
    assert os.listdir(tmp_path) == ["script.py"]


def test_draws_before_the_run_are_numbers_and_blocks_without_a_seed_fly_alike(export):
    model = export(
        HEAD + "k = np.random.rand()\na = Amplifier(k)\nw, p = WhiteNoise(), PinkNoise()\n"
        "sim = Simulation([a, w, p], [Connection(w, a)], log=False)\nsim.run(1)"
    )
    assert 0 < float(model["codeContext"]["code"].removeprefix("k = ")) < 1
    assert "seed" not in node(model, "w")["params"]


def test_functions_that_draw_from_a_seeded_generator(export):
    text = HEAD + (
        "np.random.seed(2)\na = Source(lambda t: np.random.rand())\n"
        "sim = Simulation([a], [], log=False)\nsim.run(1)"
    )
    assert export(text)["codeContext"]["code"] == "np.random.seed(2)"
    with pytest.raises(DiagramError, match="'a' flies otherwise in the model"):
        export(text.replace("a = ", "unused = np.random.rand()\na = "))


def test_the_script_runs_in_no_other_way_than_as_the_main_program(export, tmp_path):
    marker = tmp_path / "ran"
    export(
        HEAD + LOOP + f"if __name__ == '__main__':\n    sim.run(1)\n"
        f"    open({str(marker)!r}, 'w').close()"
    )
    assert not marker.exists()


def test_a_comparison_that_ends_before_the_run_says_so(tmp_path):
    (tmp_path / "a.py").write_text(HEAD + LOOP + "sim.run(10)", encoding="utf-8")
    with pytest.warns(UserWarning, match=r"a\.pvm: same for \d+ steps, 3 signals, to t = .* only"):
        export_script(tmp_path / "a.py", check=1e-9)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        export_script(tmp_path / "a.py", check=np.inf)


@pytest.mark.long
def test_a_process_that_has_imported_no_block_exports_a_script_with_blocks(tmp_path):
    # what this package changes in PathSim is no change of the script
    out, script = tmp_path / "hello.pvm", find_diagram("hello_jsbsim")
    command = ["-m", "pathsim_jsbsim_blocks.cli", "export", str(script), "-o", str(out)]
    done = subprocess.run([sys.executable, *command], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert out.exists()


def test_a_script_that_does_not_end_is_told_of(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(editor, "_LONG", 0.05)
    (tmp_path / "a.py").write_text(HEAD + "import time\ntime.sleep(0.5)\n" + LOOP, encoding="utf-8")
    assert main(["export", str(tmp_path / "a.py"), "-o", str(tmp_path / "a.pvm")]) == 0
    assert "still runs after 0 s; Ctrl-C ends the export" in capsys.readouterr().err


@pytest.mark.long
def test_the_models_process_does_not_import_the_program_that_exports(tmp_path):
    (tmp_path / "a.py").write_text(HEAD + LOOP, encoding="utf-8")
    program = tmp_path / "program.py"  # without a main guard
    program.write_text(
        "from pathsim_jsbsim_blocks.pathview import export_script\nprint('once')\n"
        f"export_script({str(tmp_path / 'a.py')!r})\n"
    )
    done = subprocess.run([sys.executable, str(program)], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "once\n"), done.stderr


class Pair(tuple):
    pass


@pytest.mark.parametrize(
    ("value", "data"),
    [
        *((x, True) for x in (1, 2.5, "x", None, [1, (2.0, {"x"})], {"a": [1]}, np.zeros(2))),
        *((x, False) for x in (len, [len], {"a": len}, Pair((1, 2)), np.array([len]))),
    ],
)
def test_what_is_data_all_the_way_down(value, data):
    assert is_data(value) == data
