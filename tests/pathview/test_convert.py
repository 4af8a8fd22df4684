"""Models to scripts: nothing that the model says is dropped, and bad files say what is bad."""

import copy
import json
import os
import sys

import pytest

from pathsim_jsbsim_blocks.errors import DiagramError, MissingExtraError, ParameterError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script, view

pytest.importorskip("pathview")


def block(name, kind, inputs=0, outputs=1, **params):
    ports = {side: [{"id": f"{name}-{side}-{i}", "name": f"{i}", "index": i} for i in range(n)]
             for side, n in (("inputs", inputs), ("outputs", outputs))}
    return {"id": name, "type": kind, "name": name, "position": {"x": 0, "y": 0},
            "params": params, **ports}


def wire(source, target, out=0, into=0):
    return {"id": f"{source}-{target}", "sourceNodeId": source, "sourcePortIndex": out,
            "targetNodeId": target, "targetPortIndex": into}


MODEL = {
    "version": "1.0.0", "metadata": {"name": "model", "created": "", "modified": ""},
    "graph": {"nodes": [block("Step", "StepSource", amplitude="A", tau=""),
                        block("Out", "Scope", 1, 0, _rotation=2)],
              "connections": [wire("Step", "Out")]},
    "events": [{"id": "e", "type": "pathsim.events.Schedule", "name": "tick",
                "position": {"x": 0, "y": 0}, "params": {"func_act": "print"}}],
    "codeContext": {"code": "A = 2.0"},
    "simulationSettings": {"duration": "3", "dt": "0.1", "solver": "SSPRK22", "dt_max": None},
}


@pytest.fixture
def convert(tmp_path):
    """Convert a model given as data or text; returns the script."""
    def convert(model, toolboxes=()):
        path = tmp_path / "model.pvm"
        path.write_text(model if isinstance(model, str) else json.dumps(model), encoding="utf-8")
        return convert_model(path, toolboxes=toolboxes).read_text(encoding="utf-8")

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
    with pytest.warns(UserWarning, match="'Step': no parameter 'old'"):
        assert "old" not in convert(changed("graph", "nodes", 0, params={"old": "1"}))


def test_type_names_of_old_files(convert):
    assert "StepSource(" in convert(changed("graph", "nodes", 0, type="pathsim.sources.StepSource"))


def requirement(import_path, package=None):
    package = package or import_path.replace("_", "-")
    return {"id": f"pypi:{package}", "displayName": package,
            "source": {"type": "pypi", "pkg": package}, "importPath": import_path}


@pytest.mark.parametrize(("required", "module"), [
    ([], "pathsim_jsbsim_blocks"),
    (["pathsim_flight"], "pathsim_flight"),
    (["pathsim_jsbsim_blocks"], "pathsim_jsbsim_blocks"),
    (["pathsim_flight", "pathsim_jsbsim_blocks"], "pathsim_jsbsim_blocks"),
    (["pathsim_jsbsim_blocks", "pathsim_flight"], "pathsim_flight"),
])
def test_of_one_class_name_the_models_own_toolbox_counts(convert, required, module):
    model = {**changed("graph", "nodes", 0, type="ISAtmosphere", params={}),
             "requiredToolboxes": [requirement(r) for r in required]}
    assert f"from {module} import (\n    ISAtmosphere\n)" in convert(model)


@pytest.fixture
def toolbox(tmp_path, monkeypatch):
    """An installed package with a block, and the PathSim block that it is made of."""
    folder = tmp_path / "site" / "my_toolbox"
    folder.mkdir(parents=True)
    (folder / "__init__.py").write_text("from .parts import Twice, Amplifier\n")
    (folder / "parts.py").write_text(
        "from pathsim.blocks import Amplifier\n"
        "class Twice(Amplifier):\n    def __init__(self, offset=0.0):\n"
        "        super().__init__(2.0)\n")
    monkeypatch.syspath_prepend(folder.parent)
    yield "my-toolbox"
    for name in ("my_toolbox", "my_toolbox.parts"):
        sys.modules.pop(name, None)


def test_a_toolbox_named_on_the_command_line_or_in_the_model(convert, toolbox):
    model = changed("graph", "nodes", 0, type="Twice", params={"offset": "1.0"})
    with pytest.raises(DiagramError, match="does not know the block 'Twice'"):
        convert(model)
    for code in (convert(model, [toolbox]), convert(model, ["anything:my_toolbox"]),
                 convert({**model, "requiredToolboxes": [requirement("my_toolbox")]})):
        assert "from my_toolbox import (\n    Twice\n)" in code
        assert "offset=1.0" in code


@pytest.mark.parametrize(("toolboxes", "message"), [
    (["not-there"], "'not-there' is not installed.*pip install not-there"),
    (["a b"], "PACKAGE or PACKAGE:IMPORT.PATH"), ([""], "PACKAGE"), (["x:1"], "PACKAGE"),
])
def test_toolboxes_that_are_none(convert, toolboxes, message):
    with pytest.raises(ParameterError, match=message):
        convert(MODEL, toolboxes)


BAD = {
    "empty": ("", "not a PathView model"),
    "no JSON": ("import this", "not a PathView model"),
    "binary": ("\x00\x01", "not a PathView model"),
    "list": ("[]", "no JSON object"),
    "other JSON": ('{"a": 1}', "it has no graph"),
    "block file": ('{"type": "block", "content": {}}', "a PathView block, not a model"),
    "version": ({**MODEL, "version": "2.0.0"}, "version '2.0.0'; this package reads 1.0.0"),
    "no version": ({k: v for k, v in MODEL.items() if k != "version"}, "version None"),
    "unknown block": (changed("graph", "nodes", 0, type="StepSorce"),
                      "block 'Step': PathView does not know.*did you mean 'StepSource'"),
    "unknown event": (changed("events", 0, type="pathsim.events.Schedul"),
                      "event 'tick': .*did you mean 'Schedule'"),
    "no such block": (changed("graph", connections=[wire("Step", "Nobody")]),
                      "connection 'Step-Nobody': no block 'Nobody'"),
    "no such input": (changed("graph", connections=[wire("Step", "Out", 0, 3)]),
                      "'Out' has no input 3"),
    "no such output": (changed("graph", connections=[wire("Step", "Out", -1)]),
                       "'Step' has no output -1"),
    "two wires": (changed("graph", connections=[wire("Step", "Out")] * 2), "another wire already"),
    "parameter": (changed("graph", "nodes", 0, params={"amplitude": "2 +"}),
                  "block 'Step': parameter 'amplitude' is not a Python expression: '2 \\+'"),
    "parameter in JSON": (changed("graph", "nodes", 0, params={"amplitude": "true false"}),
                          "not a Python expression"),
    "event parameter": (changed("events", 0, params={"func_act": "def f"}),
                        "event 'tick': parameter 'func_act'"),
    "setting": (changed("simulationSettings", dt="1 second"), "setting 'dt'"),
    "solver": (changed("simulationSettings", solver="RK5"), "unknown solver 'RK5'; did you mean"),
    "code": (changed("codeContext", code="x = ("), "the code is not a Python code"),
    "name": (changed("graph", "nodes", 0, name="Lambda"), "a name makes no Python: 'lambda = "),
    "damaged": (changed("graph", nodes=[{"type": "Scope"}]), "damaged: KeyError"),
    "embedded toolbox": ({**MODEL, "requiredToolboxes": [{"source": {"type": "inline"}}]},
                         "a toolbox that is not a package"),
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


@pytest.mark.parametrize("call", [
    lambda path: convert_model(path),
    lambda path: export_script(path.with_suffix(".py")),
    lambda path: view(path, browser=False),
    lambda path: view(port=0, browser=False),
])
def test_without_pathview_the_error_says_what_to_install(call, tmp_path, monkeypatch):
    (tmp_path / "model.pvm").write_text(json.dumps(MODEL))
    (tmp_path / "model.py").write_text("from pathsim import Simulation\nsim = Simulation()")
    monkeypatch.setitem(sys.modules, "pathview", None)
    with pytest.raises(MissingExtraError, match=r"pathsim-jsbsim-blocks\[pathview\]"):
        call(tmp_path / "model.pvm")
