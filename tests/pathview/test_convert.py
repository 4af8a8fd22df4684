"""Models to scripts: nothing that the model says is dropped, and bad files say what is bad."""

import ast
import copy
import itertools
import json
import os
import re
import sys

import numpy as np
import pytest

from pathsim_jsbsim_blocks.errors import DiagramError, MissingExtraError, ParameterError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script, view
from pathsim_jsbsim_blocks.pathview.toolboxes import _distributions
from pathsim_jsbsim_blocks.pathview.variables import plain

pytest.importorskip("pathview")


def block(name, kind, inputs=0, outputs=1, **params):
    ports = {
        side: [{"id": f"{name}-{side}-{i}", "name": f"{i}", "index": i} for i in range(n)]
        for side, n in (("inputs", inputs), ("outputs", outputs))
    }
    return {
        "id": name,
        "type": kind,
        "name": name,
        "position": {"x": 0, "y": 0},
        "params": params,
        **ports,
    }


def wire(source, target, out=0, into=0):
    return {
        "id": f"{source}-{target}",
        "sourceNodeId": source,
        "sourcePortIndex": out,
        "targetNodeId": target,
        "targetPortIndex": into,
    }


MODEL = {
    "version": "1.0.0",
    "metadata": {"name": "model", "created": "", "modified": ""},
    "graph": {
        "nodes": [
            block("Step", "StepSource", amplitude="A", tau=""),
            block("Out", "Scope", 1, 0, _rotation=2),
        ],
        "connections": [wire("Step", "Out")],
    },
    "events": [
        {
            "id": "e",
            "type": "pathsim.events.Schedule",
            "name": "tick",
            "position": {"x": 0, "y": 0},
            "params": {"func_act": "print"},
        }
    ],
    "codeContext": {"code": "A = 2.0"},
    "simulationSettings": {"duration": "3", "dt": "0.1", "solver": "SSPRK22", "dt_max": None},
}


@pytest.fixture
def convert(tmp_path):
    """Convert a model given as data or text; returns the script."""

    def convert(model, toolboxes=(), trust=()):
        path = tmp_path / "model.pvm"
        path.write_text(model if isinstance(model, str) else json.dumps(model), encoding="utf-8")
        out = convert_model(path, tmp_path / "out.py", toolboxes, trust)
        return out.read_text(encoding="utf-8")

    return convert


def changed(*path, **values):
    """MODEL with values put into what lies at a path."""
    model = copy.deepcopy(MODEL)
    at = model
    for key in path:
        at = at[key]
    at.update(values)
    return model


def test_a_model_becomes_a_script(convert):
    code = convert(MODEL)
    namespace = {"__name__": "converted"}
    exec(code, namespace)
    namespace["sim"].run(3)
    time, (signal,) = namespace["out"].read()
    assert time[-1] == pytest.approx(3)
    assert set(signal) == {2.0}


def test_parameters_that_no_block_has_are_left_out_with_a_warning(convert):
    with pytest.warns(UserWarning, match="'Step': no parameter 'old', left out$"):
        assert "old" not in convert(changed("graph", "nodes", 0, params={"old": "1"}))
    with pytest.warns(UserWarning, match="'amplitud', left out; did you mean 'amplitude'"):
        convert(changed("graph", "nodes", 0, params={"amplitud": "1"}))

    inside = {"nodes": [], "events": [event("tick", t_perod="1")]}
    with pytest.warns(UserWarning, match="event 'tick'.*t_perod"):
        code = convert(with_code("", {**block("S", "Subsystem", 0, 0), "graph": inside}))
    assert "t_perod" not in code


def test_type_names_of_old_files(convert):
    assert "StepSource(" in convert(changed("graph", "nodes", 0, type="pathsim.sources.StepSource"))


def requirement(import_path, package=None):
    package = package or import_path.replace("_", "-")
    return {
        "id": f"pypi:{package}",
        "displayName": package,
        "source": {"type": "pypi", "pkg": package},
        "importPath": import_path,
    }


@pytest.mark.parametrize(
    ("required", "module"),
    [
        ([], "pathsim_jsbsim_blocks"),
        (["pathsim_flight"], "pathsim_flight"),
        (["pathsim_jsbsim_blocks"], "pathsim_jsbsim_blocks"),
        (["pathsim_flight", "pathsim_jsbsim_blocks"], "pathsim_jsbsim_blocks"),
        (["pathsim_jsbsim_blocks", "pathsim_flight"], "pathsim_flight"),
    ],
)
def test_of_one_class_name_the_models_own_toolbox_counts(convert, required, module):
    model = {
        **changed("graph", "nodes", 0, type="ISAtmosphere", params={}),
        "requiredToolboxes": [requirement(r) for r in required],
    }
    assert f"from {module} import (\n    ISAtmosphere\n)" in convert(model)


@pytest.fixture
def toolbox(tmp_path, monkeypatch):
    """An installed package with a block, and the PathSim block that it is made of."""
    metadata = tmp_path / "site" / "my_toolbox-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: my-toolbox\nVersion: 1.0\n")
    (metadata / "top_level.txt").write_text("my_toolbox\n")
    folder = tmp_path / "site" / "my_toolbox"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("from .parts import Twice, Amplifier\n")
    (folder / "parts.py").write_text(
        "from pathsim.blocks import Amplifier\n"
        "class Twice(Amplifier):\n    def __init__(self, offset=0.0):\n"
        "        super().__init__(2.0)\n"
    )
    monkeypatch.syspath_prepend(folder.parent)
    _distributions.cache_clear()
    yield "my-toolbox"
    _distributions.cache_clear()
    for name in ("my_toolbox", "my_toolbox.parts"):
        sys.modules.pop(name, None)


def test_a_toolbox_named_on_the_command_line_or_in_the_model(convert, toolbox):
    model = changed("graph", "nodes", 0, type="Twice", params={"offset": "1.0"})
    with pytest.raises(DiagramError, match="does not know the block 'Twice'"):
        convert(model)
    named = {**model, "requiredToolboxes": [requirement("my_toolbox")]}
    for code in (
        convert(model, [toolbox]),
        convert(model, ["anything:my_toolbox"]),
        convert(named, [toolbox]),
        convert(named, trust=[toolbox]),
    ):
        assert "from my_toolbox import (\n    Twice\n)" in code
        assert "offset=1.0" in code


def test_a_model_imports_no_module_of_its_choice(convert, toolbox, capsys):
    for import_path, package, reason in [
        ("my_toolbox", "my-toolbox", "not a known PathSim toolbox.*--trust-toolbox my-toolbox"),
        ("this", "this", "not a known PathSim toolbox.*--trust-toolbox this"),
        ("unittest.__main__", "unittest", "not a known PathSim toolbox"),
        ("this", "pathsim-flight", "does not belong to that package.*pathsim-flight:this"),
        ("unittest.__main__", "pathsim-jsbsim-blocks", "private module"),
        ("pathsim_flight.__main__", "pathsim-flight", "private module"),
        ("my_toolbox", "pathsim-flight", "does not belong"),
        ("this", "pathsim-batt", "does not belong"),
    ]:
        model = {**MODEL, "requiredToolboxes": [requirement(import_path, package)]}
        sys.modules.pop("this", None)
        with pytest.raises(DiagramError, match=reason):
            convert(model)
        assert "my_toolbox" not in sys.modules
        assert "this" not in sys.modules
    assert capsys.readouterr() == ("", "")


def test_a_trusted_package_stands_for_its_own_modules_only(convert, toolbox):
    def model(import_path):
        return {**MODEL, "requiredToolboxes": [requirement(import_path, toolbox)]}

    assert "StepSource(" in convert(model("my_toolbox.parts"), trust=[toolbox])
    with pytest.raises(DiagramError, match="does not belong"):
        convert(model("this"), trust=[toolbox])
    assert "StepSource(" in convert(model("this"), trust=[f"{toolbox}:this"])


def test_a_known_toolbox_that_is_not_installed(convert, monkeypatch):
    monkeypatch.setitem(sys.modules, "pathsim_chem", None)
    with pytest.raises(ParameterError, match=r"not installed.*pip install pathsim-chem"):
        convert({**MODEL, "requiredToolboxes": [requirement("pathsim_chem")]})


@pytest.mark.parametrize(
    "code",
    [
        "raise SystemExit(3)",
        "import sys; sys.exit()",
        "1 / 0",
        "def f(): f()\nf()",
        "raise MemoryError",
    ],
)
def test_a_toolbox_that_fails_to_import(convert, toolbox, tmp_path, code):
    (tmp_path / "site" / "my_toolbox" / "__init__.py").write_text(code)
    with pytest.raises(ParameterError, match="'my-toolbox' cannot be imported: "):
        convert(MODEL, [toolbox])


@pytest.mark.parametrize(
    ("toolboxes", "message"),
    [
        (["not-there"], "'not-there' is not installed.*pip install not-there"),
        (["a b"], "PACKAGE or PACKAGE:IMPORT.PATH"),
        ([""], "PACKAGE"),
        (["x:1"], "PACKAGE"),
    ],
)
def test_toolboxes_that_are_none(convert, toolboxes, message):
    with pytest.raises(ParameterError, match=message):
        convert(MODEL, toolboxes)


def test_a_script_that_is_there_is_not_overwritten_unless_named(tmp_path):
    model, original = tmp_path / "model.pvm", tmp_path / "model.py"
    model.write_text(json.dumps(MODEL))
    original.write_text("precious")
    with pytest.raises(DiagramError, match=r"model\.py: exists.*-o FILE\.py") as caught:
        convert_model(model)
    assert caught.value.path == str(original)
    assert original.read_text() == "precious"
    convert_model(model, original)
    assert "StepSource(" in original.read_text()
    original.unlink()
    assert convert_model(model) == original


def with_code(code, *nodes, events=(), **settings):
    return {
        **MODEL,
        "graph": {"nodes": list(nodes)},
        "events": list(events),
        "codeContext": {"code": code},
        "simulationSettings": {**MODEL["simulationSettings"], **settings},
    }


def event(name, **params):
    return {"type": "pathsim.events.Schedule", "name": name, "params": params}


def namespace_of(code):
    namespace = {"__name__": "converted"}
    exec(code, namespace)
    return namespace


def test_blocks_and_events_do_not_hide_values_of_the_code(convert):
    names = namespace_of(
        convert(
            with_code(
                "gain = 3.0\ngain_block = 1.0\ndef tick(t): pass",
                block("gain", "Constant", value="gain"),
                block("Gain block", "Constant"),
                block("two", "Constant", value="gain"),
                block("np", "Constant", value="np.pi"),
                block("pi", "Constant", value="np.pi"),
                block("blocks", "Constant", value="4"),
                events=[event("tick", func_act="tick"), event("tock", func_act="tick")],
                dt="gain / 100",
            )
        )
    )
    assert (names["gain"], names["gain_block"]) == (3.0, 1.0)
    assert [b.value for b in names["sim"].blocks] == [3.0, 1.0, 3.0, np.pi, np.pi, 4]
    assert names["gain_block_2"].value == names["two"].value == 3.0
    assert names["tick_event"].func_act is names["tock"].func_act is names["tick"]
    assert names["sim"].dt == 0.03


def test_blocks_in_subsystems_do_not_hide_values_of_the_code(convert):
    inside = {
        "nodes": [
            block("if", "Interface", 0, 0),
            block("k", "Constant", value="plant_k"),
            block("l", "Constant", value="plant_k"),
        ],
        "events": [event("e", func_act="plant_e")],
    }
    names = namespace_of(
        convert(
            with_code(
                "plant_k = 3.0\ndef plant_e(t): pass",
                {**block("plant", "Subsystem", 0, 0), "graph": inside},
            )
        )
    )
    assert names["plant_k_block"].value == names["plant_l"].value == names["plant_k"] == 3.0
    assert names["plant_e_event"].func_act is names["plant_e"]


@pytest.mark.parametrize(
    ("code", "nodes", "message"),
    [
        (
            "gain = 3.0\ndef f(t): return gain * t",
            [block("Gain", "Constant")],
            "block 'Gain': .*'gain'",
        ),
        (
            "gain = 3.0",
            [block("gain", "Constant"), block("s", "Source", func="lambda t: gain * t")],
            "block 'gain': .*uses the name 'gain' for something else; rename one",
        ),
        ("plant = 3.0", [block("Plant", "Subsystem", 0, 0)], "subsystem 'Plant': .*'plant'"),
        ("plant_interface = 3.0", [block("Plant", "Subsystem", 0, 0)], "'plant_interface'"),
    ],
)
def test_a_name_that_could_mean_a_block_or_a_value_is_refused(convert, code, nodes, message):
    with pytest.raises(DiagramError, match=message):
        convert(with_code(code, *nodes))


@pytest.mark.parametrize(
    "separator", ["\n", "\r", "\r\n", "\x0b", "\x0c", "\x1c", "\x85", "\u2028", "\u2029", "\0"]
)
def test_a_name_cannot_end_its_line(convert, separator):
    inside = {"nodes": [block("io", "Interface", 0, 0)]}
    hostile = f"sub{separator}import os; os.makedirs('owned')"
    script = convert(
        changed(
            "graph", nodes=[{**block(hostile, "Subsystem", 0, 0), "graph": inside}], connections=[]
        )
    )
    comment = "# Subsystem: sub\N{REPLACEMENT CHARACTER}"
    assert len([line for line in script.split("\n") if line.startswith(comment)]) == 1
    assert sum(isinstance(n, ast.Import) for n in ast.walk(ast.parse(script))) == 2  # np, plt
    assert plain(hostile) in namespace_of(script)


@pytest.mark.parametrize(
    "name",
    [
        '"""; import antigravity; """',
        '"""',
        "\\",
        "a\\",
        '"',
        'x"',
        "\n",
        "\\N{x}",
        "\\x",
        "é\u202e",
    ],
)
@pytest.mark.skipif(sys.platform == "win32", reason="no such file names")
def test_a_file_name_stays_in_its_docstring(name, tmp_path):
    path = tmp_path / f"{name}.pvm"
    path.write_text(json.dumps(MODEL))
    code = convert_model(path, tmp_path / "out.py").read_text(encoding="utf-8")
    first, *rest = ast.parse(code).body
    shown = f"{name}.pvm".replace("\n", "\N{REPLACEMENT CHARACTER}").replace(
        "\u202e", "\N{REPLACEMENT CHARACTER}"
    )
    assert f"Converted from: {shown}\n" in ast.literal_eval(first.value)
    path.rename(tmp_path / "model.pvm")
    plain_name = convert_model(tmp_path / "model.pvm", tmp_path / "out.py").read_text("utf-8")
    assert [*map(ast.dump, rest)] == [*map(ast.dump, ast.parse(plain_name).body[1:])]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ("2.0 # of full scale", 2.0),
        ("2.0  # 1), tau=(3", 2.0),
        ("\n2.0\n", 2.0),
        ("(1,\n2.0)[1]", 2.0),
        ("1 +\\\n1", 2),
        ("'1, tau=2'", "1, tau=2"),
    ],
)
def test_an_expression_means_between_others_what_it_means_alone(convert, value, expected):
    script = convert(changed("graph", "nodes", 0, params={"amplitude": value, "tau": "0.5"}))
    call = next(
        n
        for n in ast.walk(ast.parse(script))
        if isinstance(n, ast.Call) and ast.unparse(n.func) == "StepSource"
    )
    given = {k.arg: eval(ast.unparse(k.value)) for k in call.keywords}
    assert given == {"amplitude": expected, "tau": 0.5}


def test_a_setting_with_a_comment(convert):
    names = namespace_of(convert(changed("simulationSettings", dt="A / 4 # s", duration="3 # s")))
    assert names["sim"].dt == 0.5


def test_blocks_of_other_levels_with_the_same_variable(convert):
    """PathView names "r" in "q" in "p" as "q_r" in "p", and "q" in "p" as "q" beside it."""
    ids = itertools.count()

    def constant(name, value):
        return {**block(name, "Constant", value=value), "id": f"{next(ids)}"}

    def sub(name, *nodes):
        return {
            **block(name, "Subsystem", 0, 0),
            "id": f"{next(ids)}",
            "graph": {"nodes": [{**block("io", "Interface", 0, 0), "id": f"{next(ids)}"}, *nodes]},
        }

    names = namespace_of(
        convert(
            with_code(
                "",
                sub("q", constant("top", "1")),
                sub(
                    "p",
                    constant("q r", "2"),
                    sub("q", constant("r", "3"), constant("interface", "4")),
                ),
                constant("same", "5"),
                constant("same", "6"),
                constant("???", "7"),
                constant("q", "8"),
            )
        )
    )
    q, p, *rest = names["sim"].blocks
    assert [b.value for b in q.blocks] == [1]
    assert [b.value for b in p.blocks if not hasattr(b, "blocks")] == [2]
    assert [b.value for s in p.blocks if hasattr(s, "blocks") for b in s.blocks] == [3, 4]
    assert [b.value for b in rest] == [5, 6, 7, 8]


def test_a_block_does_not_hide_a_function_of_python(convert):
    names = namespace_of(
        convert(
            with_code(
                "", block("max", "Constant", value="3"), block("c", "Constant", value="max(1, 2)")
            )
        )
    )
    assert [b.value for b in names["sim"].blocks] == [3, 2]
    with pytest.raises(DiagramError, match="block 'max': the model's code uses the name 'max'"):
        convert(
            with_code(
                "", block("max", "Constant"), block("s", "Source", func="lambda t: max(t, 1)")
            )
        )


def subsystem(**inside):
    return changed("graph", nodes=[{**block("S", "Subsystem"), "graph": inside}], connections=[])


def position(x):
    return changed("graph", "nodes", 0, position={"x": x, "y": 0})


DAMAGED = {
    "empty node": (changed("graph", nodes=[{}]), "graph.nodes[0].id is missing"),
    "type": (changed("graph", "nodes", 1, type=3), "graph.nodes[1].type must be text, not 3"),
    "params": (
        changed("graph", "nodes", 0, params=[1]),
        "graph.nodes[0].params must be an object, not [1]",
    ),
    "ports": (changed("graph", "nodes", 0, inputs=3), "graph.nodes[0].inputs must be a list"),
    "in a subsystem": (subsystem(nodes=[{}]), "graph.nodes[0].graph.nodes[0].id is missing"),
    "port number": (
        changed("graph", connections=[wire("Step", "Out", True)]),
        "graph.connections[0].sourcePortIndex must be a whole number, not True",
    ),
    "events": ({**MODEL, "events": "tick"}, "events must be a list, not 'tick'"),
    "code": (changed("codeContext", code=["x"]), "codeContext.code must be text, not ['x']"),
    "solver": (changed("simulationSettings", solver=5), "simulationSettings.solver must be text"),
    "position": (position("a"), "graph.nodes[0].position.x must be a coordinate, not 'a'"),
    "nowhere": (position(float("nan")), "graph.nodes[0].position.x must be a coordinate, not nan"),
}


# view: a port that it refuses, lest it serves what it should not have read
READERS = {
    "view": lambda path: view(path, port=-1),
    "export over it": lambda path: export_script(path.with_suffix(".py")),
}


@pytest.mark.parametrize(
    ("case", "call"),
    [*((case, convert_model) for case in DAMAGED), *(("type", c) for c in READERS.values())],
)
def test_of_a_damaged_model_the_error_names_file_and_place(case, call, tmp_path):
    model, message = DAMAGED[case]
    path = tmp_path / "model.pvm"
    path.write_text(json.dumps(model))
    if call is not convert_model:
        (tmp_path / "model.py").write_text("from pathsim import Simulation\nsim = Simulation()")
    with pytest.raises(DiagramError, match=re.escape(f"{path}: damaged: {message}")) as caught:
        call(path)
    assert caught.value.path == str(path)
    assert path.read_text() == json.dumps(model)


def test_parts_that_may_be_missing_or_null(convert):
    nodes = [
        {k: v for k, v in block("S", "Scope").items() if k not in ("params", "position")},
        {**block("T", "Subsystem"), "graph": None, "params": None},
    ]
    code = convert(
        {
            "version": "1.0.0",
            "events": None,
            "codeContext": {"code": None},
            "simulationSettings": None,
            "requiredToolboxes": None,
            "graph": {"nodes": nodes, "connections": None},
        }
    )
    assert "Scope()" in code


def nested(levels):
    graph = {"nodes": [block("k", "Constant")]}
    for i in range(levels):
        graph = {"nodes": [{**block(f"s{i}", "Subsystem", 0, 0), "graph": graph}]}
    return {**MODEL, "graph": graph, "events": []}


def test_subsystems_thirty_deep(convert):
    assert convert(nested(30)).count("Subsystem(") == 30


BAD = {
    "empty": ("", "not a PathView model"),
    "binary": ("\x00\x01", "not a PathView model"),
    "other JSON": ('{"a": 1}', "it has no graph"),
    "block file": ('{"type": "block", "content": {}}', "a PathView block, not a model"),
    "version": ({**MODEL, "version": "2.0.0"}, "version '2.0.0'; this package reads 1.0.0"),
    "no version": ({k: v for k, v in MODEL.items() if k != "version"}, "version None"),
    "unknown block": (
        changed("graph", "nodes", 0, type="StepSorce"),
        "block 'Step': PathView does not know.*did you mean 'StepSource'",
    ),
    "unknown event": (
        changed("events", 0, type="pathsim.events.Schedul"),
        "event 'tick': .*did you mean 'Schedule'",
    ),
    "no such block": (
        changed("graph", connections=[wire("Step", "Nobody")]),
        "connection 'Step-Nobody': no block 'Nobody'",
    ),
    "no such input": (
        changed("graph", connections=[wire("Step", "Out", 0, 3)]),
        "'Out' has no input 3",
    ),
    "no such output": (
        changed("graph", connections=[wire("Step", "Out", -1)]),
        "'Step' has no output -1",
    ),
    "two wires": (changed("graph", connections=[wire("Step", "Out")] * 2), "another wire already"),
    "parameter": (
        changed("graph", "nodes", 0, params={"amplitude": "2 +"}),
        "block 'Step': parameter 'amplitude' is not a Python expression: '2 \\+'",
    ),
    "event parameter": (
        changed("events", 0, params={"func_act": "def f"}),
        "event 'tick': parameter 'func_act'",
    ),
    "setting": (changed("simulationSettings", dt="1 second"), "setting 'dt'"),
    "solver": (changed("simulationSettings", solver="RK5"), "unknown solver 'RK5'; did you mean"),
    "code": (changed("codeContext", code="x = ("), "the code is not a Python code"),
    "name": (changed("graph", "nodes", 0, name="Lambda"), "a name gives invalid Python: 'lambda"),
    "nested too deep": ("[" * 100_000, "not a PathView model"),
    "the same id": (
        changed(
            "graph",
            nodes=[block("a", "Constant"), {**block("b", "Scope", 1, 0), "id": "a"}],
            connections=[wire("a", "a")],
        ),
        "blocks 'a' and 'b' have the same id 'a'",
    ),
    "the id of its subsystem": (
        changed(
            "graph",
            nodes=[
                {
                    **block("S", "Subsystem"),
                    "graph": {
                        "nodes": [block("io", "Interface"), {**block("b", "Constant"), "id": "S"}]
                    },
                }
            ],
            connections=[],
        ),
        "blocks 'S' and 'b' have the same id 'S'",
    ),
    "an interface outside": (
        changed(
            "graph",
            nodes=[block("Step", "StepSource"), block("io", "Interface", 1, 1)],
            connections=[wire("Step", "io")],
        ),
        "block 'io' is an Interface outside a subsystem",
    ),
    "two interfaces": (
        changed(
            "graph",
            nodes=[
                {
                    **block("S", "Subsystem"),
                    "graph": {"nodes": [block("in", "Interface"), block("out", "Interface")]},
                }
            ],
            connections=[],
        ),
        "subsystem 'S' has 2 interfaces, 'in' and 'out'",
    ),
    "blocks in a block": (
        changed("graph", "nodes", 1, graph={"nodes": [block("b", "Constant")]}),
        "block 'Out' has blocks inside but is not a Subsystem: 'Scope'",
    ),
    "unknown event in a subsystem": (
        subsystem(
            nodes=[block("io", "Interface")],
            events=[{"type": "pathsim.events.Schedul", "name": "tick"}],
        ),
        "event 'tick': .*did you mean 'Schedule'",
    ),
    "unknown block after a subsystem": (
        changed(
            "graph",
            nodes=[
                {**block("S", "Subsystem"), "graph": {"nodes": [block("io", "Interface")]}},
                block("gain", "Amplifer"),
            ],
            connections=[],
        ),
        "block 'gain': .*did you mean 'Amplifier'",
    ),
    "event in the graph": (
        changed("graph", events=[{"type": "Schedule", "name": "e"}]),
        "event 'e' is in the graph",
    ),
    "deep parameter": (
        changed("graph", "nodes", 0, params={"amplitude": "-" * 100_000 + "1"}),
        "block 'Step': parameter 'amplitude' is nested too deep",
    ),
    "deep code": (changed("codeContext", code="x = " + "-" * 100_000 + "1"), "the code is nested"),
    "deep subsystems": (json.dumps(nested(40)), "damaged: graph.nodes.*nested deeper than 100"),
    "deep value": (
        json.dumps({**MODEL, "extra": json.loads("[" * 300 + "]" * 300)}),
        "damaged: extra.*nested deeper than 100 levels",
    ),
    "embedded toolbox": (
        {**MODEL, "requiredToolboxes": [{"source": {"type": "inline"}}]},
        "a toolbox that is not a package",
    ),
    "toolbox of no name": (
        {**MODEL, "requiredToolboxes": [requirement("1x", "a b")]},
        "a toolbox that is not a package: .*not 'a b:1x'",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_models_are_refused_and_nothing_is_written(case, convert, tmp_path):
    model, message = BAD[case]
    with pytest.raises(DiagramError, match=message) as caught:
        convert(model)
    assert caught.value.path == str(tmp_path / "model.pvm")
    assert os.listdir(tmp_path) == ["model.pvm"]


def test_files_that_cannot_be_read_or_written(tmp_path):
    with pytest.raises(DiagramError, match="cannot be read"):
        convert_model(tmp_path / "none.pvm")
    (tmp_path / "model.pvm").write_text(json.dumps(MODEL))
    with pytest.raises(DiagramError, match="cannot be written"):
        convert_model(tmp_path / "model.pvm", tmp_path / "no" / "folder.py")
    (tmp_path / "taken").mkdir()
    with pytest.raises(DiagramError, match="cannot be written"):
        convert_model(tmp_path / "model.pvm", tmp_path / "taken")
    assert sorted(os.listdir(tmp_path)) == ["model.pvm", "taken"]


def undated(code):
    """A script without the second in which PathView wrote it."""
    return re.sub(r"\nGenerated by .*", "", code)


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege")
def test_links_and_devices_stay_what_they_are(tmp_path):
    model = tmp_path / "model.pvm"
    model.write_text(json.dumps(MODEL))
    expected = undated(convert_model(model, tmp_path / "out.py").read_text())
    (tmp_path / "target.py").write_text("old")
    link = tmp_path / "link.py"
    link.symlink_to("target.py")
    convert_model(model, link)
    assert link.is_symlink()
    assert undated((tmp_path / "target.py").read_text()) == expected
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    # open for both, so that neither end waits
    end = os.open(pipe, os.O_RDWR)
    try:
        convert_model(model, pipe)
        assert pipe.is_fifo()
        assert undated(os.read(end, 65536).decode()) == expected
    finally:
        os.close(end)


def test_a_byte_order_mark_is_no_part_of_a_model(convert):
    assert undated(convert("\ufeff" + json.dumps(MODEL))) == undated(convert(MODEL))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), "\ud800"])
def test_what_only_pythons_json_has_is_refused(convert, value):
    """The page could not read it, and the server not send it."""
    with pytest.raises(DiagramError, match="not a PathView model"):
        convert({**MODEL, "extra": value})


@pytest.mark.parametrize(
    "call",
    [
        lambda path: convert_model(path, path.with_name("out.py")),
        lambda path: export_script(path.with_suffix(".py")),
        lambda path: view(path, browser=False),
        lambda path: view(port=0, browser=False),
    ],
)
def test_without_pathview_the_error_says_what_to_install(call, tmp_path, monkeypatch):
    (tmp_path / "model.pvm").write_text(json.dumps(MODEL))
    (tmp_path / "model.py").write_text("from pathsim import Simulation\nsim = Simulation()")
    monkeypatch.setitem(sys.modules, "pathview", None)
    with pytest.raises(MissingExtraError, match=r"pathsim-jsbsim-blocks\[pathview\]"):
        call(tmp_path / "model.pvm")


def test_a_path_with_nul_is_refused(tmp_path):
    (tmp_path / "model.pvm").write_text(json.dumps(MODEL))
    with pytest.raises(ParameterError, match="path must be a path, not 'a\\\\x00'"):
        convert_model("a\0")
    with pytest.raises(ParameterError, match="out must be a path"):
        convert_model(tmp_path / "model.pvm", "a\0")
