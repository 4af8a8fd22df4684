"""A kept result belongs to texts and values: what changes them is named, what does not resumes."""

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import jsbsim
import numpy as np
import pandas as pd
import pytest

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.studies import run_batch, trim_sweep
from pathsim_jsbsim_blocks.studies.kept import of_function

MODULE = """
import functools
import numpy as np
from own_helper import scaled
from own_package import inner

LIMIT = 3.0
TABLE = np.array([1.0, 2.0, 4.0])

@functools.lru_cache
def once(x):
    return 2.0 * x

each = np.vectorize(lambda x: x + 1.0)

def factory(factor):
    def build(x, bias=0.5):
        late = [t for t in TABLE if t > LIMIT]
        y = factor * once(x) + each(x) + scaled(x) + inner.K + bias
        return {"y": float(y), "late": late}
    return build

build = functools.partial(factory(2.0), bias=0.5)
"""


@pytest.fixture
def built(tmp_path, monkeypatch):
    """Run a batch of ``build`` from a fresh import of these texts; kept rows are resumed."""
    files = {
        "own_batch.py": MODULE,
        "own_helper.py": "def scaled(x):\n    return 3.0 * x\n",
        "own_package/__init__.py": "",
        "own_package/inner.py": "K = 1.0\n",
        "own_other.py": "# nothing imports it\n",
    }
    (tmp_path / "own_package").mkdir()
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def run(change=None, cases=(1.0,), **options):
        for name, text in files.items():
            if change and change[0] == name:
                assert text.count(change[1]) == 1
                text = text.replace(*change[1:])
            (tmp_path / name).write_text(text)
        for name in [name for name in sys.modules if name.startswith("own_")]:
            del sys.modules[name]
        importlib.invalidate_caches()
        module = importlib.import_module("own_batch")
        options = {"jobs": 1, "progress": False, "resume": tmp_path / "kept", **options}
        table = run_batch(options.pop("build", module.build), {"x": [*cases]}, **options)
        return table.y.tolist()

    yield run
    for name in [name for name in sys.modules if name.startswith("own_")]:
        del sys.modules[name]


@pytest.mark.parametrize(
    ("file", "before", "after", "named"),
    [
        ("own_batch.py", "return 2.0 * x", "return 2.5 * x", "text of own_batch.py"),
        ("own_batch.py", "lambda x: x + 1.0", "lambda x: x + 1.5", "text of own_batch.py"),
        ("own_batch.py", "LIMIT = 3.0", "LIMIT = 1.5", "text of own_batch.py, build: LIMIT \\("),
        ("own_batch.py", "2.0, 4.0", "2.0, 5.0", "text of own_batch.py, build: TABLE"),
        ("own_batch.py", "factory(2.0)", "factory(2.5)", "text of own_batch.py, build: factor \\("),
        (
            "own_batch.py",
            "(2.0), bias=0.5",
            "(2.0), bias=0.6",
            "text of own_batch.py, build: bias \\(",
        ),
        ("own_helper.py", "3.0", "4.0", "text of own_helper.py"),
        ("own_package/inner.py", "1.0", "2.0", "text of own_package/inner.py"),
    ],
)
def test_a_changed_text_is_named(built, file, before, after, named):
    kept = built()
    assert built() == kept
    with pytest.raises(ParameterError, match=rf"What differs: {named}"):
        built((file, before, after))
    assert built((file, before, after), resume=None) != kept or "TABLE" in named or "LIMIT" in named
    assert built() == kept
    # no text of the batch
    assert built(("own_other.py", "nothing", "nobody")) == kept


def test_values_that_come_with_a_function_are_compared(built, tmp_path):
    import functools

    def build(x, gain, bias=0.0):
        return {"y": gain["a"] * x + bias}

    def run(gain):
        given = functools.partial(build, gain=gain)
        return built(build=given, resume=tmp_path / "other")

    assert run({"a": 2.0, "b": np.arange(3)}) == [2.0]
    # an equal value, in another order
    assert run({"b": np.arange(3), "a": 2.0}) == [2.0]
    with pytest.raises(ParameterError, match=r"What differs: build: gain;"):
        run({"a": 3.0, "b": np.arange(3)})


def test_what_cannot_be_compared_is_refused_with_resume(built):
    built()
    module = sys.modules["own_batch"]
    module.LIMIT = (x for x in [3.0])
    with pytest.raises(ParameterError, match="build: LIMIT cannot be compared with resume"):
        of_function("build", module.build)
    names = {"__name__": "own_text"}
    exec("def build(x):\n    return {'y': x}", names)
    assert built(build=names["build"], resume=None) == [1.0]
    with pytest.raises(ParameterError, match="build has no text to compare"):
        built(build=names["build"])


SCRIPT = """
from pathsim import Simulation
from pathsim_jsbsim_blocks import Aircraft
DURATION = 0.1
plane = Aircraft("c172p", root={root!r}, speed=90.0)
sim = Simulation([plane], dt=0.1, log=False)
"""


@pytest.fixture
def own_root(tmp_path):
    """A JSBSim root with one model."""
    source, root = Path(jsbsim.get_default_root_dir()), tmp_path / "models"
    shutil.copytree(source / "aircraft" / "c172p", root / "aircraft" / "c172p")
    shutil.copytree(source / "engine", root / "engine")
    return root


def of_a_sweep(root, kept):
    return trim_sweep("c172p", {"speed": 90}, root=root, jobs=1, resume=kept, progress=False)


def of_a_script(root, kept):
    script = root.parent / "own.py"
    script.write_text(SCRIPT.format(root=str(root)))
    options = {"measure": lambda m: {"alpha": m.plane.trim.alpha}, "resume": kept}
    return run_batch(script, {"plane.speed": [90.0]}, jobs=1, progress=False, **options)


def of_a_function(root, kept):
    def build(speed):
        return {"alpha": Aircraft("c172p", root=root, speed=speed).trim.alpha}

    return run_batch(build, {"speed": [90.0]}, jobs=1, progress=False, resume=kept)


@pytest.mark.parametrize("study", [of_a_sweep, of_a_script, of_a_function])
def test_texts_of_a_users_own_models_are_compared(study, own_root, tmp_path):
    kept = tmp_path / "kept"
    table = study(own_root, kept)
    (own_root / "engine" / "notes.txt").write_text("no model")
    pd.testing.assert_frame_equal(study(own_root, kept), table)
    for name in ("aircraft/c172p/c172p.xml", "engine/eng_io320.xml"):
        file = own_root / name
        before = file.read_text()
        file.write_text(before + "<!-- edited -->")
        with pytest.raises(ParameterError, match=rf"What differs: text of {name};"):
            study(own_root, kept)
        file.write_text(before)
    pd.testing.assert_frame_equal(study(own_root, kept), table)


NOTEBOOK = """
import linecache, sys
from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.studies import run_batch
import numpy as np

def cell(number, text):
    # as IPython does
    name = f"/tmp/ipykernel_1/{number}.py"
    linecache.cache[name] = (len(text), None, text.splitlines(True), name)
    exec(compile(text, name, "exec"), globals())

def rows():
    try:
        table = run_batch(build, {"x": [1.0]}, jobs=1, progress=False, resume=sys.argv[1])
        return table.y.tolist()
    except ParameterError as error:
        return str(error).partition("What differs: ")[2].partition(";")[0]

cell(1, "LIMIT = np.array([3.0])\\ndef half(x):\\n    return x / 2\\neach = np.vectorize(half)\\n")
cell(2, "def build(x):\\n    return {'y': each(x).item() + LIMIT[0]}\\n")
print(rows())
cell(3, "LIMIT = np.array([3.0])\\ndef half(x):\\n    return x / 2\\neach = np.vectorize(half)\\n")
print(rows())
cell(4, "LIMIT[0] = 4.0")
print(rows())
cell(5, "LIMIT[0] = 3.0\\ndef half(x):\\n    return x / 4\\neach = np.vectorize(half)\\n")
print(rows())
"""


@pytest.mark.long
def test_in_a_notebook_the_source_of_the_functions_stands_for_the_file(tmp_path):
    def run():
        return subprocess.run(
            [sys.executable, "-c", NOTEBOOK, str(tmp_path / "kept")],
            env={**os.environ, "PYTHONHASHSEED": "random"},
            capture_output=True,
            text=True,
            check=True,
        ).stdout.splitlines()

    said = run()
    assert said == ["[3.5]", "[3.5]", "build: LIMIT", "text of build: each"]
    # the same in another process
    assert run() == said


def test_a_product_of_cases_is_told(capsys):
    def build(a, b=0.0, c=0.0):
        return {"y": a + b + c}

    def said(cases):
        run_batch(build, cases, jobs=1)
        return capsys.readouterr().err

    assert "run_batch build, 3 x 4 = 12 cases" in said({"a": [1, 2, 3], "b": range(4), "c": [1]})
    pairs = pd.DataFrame({"a": [1.0, 2.0], "b": [3.0, 4.0]})
    assert "run_batch build, 2 cases" in said(pairs.to_dict("records"))
