"""Every diagram of the catalogue: built on import, run as a script and by the command."""

import ast
import csv
import subprocess
import sys

import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.catalogue import (
    diagram_folder,
    diagram_names,
    find_diagram,
    load_diagram,
)
from pathsim_jsbsim_blocks.cli import main


@pytest.mark.parametrize("name", diagram_names())
def test_a_script_runs_from_any_directory_without_a_display(name, tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("MPLBACKEND", raising=False)
    done = subprocess.run([sys.executable, str(diagram_folder() / f"{name}.py")], cwd=tmp_path,
                          capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    # numbers that tell the user it worked, and a figure to look at
    assert any(c.isdigit() for c in done.stdout.split("figure saved")[0])
    assert (tmp_path / f"{name}.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", diagram_names())
def test_a_script_builds_its_diagram_on_import_and_does_not_run_it(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    module = load_diagram(name)
    assert module.sim.time == 0.0
    assert module.DURATION > 0
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", diagram_names())
def test_a_script_reads_like_a_diagram(name):
    tree = ast.parse((diagram_folder() / f"{name}.py").read_text())
    text = ast.get_docstring(tree)
    assert text.splitlines()[0].endswith(".")
    assert "Expected:" in text
    assert "Source:" in text
    outside = [n for n in tree.body if not isinstance(n, (ast.FunctionDef, ast.If))]
    loops = (ast.For, ast.While, ast.ListComp, ast.GeneratorExp, ast.DictComp, ast.IfExp)
    assert not [n for part in outside for n in ast.walk(part) if isinstance(n, loops)]


def test_list_shows_every_diagram_with_its_summary(capsys):
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == diagram_names()
    assert all(len(line.split()) > 3 for line in lines)


def test_run_saves_figure_and_signals(tmp_path, capsys):
    figure, signals = tmp_path / "a.png", tmp_path / "a.csv"
    assert main(["run", "hello_jsbsim", "--save", str(figure), "--csv", str(signals)]) == 0
    assert figure.read_bytes().startswith(b"\x89PNG")
    with signals.open() as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["time [s]", "altitude [ft]", "true airspeed [ft/s]", "pitch angle [deg]",
                       "roll angle [deg]", "heading [deg]"]
    assert len(rows) == 122
    assert float(rows[-1][1]) == pytest.approx(3000.0, abs=0.01)
    assert "62.157 %" in capsys.readouterr().out


def test_run_takes_the_path_of_a_script(tmp_path, capsys):
    script = tmp_path / "mine.py"
    script.write_text("print('flown')\n")
    assert main(["run", str(script)]) == 0
    assert capsys.readouterr().out == "flown\n"


@pytest.mark.parametrize(("arguments", "text"), [
    (["run", "elevator_doublett"], "did you mean 'elevator_doublet'"),
    (["run", "hello_jsbsim", "--save", "/no/such/folder/a.png"], "no directory"),
    (["trim", "c172"], "did you mean 'c172p'"),
    (["trim", "c172p", "--set", "fcs/flap"], "PROPERTY=VALUE"),
    (["trim", "c172p", "--set", "fcs/flap-cmd=1"], "did you mean 'fcs/flap-cmd-norm'"),
    (["trim", "737", "--speed", "100"], "alpha ran to the end"),
    (["properties", "c172p", "theta-dg"], "theta-deg"),
])
def test_mistakes_end_with_a_message_and_status_1(arguments, text, capsys):
    assert main(arguments) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert text in err
    assert err.startswith("pathsim-jsbsim: ")
    assert len(err.splitlines()) == 1


def test_trim_prints_the_published_state(capsys):
    assert main(["trim", "c172p", "--altitude", "3000", "--speed", "80", "--heading", "45"]) == 0
    out = capsys.readouterr().out
    assert "throttle           0.621568" in out
    assert "alpha              2.534215 deg" in out


def test_properties_shows_access_and_value(capsys):
    assert main(["properties", "c172p", "elevator-cmd"]) == 0
    assert capsys.readouterr().out.split() == ["fcs/elevator-cmd-norm", "rw", "0"]


def test_aircraft_lists_all_bundled_models(capsys):
    assert main(["aircraft"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 60
    assert any(line.startswith("737 ") and "2 engines" in line for line in lines)
    assert any(line.startswith("blank ") and "cannot load" in line for line in lines)


def test_find_diagram_names_the_nearest():
    with pytest.raises(ParameterError, match="van_der_pol"):
        find_diagram("vanderpol")
