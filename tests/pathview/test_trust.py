"""A model from outside runs after the user's word only, and the word is for its content."""

import contextlib
import copy
import io
import json
import os
import sys
from pathlib import Path

import pytest
from pathview_models import block, model

from pathsim_jsbsim_blocks import cli
from pathsim_jsbsim_blocks.catalogue import diagram_names, find_diagram
from pathsim_jsbsim_blocks.errors import DiagramError, UntrustedModelError
from pathsim_jsbsim_blocks.pathview import export_script, pvm, trusted_models, view
from pathsim_jsbsim_blocks.pathview.trusted_models import digest, remember

MODEL = model(block("one", "Constant", value="1.5"))
# with this port the server does not start: the model was trusted when that is the error
NO_PORT = 99_999


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    """The user's folder for what programs remember."""
    if sys.platform in ("win32", "darwin"):
        monkeypatch.setenv("LOCALAPPDATA", str(tmp_path / "state"))
        monkeypatch.setattr("pathlib.Path.home", lambda: tmp_path / "state")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr("pathsim_jsbsim_blocks.pathview.trusted_models._remembered", set())
    return tmp_path / "state"


@pytest.fixture
def path(tmp_path):
    owned = tmp_path / "owned"
    path = tmp_path / "model.pvm"
    code = f"import os; os.mkdir({str(owned)!r})"
    path.write_text(json.dumps({**MODEL, "codeContext": {"code": code}}))
    yield path
    assert not owned.exists()


def opens(*arguments):
    """The exit status of ``view`` for a model that is trusted is 1, for the port."""
    return cli.main(["view", *map(str, arguments), "--port", str(NO_PORT)])


def test_a_model_from_outside_is_refused_without_a_terminal(path, capsys):
    assert opens(path) == 2
    assert "pass --trust" in capsys.readouterr().err
    with pytest.raises(UntrustedModelError) as caught:
        view(path, port=NO_PORT)
    assert caught.value.path == str(path)
    assert caught.value.digest == digest(pvm.read(path))
    assert isinstance(caught.value, DiagramError)


def test_trust_is_remembered_for_the_content(path, tmp_path, state):
    assert opens(path, "--trust") == 1
    assert opens(path) == 1
    (file,) = [p for p in state.rglob("*") if p.is_file()]
    assert file.read_text() == digest(pvm.read(path)) + "\n"
    copied = tmp_path / "another name.pvm"
    copied.write_bytes(path.read_bytes())
    assert opens(copied) == 1
    path.write_text(path.read_text().replace("1.5", "2.5"))
    assert opens(path) == 2


def test_to_convert_runs_nothing_and_needs_no_trust(path):
    assert cli.main(["convert", str(path)]) == 0
    assert "os.mkdir" in path.with_suffix(".py").read_text(encoding="utf-8")
    assert opens(path) == 2


@pytest.mark.parametrize("name", [diagram_names()[0], diagram_names()[-1]])
def test_models_of_this_package_are_known_by_their_content(name, tmp_path):
    assert opens(name) == 1
    own = pvm.read(find_diagram(name).with_suffix(".pvm"))
    own["graph"]["nodes"][0]["position"] = {"x": 1234, "y": -5.5}
    own["metadata"].update(created="then", modified="today")
    path = tmp_path / "moved.pvm"
    path.write_text(json.dumps(own), encoding="utf-8")
    assert opens(path) == 1
    own["codeContext"]["code"] += "\nprint()"
    path.write_text(json.dumps(own), encoding="utf-8")
    assert opens(path) == 2
    path = tmp_path / f"{name}.pvm"
    path.write_text(json.dumps(own), encoding="utf-8")
    assert opens(path) == 2


def test_what_the_user_exports_is_his(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from pathsim import Simulation\nfrom pathsim.blocks import Constant\n"
        "one = Constant(1.0)\nsim = Simulation([one], log=False)\n"
    )
    assert cli.main(["export", str(script)]) == 0
    assert opens(script.with_suffix(".pvm")) == 1
    script.write_text(script.read_text().replace("1.0", "2.0"))
    export_script(script)  # from Python nothing is remembered
    assert opens(script.with_suffix(".pvm")) == 2


@pytest.mark.parametrize(
    ("place", "key", "value"),
    [
        (["codeContext"], "code", "x = 1"),
        (["graph", "nodes", 0], "type", "Scope"),
        (["graph", "nodes", 0, "params"], "value", "2.0"),
        (["graph", "nodes", 0, "params"], "position", "1"),
        (["metadata"], "name", "x"),
        (["graph", "nodes", 0, "params"], "position", {"x": 1, "y": 0}),
        (["graph", "nodes", 0], "position", {"x": "print()", "y": 0}),
        ([], "requiredToolboxes", []),
        ([], "events", [{}]),
        ([], "other", 1),
    ],
)
def test_every_change_but_of_place_and_time_is_another_digest(place, key, value):
    changed = copy.deepcopy(MODEL)
    at = changed
    for step in place:
        at = at[step]
    at[key] = value
    assert digest(changed) != digest(MODEL)


@pytest.mark.parametrize("lacking", ["folder", "home"])
def test_without_a_place_to_remember_it_is_opened_with_a_warning(lacking, path, state, monkeypatch):
    def homeless():
        raise RuntimeError("Could not determine home directory.")

    if lacking == "home":
        monkeypatch.delenv("XDG_STATE_HOME")
        monkeypatch.delenv("LOCALAPPDATA", raising=False)
        monkeypatch.setattr("pathlib.Path.home", homeless)
    else:
        state.write_text("no folder")
    with pytest.warns(UserWarning, match="cannot remember the model .*you will be asked again"):
        assert opens(path, "--trust") == 1
    assert opens(path) == 1  # for this process


def test_a_damaged_memory_trusts_nothing_more(path, state):
    remember("0" * 64)
    (file,) = [p for p in state.rglob("*") if p.is_file()]
    file.write_bytes(b"\xff\xfe\0garbage\n")
    assert opens(path) == 2
    assert opens(path, "--trust") == 1


def test_a_model_that_changes_after_the_yes_is_refused(path, monkeypatch):
    def yes(error):
        path.write_text(path.read_text().replace("1.5", "2.5"))
        return True

    monkeypatch.setattr(cli.editor, "says_yes", yes)
    assert opens(path) == 2


@pytest.mark.skipif(sys.platform == "win32", reason="no POSIX terminals")
def test_at_a_terminal_the_user_is_asked_once(path, monkeypatch):
    import pty

    def answered(text):
        master, slave = pty.openpty()
        os.write(master, text.encode())
        with open(slave, "r+b", buffering=0) as terminal, monkeypatch.context() as patched:
            patched.setattr(sys, "stdin", io.TextIOWrapper(io.BufferedReader(terminal)))
            patched.setattr(
                sys, "stderr", io.TextIOWrapper(io.FileIO(os.dup(slave), "w"), write_through=True)
            )
            status = opens(path)
            sys.stderr.close()
            sys.stdin.detach()
        shown = b""
        # all of it: with the other side closed the terminal ends
        with contextlib.suppress(OSError):
            while part := os.read(master, 10_000):
                shown += part
        os.close(master)
        return status, shown.decode()

    for no in ("\n", "yess\n", "\x04"):
        status, shown = answered(no)
        assert status == 2
        assert "from outside: its parameters and code are Python" in shown
        assert "read its code first" in shown
        assert "pathsim-jsbsim convert" in shown
    status, shown = answered("y\n")
    assert status == 1
    assert "[y/N]" in shown
    assert "port" in shown
    status, shown = answered("")
    assert status == 1
    assert "[y/N]" not in shown


@pytest.mark.parametrize(
    ("platform", "variable", "value", "folder"),
    [
        ("win32", "LOCALAPPDATA", "", "home/AppData/Local"),
        ("win32", "LOCALAPPDATA", "/local", "/local"),
        ("darwin", "XDG_STATE_HOME", "/state", "home/Library/Application Support"),
        ("linux", "XDG_STATE_HOME", "", "home/.local/state"),
        ("linux", "XDG_STATE_HOME", "relative", "home/.local/state"),
        ("linux", "XDG_STATE_HOME", "/state", "/state"),
    ],
)
def test_models_are_remembered_where_the_system_keeps_state(
    monkeypatch, platform, variable, value, folder
):
    monkeypatch.setattr(sys, "platform", platform)
    monkeypatch.setattr("pathlib.Path.home", lambda: Path("home"))
    monkeypatch.setenv(variable, value)
    assert trusted_models._file() == Path(folder) / "pathsim-jsbsim-blocks" / "trusted-models"
