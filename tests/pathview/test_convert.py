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
from pathview_models import block, event, model, subsystem, wire

from pathsim_jsbsim_blocks.errors import DiagramError, MissingExtraError, ParameterError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script, view
from pathsim_jsbsim_blocks.pathview.toolboxes import _distributions
from pathsim_jsbsim_blocks.pathview.variables import plain

MODEL = {
    **model(
        block("Step", "StepSource", amplitude="A", tau=""),
        block("Out", "Scope", 1, 0, _rotation=2),
        connections=[wire("Step", "Out")],
        events=[event("tick", func_act="print")],
        code="A = 2.0",
    ),
    "simulationSettings": {"duration": "3", "dt": "0.1", "solver": "SSPRK22", "dt_max": None},
}


@pytest.fixture
def convert(tmp_path):
    """Convert a model given as data or text; returns the script."""

    def convert(content, toolboxes=(), trust=()):
        path = tmp_path / "model.pvm"
        text = content if isinstance(content, str) else json.dumps(content)
        path.write_text(text, encoding="utf-8")
        out = convert_model(path, tmp_path / "out.py", toolboxes, trust)
        return out.read_text(encoding="utf-8")

    return convert


def changed(*path, **values):
    """MODEL with values put into what lies at a path."""
    content = copy.deepcopy(MODEL)
    at = content
    for key in path:
        at = at[key]
    at.update(values)
    return content


def test_parameters_that_no_block_has_are_left_out_with_a_warning(convert):
    with pytest.warns(UserWarning, match="'Step': no parameter 'old', left out$"):
        assert "old" not in convert(changed("graph", "nodes", 0, params={"old": "1"}))
    with pytest.warns(UserWarning, match="'amplitud', left out; did you mean 'amplitude'"):
        convert(changed("graph", "nodes", 0, params={"amplitud": "1"}))

    inside = subsystem("S", events=[event("tick", t_perod="1")])
    with pytest.warns(UserWarning, match="event 'tick'.*t_perod"):
        assert "t_perod" not in convert(model(inside))


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
    content = changed("graph", "nodes", 0, type="ISAtmosphere", params={})
    content["requiredToolboxes"] = [requirement(r) for r in required]
    assert f"from {module} import (\n    ISAtmosphere\n)" in convert(content)


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
    content = changed("graph", "nodes", 0, type="Twice", params={"offset": "1.0"})
    with pytest.raises(DiagramError, match="does not know the block 'Twice'"):
        convert(content)
    named = {**content, "requiredToolboxes": [requirement("my_toolbox")]}
    for code in (
        convert(content, [toolbox]),
        convert(content, ["anything:my_toolbox"]),
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
        sys.modules.pop("this", None)
        with pytest.raises(DiagramError, match=reason):
            convert({**MODEL, "requiredToolboxes": [requirement(import_path, package)]})
        assert "my_toolbox" not in sys.modules
        assert "this" not in sys.modules
    assert capsys.readouterr() == ("", "")


def test_a_trusted_package_stands_for_its_own_modules_only(convert, toolbox):
    def requiring(import_path):
        return {**MODEL, "requiredToolboxes": [requirement(import_path, toolbox)]}

    assert "StepSource(" in convert(requiring("my_toolbox.parts"), trust=[toolbox])
    with pytest.raises(DiagramError, match="does not belong"):
        convert(requiring("this"), trust=[toolbox])
    assert "StepSource(" in convert(requiring("this"), trust=[f"{toolbox}:this"])


def test_a_known_toolbox_that_is_not_installed(convert, monkeypatch):
    monkeypatch.setitem(sys.modules, "pathsim_chem", None)
    with pytest.raises(ParameterError, match=r"not installed.*pip install pathsim-chem"):
        convert({**MODEL, "requiredToolboxes": [requirement("pathsim_chem")]})


@pytest.mark.parametrize("code", ["raise SystemExit(3)", "1 / 0"])
def test_a_toolbox_that_fails_to_import(convert, toolbox, tmp_path, code):
    (tmp_path / "site" / "my_toolbox" / "__init__.py").write_text(code)
    with pytest.raises(ParameterError, match="'my-toolbox' cannot be imported: "):
        convert(MODEL, [toolbox])


@pytest.mark.parametrize(
    ("toolboxes", "message"),
    [
        (["not-there"], "'not-there' is not installed.*pip install not-there"),
        (["a b"], "PACKAGE or PACKAGE:IMPORT.PATH"),
        (["x:1"], "PACKAGE"),
    ],
)
def test_toolboxes_that_are_none(convert, toolboxes, message):
    with pytest.raises(ParameterError, match=message):
        convert(MODEL, toolboxes)


def test_a_script_that_is_there_is_not_overwritten_unless_named(tmp_path):
    path, original = tmp_path / "model.pvm", tmp_path / "model.py"
    path.write_text(json.dumps(MODEL))
    original.write_text("precious")
    with pytest.raises(DiagramError, match=r"model\.py: exists.*-o FILE\.py"):
        convert_model(path)
    assert original.read_text() == "precious"
    convert_model(path, original)
    assert "StepSource(" in original.read_text()
    original.unlink()
    assert convert_model(path) == original


def namespace_of(code):
    namespace = {"__name__": "converted"}
    exec(code, namespace)
    return namespace


def test_blocks_and_events_do_not_hide_values_of_the_code(convert):
    inside = [
        block("if", "Interface", 0, 0),
        block("k", "Constant", value="plant_k"),
        block("l", "Constant", value="plant_k"),
    ]
    content = model(
        block("gain", "Constant", value="gain"),
        block("Gain block", "Constant"),
        block("two", "Constant", value="gain"),
        block("np", "Constant", value="np.pi"),
        block("blocks", "Constant", value="4"),
        block("max", "Constant", value="max(1, 2)"),
        subsystem("plant", *inside, events=[event("e", func_act="plant_e")]),
        events=[event("tick", func_act="tick"), event("tock", func_act="tick")],
        code="gain = 3.0\ngain_block = 1.0\nplant_k = 5.0\ndef tick(t): pass\ndef plant_e(t): pass",
    )
    names = namespace_of(convert({**content, "simulationSettings": {"dt": "gain / 100"}}))
    assert (names["gain"], names["gain_block"], names["plant_k"]) == (3.0, 1.0, 5.0)
    plant, *blocks = names["sim"].blocks
    assert [b.value for b in blocks] == [3.0, 1.0, 3.0, np.pi, 4, 2]
    assert [b.value for b in plant.blocks] == [5.0, 5.0]
    assert names["tick_event"].func_act is names["tock"].func_act is names["tick"]
    assert names["plant_e_event"].func_act is names["plant_e"]
    assert names["sim"].dt == 0.03


@pytest.mark.parametrize(
    ("code", "nodes", "message"),
    [
        (
            "gain = 3.0\ndef f(t): return gain * t",
            [block("Gain", "Constant")],
            "block 'Gain': .*'gain'",
        ),
        (
            "",
            [block("max", "Constant"), block("s", "Source", func="lambda t: max(t, 1)")],
            "block 'max': .*uses the name 'max'",
        ),
        ("plant = 3.0", [subsystem("Plant")], "subsystem 'Plant': .*'plant'"),
        ("plant_interface = 3.0", [subsystem("Plant")], "'plant_interface'"),
    ],
)
def test_a_name_that_could_mean_a_block_or_a_value_is_refused(convert, code, nodes, message):
    with pytest.raises(DiagramError, match=message):
        convert(model(*nodes, code=code))


@pytest.mark.parametrize(
    "separator", ["\n", "\r", "\x0b", "\x0c", "\x1c", "\x85", "\u2028", "\u2029", "\0"]
)
def test_a_name_cannot_end_its_line(convert, separator):
    hostile = f"sub{separator}import os; os.makedirs('owned')"
    script = convert(model(subsystem(hostile, block("io", "Interface", 0, 0))))
    comment = "# Subsystem: sub\N{REPLACEMENT CHARACTER}"
    assert len([line for line in script.split("\n") if line.startswith(comment)]) == 1
    assert sum(isinstance(n, ast.Import) for n in ast.walk(ast.parse(script))) == 2  # np, plt
    assert plain(hostile) in namespace_of(script)


@pytest.mark.parametrize(
    "name", ['"""; import antigravity; """', "\\", 'x"', "\n", "\\N{x}", "é\u202e"]
)
@pytest.mark.skipif(sys.platform == "win32", reason="no such file names")
def test_a_file_name_stays_in_its_docstring(name, tmp_path):
    path = tmp_path / f"{name}.pvm"
    path.write_text(json.dumps(MODEL))
    code = convert_model(path, tmp_path / "out.py").read_text(encoding="utf-8")
    first, *rest = ast.parse(code).body
    shown = re.sub("[\n\u202e]", "\N{REPLACEMENT CHARACTER}", f"{name}.pvm")
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
    assert namespace_of(convert(changed("simulationSettings", dt="A / 4 # s")))["sim"].dt == 0.5


def test_blocks_of_other_levels_with_the_same_variable(convert):
    """PathView names "r" in "q" in "p" as "q_r" in "p", and "q" in "p" as "q" beside it."""
    ids = itertools.count()

    def constant(name, value):
        return {**block(name, "Constant", value=value), "id": f"{next(ids)}"}

    def sub(name, *nodes):
        port = {**block("io", "Interface", 0, 0), "id": f"{next(ids)}"}
        return {**subsystem(name, port, *nodes), "id": f"{next(ids)}"}

    inner = sub("q", constant("r", "3"), constant("interface", "4"))
    names = namespace_of(
        convert(
            model(
                sub("q", constant("top", "1")),
                sub("p", constant("q r", "2"), inner),
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


def position(x):
    return changed("graph", "nodes", 0, position={"x": x, "y": 0})


DAMAGED = {
    "empty node": (changed("graph", nodes=[{}]), "graph.nodes[0].id is missing"),
    "type": (changed("graph", "nodes", 1, type=3), "graph.nodes[1].type must be text, not 3"),
    "in a subsystem": (model(subsystem("S", {})), "graph.nodes[0].graph.nodes[0].id is missing"),
    "port number": (
        changed("graph", connections=[wire("Step", "Out", True)]),
        "graph.connections[0].sourcePortIndex must be a whole number, not True",
    ),
    "events": ({**MODEL, "events": "tick"}, "events must be a list, not 'tick'"),
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
    content, message = DAMAGED[case]
    path = tmp_path / "model.pvm"
    path.write_text(json.dumps(content))
    if call is not convert_model:
        (tmp_path / "model.py").write_text("from pathsim import Simulation\nsim = Simulation()")
    with pytest.raises(DiagramError, match=re.escape(f"{path}: damaged: {message}")) as caught:
        call(path)
    assert caught.value.path == str(path)
    assert path.read_text() == json.dumps(content)


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
    inside = block("k", "Constant")
    for i in range(levels):
        inside = subsystem(f"s{i}", inside)
    return model(inside)


def test_subsystems_thirty_deep(convert):
    assert convert(nested(30)).count("Subsystem(") == 30


@pytest.mark.parametrize("name", ["Class", "lambda", "f.o.r", "Not"])
def test_a_block_or_event_named_like_a_keyword_gets_another_name(name, convert):
    keyword = name.replace(".", "").lower()
    inside = {**block(name, "Integrator"), "id": "inside"}
    code = convert(model(block(name, "Constant"), subsystem("Plant", inside), events=[event(name)]))
    assert f"{keyword}_block = Constant(" in code
    assert f"plant_{keyword} = Integrator(" in code
    assert f"{keyword}_event = Schedule(" in code
    compile(code, "script", "exec")


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
    "two wires": (changed("graph", connections=[wire("Step", "Out")] * 2), "is already connected"),
    "parameter": (
        changed("graph", "nodes", 0, params={"amplitude": "2 +"}),
        "block 'Step': parameter 'amplitude' is not a Python expression: '2 \\+'",
    ),
    "setting": (changed("simulationSettings", dt="1 second"), "setting 'dt'"),
    "solver": (changed("simulationSettings", solver="RK5"), "unknown solver 'RK5'; did you mean"),
    "code": (changed("codeContext", code="x = ("), "the code is not a Python code"),
    "keyword": (model(subsystem("For")), "subsystem 'For': .* uses the name 'for'"),
    "of 2025": ({"nodes": [], "edges": [], "nodeCounter": 0}, "PathView's first version, of 2025"),
    "nested too deep": ("[" * 100_000, "not a PathView model"),
    "the id of its subsystem": (
        model(subsystem("S", block("io", "Interface"), {**block("b", "Constant"), "id": "S"})),
        "blocks 'S' and 'b' have the same id 'S'",
    ),
    "an interface outside": (
        model(block("Step", "StepSource"), block("io", "Interface", 1, 1)),
        "block 'io' is an Interface outside a subsystem",
    ),
    "two interfaces": (
        model(subsystem("S", block("in", "Interface"), block("out", "Interface"))),
        "subsystem 'S' has 2 interfaces, 'in' and 'out'",
    ),
    "blocks in a block": (
        changed("graph", "nodes", 1, graph={"nodes": [block("b", "Constant")]}),
        "block 'Out' has blocks inside but is not a Subsystem: 'Scope'",
    ),
    "unknown block after a subsystem": (
        model(subsystem("S", block("io", "Interface")), block("gain", "Amplifer")),
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
    "deep subsystems": (nested(40), "damaged: graph.nodes.*nested deeper than 100"),
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
    content, message = BAD[case]
    with pytest.raises(DiagramError, match=message) as caught:
        convert(content)
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
    path = tmp_path / "model.pvm"
    path.write_text(json.dumps(MODEL))
    expected = undated(convert_model(path, tmp_path / "out.py").read_text())
    (tmp_path / "target.py").write_text("old")
    link = tmp_path / "link.py"
    link.symlink_to("target.py")
    convert_model(path, link)
    assert link.is_symlink()
    assert undated((tmp_path / "target.py").read_text()) == expected
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    # open for both, so that neither end waits
    end = os.open(pipe, os.O_RDWR)
    try:
        convert_model(path, pipe)
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
