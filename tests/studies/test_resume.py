"""Kept rows belong to arguments, versions and whole folders: what differs is named."""

import functools
import importlib
import subprocess
import sys
import zipfile
from pathlib import Path

import pandas as pd
import pytest
from models_from_outside import changed

from pathsim_jsbsim_blocks import Aircraft, ParameterError
from pathsim_jsbsim_blocks.errors import FileError
from pathsim_jsbsim_blocks.studies import run_batch, trim_sweep

PACKAGE = {
    "own_package/__init__.py": "",
    "own_package/alpha.py": "GAIN = 1.0\n",
    "own_package/inner/__init__.py": "",
    "own_package/inner/beta.py": "# nothing imports it\n",
    "own_package/inner/study.py": (
        "from .. import (\n    alpha,\n)\n"
        "def build(x, bias=0.0):\n    return {'y': alpha.GAIN * x + bias}\n"
        "def other(x):\n    return {'y': -x}\n"
    ),
    "own_package/.hidden/a.py": "",
    "own_package/env/pyvenv.cfg": "",
    "own_package/env/b.py": "",
    "own_package/notes.txt": "",
    "beside.py": "",
}


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Run a batch of a fresh import of the package; returns the column y."""
    for name, text in PACKAGE.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)

    def forget():
        for name in [name for name in sys.modules if name.startswith("own_package")]:
            del sys.modules[name]
        importlib.invalidate_caches()

    def run(function="build", cases=(1.0, 2.0), **arguments):
        forget()
        function = getattr(importlib.import_module("own_package.inner.study"), function)
        build = functools.partial(function, **arguments) if arguments else function
        kept = tmp_path / "kept.txt"
        return run_batch(build, {"x": [*cases]}, jobs=1, progress=False, resume=kept).y.tolist()

    yield run
    forget()


def differing(run, *args, **options):
    """What the refusal says of the difference."""
    with pytest.raises(ParameterError) as error:
        run(*args, **options)
    assert error.value.parameter == "resume"
    return str(error.value).partition("is of another study: ")[2].partition(";")[0]


@pytest.mark.parametrize(
    ("name", "text", "kind"),
    [
        ("own_package/alpha.py", "GAIN = 100.0\n", "changed"),
        ("own_package/inner/beta.py", "# nor this\n", "changed"),
        ("own_package/gamma.py", "", "new"),
        ("own_package/new/gamma.py", "", "new"),
        ("own_package/inner/beta.py", None, "missing"),
    ],
)
def test_every_file_of_the_top_package_is_compared(package, tmp_path, name, text, kind):
    assert package() == [1.0, 2.0]
    file = tmp_path / name
    if text is None:
        file.unlink()
    else:
        file.parent.mkdir(exist_ok=True)
        file.write_text(text)
    assert differing(package) == f"{name} is {kind}"
    if name in PACKAGE:
        file.write_text(PACKAGE[name])
        assert package() == [1.0, 2.0]


def test_arguments_functions_and_cases_are_compared(package):
    assert package(bias=1.0) == [2.0, 3.0]
    assert package(bias=1.0) == [2.0, 3.0]
    assert differing(package, bias=2.0) == "argument bias is changed"
    assert differing(package) == "argument bias is missing"
    assert "build is changed" in differing(package, "other")
    assert "cases is changed" in differing(package, cases=(1.0, 3.0), bias=1.0)


def test_versions_are_compared(package, monkeypatch):
    package()
    monkeypatch.setattr("pathsim_jsbsim_blocks.studies.journal.version", lambda name: "0.9")
    assert differing(package) == "version of jsbsim is changed, version of pathsim is changed"


SCRIPT = """
import functools, sys
from own_helper import half
from pathsim_jsbsim_blocks.errors import FileError
from pathsim_jsbsim_blocks.studies import run_batch

def build(x, names):
    return {"y": half(x) + len(names)}

# sets of texts have another order in each process
own = functools.partial(build, names={"a", "b", "c", "d"})
print(run_batch(own, {"x": [1.0, 2.0]}, jobs=2, progress=False, resume=sys.argv[1]).y.tolist())
"""


@pytest.mark.long
def test_a_script_is_compared_with_the_files_of_its_folder(tmp_path):
    (tmp_path / "own.py").write_text(SCRIPT)
    (tmp_path / "own_helper.py").write_text("def half(x):\n    return x / 2\n")

    def run():
        command = [sys.executable, "own.py", str(tmp_path / "kept.txt")]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
        return done.stdout.strip() or done.stderr.splitlines()[-1]

    assert [run(), run()] == 2 * ["[4.5, 5.0]"]
    (tmp_path / "own_helper.py").write_text("def half(x):\n    return x / 4\n")
    name = f"{tmp_path.name}/own_helper.py"
    assert f"is of another study: {name} is changed;" in run()


def build(x, extra=None):
    return {"y": x}


@pytest.mark.parametrize(
    "function",
    [lambda x: {"y": x}, functools.partial(build, extra=(x for x in [1.0]))],
)
def test_what_cannot_be_compared_is_refused(function, tmp_path):
    with pytest.raises(ParameterError) as error:
        run_batch(function, {"x": [1.0]}, jobs=1, progress=False, resume=tmp_path / "kept")
    assert error.value.parameter in ("build", "resume")
    assert not (tmp_path / "kept").exists()


def angle(speed, root):
    return {"alpha": Aircraft("c172p", root=root, speed=speed).trim.alpha}


def angle_of_script(diagram):
    return {"alpha": diagram.plane.trim.alpha}


DIAGRAM = """
from pathsim import Simulation
from pathsim_jsbsim_blocks import Aircraft
DURATION = 0.1
plane = Aircraft("c172p", root={root!r}, speed=90.0)
sim = Simulation([plane], dt=0.1, log=False)
"""


def of_a_sweep(root, options):
    return trim_sweep("c172p", {"speed": 90}, root=str(root), **options)


def of_a_script(root, options):
    script = root.parent / "own.py"
    script.write_text(DIAGRAM.format(root=str(root)))
    return run_batch(script, {"plane.speed": [90.0]}, measure=angle_of_script, **options)


def of_an_argument(root, options):
    return run_batch(functools.partial(angle, root=root), {"speed": [90.0]}, **options)


def of_a_case(root, options):
    return run_batch(angle, {"speed": [90.0], "root": [str(root)]}, **options)


@pytest.mark.parametrize("study", [of_a_sweep, of_a_script, of_an_argument, of_a_case])
def test_texts_of_a_users_own_models_are_compared(study, tmp_path):
    root = Path(changed(tmp_path / "models", "c172p"))
    options = {"jobs": 1, "progress": False, "resume": tmp_path / "kept"}
    table = study(root, options)
    (root / "engine" / "notes.txt").write_text("no model")
    pd.testing.assert_frame_equal(study(root, options), table)
    for name in ("aircraft/c172p/c172p.xml", "engine/eng_io320.xml"):
        before = (root / name).read_text()
        (root / name).write_text(before + "<!-- edited -->")
        assert differing(study, root, options) == f"models/{name} is changed"
        (root / name).write_text(before)
    pd.testing.assert_frame_equal(study(root, options), table)


def test_other_files_are_not_compared(package, tmp_path):
    assert package() == [1.0, 2.0]
    for name in [x for x in PACKAGE if "hidden" in x or "/env/" in x or "/" not in x]:
        (tmp_path / name).write_text("# another text\n")
    (tmp_path / "own_package" / "notes.txt").write_text("other notes")
    assert package() == [1.0, 2.0]


@pytest.mark.skipif(sys.platform == "win32", reason="links need a privilege")
def test_links_are_followed_once(package, tmp_path):
    linked = tmp_path / "elsewhere"
    linked.mkdir()
    (linked / "far.py").write_text("")
    (tmp_path / "own_package" / "link").symlink_to(linked)
    (linked / "back").symlink_to(tmp_path / "own_package")
    (linked / "gone.py").symlink_to(tmp_path / "nowhere.py")
    assert package() == package()
    (linked / "far.py").write_text("# edited")
    assert differing(package) == "own_package/link/far.py is changed"


def test_a_folder_with_thousands_of_files_is_refused(package, tmp_path):
    for i in range(2001 - 5):
        (tmp_path / "own_package" / f"{i}.py").touch()
    with pytest.raises(ParameterError) as error:
        package()
    assert error.value.parameter == "resume"
    assert error.value.value == str(tmp_path / "own_package")
    (tmp_path / "own_package" / "0.py").unlink()
    assert package() == [1.0, 2.0]


def test_code_that_cannot_be_read_is_named(tmp_path, monkeypatch):
    archive = tmp_path / "modules.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("zipped_study.py", "def build(x):\n    return {'y': x}\n")
    monkeypatch.syspath_prepend(archive)
    build = importlib.import_module("zipped_study").build
    with pytest.raises(FileError) as error:
        run_batch(build, {"x": [1.0]}, jobs=1, progress=False, resume=tmp_path / "kept.txt")
    assert error.value.path == str(archive)


def test_arguments_that_do_not_go_with_measure_are_refused(package):
    package()
    measure = functools.partial(importlib.import_module("own_package.inner.study").other, 1, 2)
    with pytest.raises(ParameterError) as error:
        run_batch("pitch_hold", {"DURATION": [1.0]}, measure=measure, progress=False, resume="kept")
    assert error.value.parameter == "resume"
