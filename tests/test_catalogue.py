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


def test_every_figure_is_saved(tmp_path, capsys):
    assert main(["run", "van_der_pol", "--save", str(tmp_path / "a")]) == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.png", "a_2.png"]
    out = capsys.readouterr().out
    assert f"figure saved: {tmp_path / 'a.png'}" in out
    assert f"figure saved: {tmp_path / 'a_2.png'}" in out


SCRIPT = """
import sys
import helper
from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Scope
print(sys.argv, helper.TEXT)
outer, inner, port = Scope(labels=["outer"]), Scope(labels=["inner"]), Interface()
source = Constant(2.0)
part = Subsystem([port, inner], [Connection(port, inner)])
flight = Simulation([source, part, outer], [Connection(source, part, outer)], dt=0.5, log=False)
flight.run(1.0)
flight.plot()
"""


def test_run_is_what_python_does_and_saves_what_it_draws_and_records(tmp_path, capsys):
    script = tmp_path / "mine.py"
    script.write_text(SCRIPT)
    (tmp_path / "helper.py").write_text("TEXT = 'beside the script'\n")
    figure, signals = tmp_path / "a.svg", tmp_path / "a.csv"
    before = sys.argv[:], sys.path[:]
    assert main(["run", str(script), "--save", str(figure), "--csv", str(signals)]) == 0
    assert (sys.argv, sys.path) == before
    assert f"['{script}'] beside the script" in capsys.readouterr().out
    assert "<svg" in figure.read_text()
    header, *rows = csv.reader(signals.read_text().splitlines())
    assert sorted(header) == ["inner", "outer", "time [s]"]
    assert rows[-1] == ["1.0", "2.0", "2.0"]


def test_run_says_that_there_is_nothing_to_save(tmp_path, capsys):
    script = tmp_path / "mine.py"
    script.write_text("")
    assert main(["run", str(script), "--save", str(tmp_path / "a.png")]) == 1
    assert "no figure was shown" in capsys.readouterr().err
    assert main(["run", str(script), "--csv", str(tmp_path / "a.csv")]) == 1
    assert "no simulation" in capsys.readouterr().err


@pytest.mark.parametrize(("arguments", "text"), [
    (["run", "elevator_doublett"], "did you mean 'elevator_doublet'"),
    (["run", "hello_jsbsim", "--save", "/no/such/folder/a.png"], "no directory"),
    (["run", "hello_jsbsim", "--save", "a.foo"], "'png'"),
    (["run", "hello_jsbsim", "--save", "."], "is a directory"),
    (["run", "hello_jsbsim", "--csv", "."], "is a directory"),
    (["study", "climb_schedule", "--csv", "/no/such/folder/a.csv"], "no directory"),
    (["run", str(diagram_folder() / "pitch_hold.pvm")], "no Python script"),
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


def test_trim_creates_what_a_model_misses(capsys):
    assert main(["trim", "L17", "--speed", "105", "--gear", "0"]) == 1
    assert "create={'fcs/flaps-pos-deg': 0.0}" in capsys.readouterr().err
    assert main(["trim", "L17", "--speed", "105", "--gear", "0",
                 "--create", "fcs/flaps-pos-deg=0"]) == 0
    assert " norm" in capsys.readouterr().out


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
