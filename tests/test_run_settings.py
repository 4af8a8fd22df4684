"""``pathsim-jsbsim run`` with other values, another duration, and PathView's models."""

import io
import json
import re
import sys
from pathlib import Path

import pandas as pd
import pytest
from plain_jsbsim import trimmed

from pathsim_jsbsim_blocks._core import progress
from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.cli import editor, main

USERS = """
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source
from pathsim_jsbsim_blocks import fly
slope = 2.0
source = Source(lambda t: slope * t)
scope = Scope(labels=["x [-]"])
sim = Simulation([source, scope], [Connection(source, scope)], dt=0.5, log=False)
if __name__ == "__main__":
    {run}
"""


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.setenv("MPLBACKEND", "Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def test_a_diagram_is_flown_with_other_values(tmp_path, capsys):
    options = ["--set", "hold.theta_ref=4", "--set", "aircraft.speed=100", "--duration", "8"]
    files = ["--csv", "x.csv", "--save", "x.png", "--track", "x.kml"]
    assert main(["run", "pitch_hold", *options, *files]) == 0
    said = capsys.readouterr().out
    assert re.search(r"after 8 s, within 0.05 deg of 4 deg from [2-9]\.\d s on", said)
    flown = pd.read_csv("x.csv")
    assert flown["time [s]"].iloc[-1] == pytest.approx(8.0, abs=1e-9)
    assert flown["pitch angle [deg]"].iloc[-1] == pytest.approx(4.0, abs=0.05)
    # trimmed anew at the other speed
    fdm = trimmed("c172p", 5000.0, 100.0)
    assert flown["pitch angle [deg]"][0] == pytest.approx(fdm["attitude/theta-deg"], abs=1e-6)
    assert {p.name for p in tmp_path.iterdir()} >= {"x.csv", "x.png", "x.kml"}


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--set", "hold.theta_rf=5"], "no parameter 'theta_rf'; did you mean 'theta_ref'"),
        (["--set", "hold=5"], "'hold': it is of class PitchHold: set one of its parameters"),
        (["--set", "hold.theta_ref"], "--set needs NAME=VALUE, such as hold.theta_ref=5"),
        (["--set", "sim.dt=-0.01"], "dt must be greater than 0"),
        (["--duration", "nan"], "duration must be finite"),
        (["--csv", "a.csv", "--csv-rate", "0"], "csv-rate must be greater than 0"),
        (["--csv-rate", "10"], "--csv-rate requires --csv FILE"),
    ],
)
def test_a_setting_without_effect_ends_before_the_flight(options, said, capsys):
    assert main(["run", "pitch_hold", *options]) == 1
    captured = capsys.readouterr()
    assert said in captured.err
    assert captured.out == ""


def test_the_last_setting_of_a_name_counts(tmp_path, capsys):
    (tmp_path / "own.py").write_text("z = 3\nprint(z)\n")
    assert main(["run", "own.py", "--set", "z=9", "--set", "z=8"]) == 0
    assert capsys.readouterr().out == "8\n"


def test_a_study_has_a_command_of_its_own(capsys):
    assert main(["run", "aoa_vs_cas"]) == 1
    assert "aoa_vs_cas is a study: pathsim-jsbsim study aoa_vs_cas" in capsys.readouterr().err


@pytest.mark.long
def test_the_rate_of_a_csv_leaves_out_rows_and_changes_none():
    for name, options in (("all", []), ("ten", ["10"]), ("fifty", ["50"]), ("most", ["1000"])):
        rate = ["--csv-rate", *options] if options else []
        assert main(["run", "pitch_hold", "--duration", "3", "--csv", f"{name}.csv", *rate]) == 0
    header, *rows = Path("all.csv").read_text().splitlines()
    assert Path("most.csv").read_text().splitlines() == [header, *rows]
    # 120 steps a second
    assert Path("ten.csv").read_text().splitlines() == [header, *rows[::12]]
    fifty = Path("fifty.csv").read_text().splitlines()[1:]
    assert len(fifty) == 151
    assert set(fifty) < set(rows)


@pytest.mark.parametrize(
    ("script", "options", "status", "said"),
    [
        ("pass", [], 0, "the script calls neither sim.run nor fly: add sim.run(10) under"),
        (
            "print(slope)",
            ["--duration", "5"],
            1,
            "neither sim.run nor fly, so --duration has no effect",
        ),
        ("list(sim.run_streaming(1.0))", [], 0, ""),
        ("list(sim.run_streaming(1.0))", ["--duration", "5"], 1, "so --duration has no effect"),
        ("sim.run(1.0); sim.reset()", [], 0, ""),
    ],
)
def test_a_script_that_runs_nothing_is_told(script, options, status, said, tmp_path, capsys):
    (tmp_path / "own.py").write_text(USERS.format(run=script))
    assert main(["run", "own.py", *options]) == status
    errors = capsys.readouterr().err
    assert said in errors
    assert bool(errors) == bool(said)


# as in a model whose duration was changed in PathView: its code still has the constant
UNREAD = "DURATION = 9.0; sim.run(3.0)"


@pytest.mark.parametrize("run", ["sim.run(3.0)", "fly(sim, 3.0)", UNREAD])
def test_the_run_of_a_users_script_takes_the_duration(run, tmp_path):
    (tmp_path / "own.py").write_text(USERS.format(run=run))
    options = ["--set", "slope=4", "--csv", "x.csv"]
    assert main(["run", "own.py", "--duration", "5", *options]) == 0
    assert pd.read_csv("x.csv").iloc[-1].tolist() == [5.0, 20.0]
    assert main(["run", "own.py", *options]) == 0
    assert pd.read_csv("x.csv").iloc[-1].tolist() == [3.0, 12.0]


@pytest.mark.parametrize("run", ["sim.run(1); sim.run(2)", "fly(sim, 1); fly(sim, 2)"])
def test_which_of_two_runs_is_meant_is_not_clear(run, tmp_path, capsys):
    (tmp_path / "own.py").write_text(USERS.format(run=run))
    assert main(["run", "own.py", "--duration", "5"]) == 1
    assert (
        "runs more than once: it is not clear which run should last 5 s" in capsys.readouterr().err
    )
    assert main(["run", "own.py"]) == 0


def test_a_model_of_the_package_runs_as_its_script(tmp_path, capsys):
    model = str(find_diagram("pitch_hold").with_suffix(".pvm"))
    options = ["--set", "hold.theta_ref=2.5", "--duration", "2"]
    assert main(["run", model, *options, "--csv", "model.csv"]) == 0
    assert main(["run", "pitch_hold", *options, "--csv", "script.csv"]) == 0
    assert Path("model.csv").read_text() == Path("script.csv").read_text()
    assert sorted(p.name for p in tmp_path.glob("*.png")) == ["pitch_hold.png"]


@pytest.mark.long
def test_the_spectrum_of_a_model_is_saved_where_there_is_no_display(tmp_path, capsys):
    (tmp_path / "tone.py").write_text(
        "from pathsim import Connection, Simulation\nfrom pathsim.blocks import *\n"
        "tone = SinusoidalSource(frequency=1.0)\nspectrum = Spectrum(freq=[0.5, 1.0])\n"
        "sim = Simulation([tone, spectrum], [Connection(tone, spectrum)], dt=0.05, log=False)\n"
        "sim.run(1)\n"
    )
    assert main(["export", "tone.py"]) == 0
    assert main(["run", "tone.pvm"]) == 0
    assert [p.name for p in tmp_path.glob("*.png")] == ["tone_1.png"]
    assert "figure saved: tone_1.png" in capsys.readouterr().out


def test_a_model_from_outside_runs_after_a_yes_and_its_failure_shows_the_line(
    tmp_path, monkeypatch, capsys
):
    model = json.loads(find_diagram("damped_oscillator").with_suffix(".pvm").read_text())
    model["codeContext"]["code"] += "\nopen('executed', 'w').close(); sum('text')"
    Path("outside.pvm").write_text(json.dumps(model))
    monkeypatch.setattr(editor, "says_yes", lambda error: False)
    assert main(["run", "outside.pvm"]) == 2
    assert not Path("executed").exists()
    monkeypatch.setattr(editor, "says_yes", lambda error: True)
    assert main(["run", "outside.pvm"]) == 1
    assert Path("executed").exists()
    said = capsys.readouterr().err
    assert "sum('text')" in said
    assert said.endswith("outside.pvm failed\n")
    assert main(["run", "nonesuch.pvm"]) == 1
    assert "nonesuch.pvm: cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("run", "log", "terminal"),
    [
        ("sim.run(40.0)", "False", True),
        ("fly(sim, 40.0)", "False", True),
        ("sim.run(40.0)", "True", True),  # PathSim's own log shows how far it is
        ("sim.run(40.0)", "False", False),
    ],
)
def test_long_runs_show_a_bar_at_a_terminal_only(run, log, terminal, tmp_path, monkeypatch):
    monkeypatch.setattr(progress, "_SECONDS_BEFORE_BAR", 0.0)
    (tmp_path / "own.py").write_text(USERS.format(run=run).replace("log=False", f"log={log}"))
    shown = io.StringIO()
    shown.isatty = lambda: terminal
    monkeypatch.setattr(sys, "stderr", shown)
    assert main(["run", "own.py"]) == 0
    assert ("/40.0 s in" in shown.getvalue()) == (terminal and log == "False")


def test_engines_off_says_what_it_takes(capsys):
    with pytest.raises(SystemExit):
        main(["trim", "c172p", "--engines-off", "left"])
    assert "numbers of engines from 0, such as 0,2, or all, not 'left'" in capsys.readouterr().err
