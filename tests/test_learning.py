"""The commands that teach: the course copied to a folder, the manual pages of blocks."""

import contextlib
import errno
import inspect
import json
import os
import re
import sys
from pathlib import Path

import pytest
from how_many import first
from public_blocks import BLOCKS

import pathsim_jsbsim_blocks as package
from pathsim_jsbsim_blocks.cli import main

CHAPTERS = 13


def chapters(folder):
    return sorted(path.name for path in folder.glob("*.ipynb"))


def test_the_course_is_copied_with_its_figures(tmp_path, capsys):
    folder = tmp_path / "my course"
    assert main(["course", str(folder), "--no-open"]) == 0
    assert len(chapters(folder)) == CHAPTERS
    assert str(folder) in capsys.readouterr().out
    for name in chapters(folder):
        notebook = json.loads((folder / name).read_text(encoding="utf-8"))
        prose = "".join(
            "".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "markdown"
        )
        # what a link leads to is there; pages of the documentation are named instead
        for target in re.findall(r"\]\(([^)#]+)", prose):
            assert target.startswith("http") or (folder / target).is_file(), target


def test_a_chapter_of_the_users_stays_and_is_named(tmp_path, capsys):
    main(["course", str(tmp_path), "--no-open"])
    first, *_, last = chapters(tmp_path)
    figure = min((tmp_path / "figures").iterdir())
    for edited in (tmp_path / first, figure):
        edited.write_text("mine", encoding="utf-8")
    (tmp_path / last).unlink()
    capsys.readouterr()
    assert main(["course", str(tmp_path), "--no-open"]) == 0
    for edited in (tmp_path / first, figure):
        assert edited.read_text(encoding="utf-8") == "mine"
    assert (tmp_path / last).is_file()
    out = capsys.readouterr().out
    assert [name for name in chapters(tmp_path) if name in out] == [first]
    assert figure.name in out


def test_without_jupyterlab_the_extra_is_named_and_the_chapters_are_there(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setitem(sys.modules, "jupyterlab", None)
    assert main(["course", str(tmp_path / "course")]) == 1
    assert "pathsim-jsbsim-blocks[course]" in capsys.readouterr().err
    assert len(chapters(tmp_path / "course")) == CHAPTERS


@pytest.fixture
def lab(monkeypatch):
    """A JupyterLab that only takes down its arguments, and cannot start if told so."""

    class LabApp:
        started = []
        exit = None

        @classmethod
        def launch_instance(cls, arguments):
            cls.started.append(arguments)
            if cls.exit:
                raise SystemExit(cls.exit)

    for name, module in {"jupyterlab": object(), "jupyterlab.labapp": LabApp}.items():
        monkeypatch.setitem(sys.modules, name, module)
    LabApp.LabApp = LabApp
    return LabApp


def test_where_jupyter_does_not_start_no_open_is_named(tmp_path, lab, capsys):
    lab.exit = 1
    with pytest.raises(SystemExit):
        main(["course", str(tmp_path)])
    assert "pass --no-open, then run jupyter lab" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="without users by number")
@pytest.mark.parametrize("user", [0, 1000])
def test_jupyter_runs_as_root_too_and_says_so(user, tmp_path, lab, monkeypatch, capsys):
    monkeypatch.setattr(os, "geteuid", lambda: user)
    assert main(["course", str(tmp_path)]) == 0
    (arguments,) = lab.started
    assert arguments == [str(tmp_path / "00_inside_one_step.ipynb"), *["--allow-root"][user:]]
    assert ("--allow-root" in capsys.readouterr().err) == (user == 0)


def test_help_without_a_block_lists_them_all(capsys):
    assert main(["help"]) == 0
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == [*BLOCKS]


def test_the_command_alone_shows_what_it_can_do(capsys):
    assert main([]) == 0
    alone = capsys.readouterr().out
    with pytest.raises(SystemExit):
        main(["--help"])
    assert alone == capsys.readouterr().out
    assert "\n  course " in alone


@pytest.mark.parametrize(
    ("wrong", "right"), [("rnu", "run"), ("Trim", "trim"), ("property", "properties")]
)
def test_a_misspelt_command_is_answered_with_the_nearest(wrong, right, capsys):
    with pytest.raises(SystemExit) as ended:
        main([wrong])
    assert ended.value.code == 2
    assert f"did you mean {right!r}?" in capsys.readouterr().err


@pytest.mark.parametrize("words", [["--help"], ["list"], ["help"], *(["help", b] for b in BLOCKS)])
def test_a_terminal_shows_no_markup(words, capsys):
    with contextlib.suppress(SystemExit):
        main(words)
    page = capsys.readouterr().out
    assert page.count("\n") > 5
    assert re.findall(r"``|:\w+:`|.*math::.*", page) == []


def test_a_formula_is_shown_as_it_stands(capsys):
    main(["help", "AltitudeHold"])
    formula = inspect.getdoc(package.AltitudeHold).split("math::")[1].split("\n\n")[0]
    assert formula.strip("\n") in capsys.readouterr().out


@pytest.mark.parametrize("name", first(BLOCKS, 5))
def test_help_prints_parameters_ports_and_a_use(name, capsys):
    assert main(["help", name]) == 0
    page = capsys.readouterr().out
    block = BLOCKS[name]
    if len(inspect.signature(block).parameters):
        assert "\nParameters\n----" in page
    for port in [*(block.input_port_labels or ()), *(block.output_port_labels or ())]:
        assert re.search(rf"\b{port}\b", page)
    assert re.search(rf"\nIn a diagram\n-+\nblock = {name}\(", page)
    if block.input_port_labels or block.output_port_labels:
        assert page.count("\nConnection(") > 0
    assert f"\n{name}(" in page


def test_help_shows_what_most_users_need_first(capsys):
    main(["help", "Aircraft"])
    page = capsys.readouterr().out
    order = [page.index(f"\n{name} : ") for name in ("altitude", "speed", "T")]
    assert max(order) < page.index("\nOther Parameters\n") < page.index("\nsubsteps : ")


def test_help_knows_the_blocks_of_pathsim_and_error_classes(capsys):
    assert main(["help", "Integrator"]) == 0
    assert "initial_value" in capsys.readouterr().out
    assert main(["help", "BlocksError"]) == 0
    assert "Signature" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("wrong", "right"), [("PichHold", "PitchHold"), ("aircraft", "Aircraft"), ("deque", "Equal")]
)
def test_a_block_that_does_not_exist_is_refused_naming_the_nearest(wrong, right, capsys):
    assert main(["help", wrong]) == 1
    assert f"{right!r}" in capsys.readouterr().err


def test_a_full_disk_leaves_no_cut_notebook(tmp_path, monkeypatch, capsys):
    write = Path.write_bytes

    def full(path, content):
        write(path, content[: len(content) // 2])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr(Path, "write_bytes", full)
    assert main(["course", str(tmp_path), "--no-open"]) == 1
    assert "00_inside_one_step.ipynb': No space left on device" in capsys.readouterr().err
    assert [path for path in tmp_path.rglob("*") if path.is_file()] == []
    monkeypatch.undo()
    assert main(["course", str(tmp_path), "--no-open"]) == 0
    assert "kept" not in capsys.readouterr().out
