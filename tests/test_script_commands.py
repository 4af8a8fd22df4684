"""The commands ``run`` and ``convert`` with a JSBSim script."""

import re

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pytest
from flown_scripts import ROOT
from plain_jsbsim import flown_script

from pathsim_jsbsim_blocks.cli import main


@pytest.fixture(autouse=True)
def _in_an_empty_directory(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    plt.switch_backend("agg")


def test_run_flies_a_script_and_prints_its_notices(tmp_path, capsys):
    assert main(["run", "scripts/x151.xml", "--csv", "x.csv", "--save", "x.png"]) == 0
    rows = flown_script("scripts/x151.xml", ["position/h-sl-ft", "fcs/aileron-cmd-norm"], 5.0)
    signals = pd.read_csv("x.csv", dtype=str)
    flown = signals[["altitude [ft]", "fcs/aileron-cmd-norm [norm]"]].astype(float)
    np.testing.assert_array_equal(flown, rows[:601])
    assert {p.name for p in tmp_path.iterdir()} == {"x.csv", "x.png"}
    assert "Test throttle, aileron (Event 0) executed at time: 0.508331" in capsys.readouterr().out


def test_options_of_run_act_on_a_script(capsys):
    script = ["run", "scripts/x151.xml", "--csv", "x.csv", "--save", "x.png"]
    assert main([*script, "--set", "fdm.substeps=2", "--duration", "1"]) == 0
    time = pd.read_csv("x.csv")["time [s]"]
    np.testing.assert_allclose(np.diff(time), 2 * 0.0083333)
    assert time.iloc[-1] == pytest.approx(1.0, abs=0.02)


def test_the_converted_script_flies_as_run_does(tmp_path, capsys):
    assert main(["run", "scripts/x151.xml", "--csv", "run.csv", "--save", "x.png"]) == 0
    assert main(["convert", "scripts/x151.xml"]) == 0
    assert main(["run", "x151.py", "--csv", "py.csv", "--save", "x.png"]) == 0
    assert (tmp_path / "run.csv").read_text() == (tmp_path / "py.csv").read_text()
    text = (tmp_path / "x151.py").read_text()
    assert 'script="scripts/x151.xml"' in text
    assert main(["convert", "scripts/x151.xml"]) != 0
    assert "x151.py exists" in capsys.readouterr().err
    assert main(["convert", "scripts/x151.xml", "-o", "x151.py"]) == 0


def test_the_converted_script_is_a_model_for_pathview(tmp_path, capsys):
    pytest.importorskip("pathview")
    assert main(["convert", "scripts/x151.xml"]) == 0
    assert main(["export", "x151.py"]) == 0
    assert "same for 600 steps" in capsys.readouterr().out


def test_a_script_of_another_root_is_found_with_root(tmp_path, capsys):
    own = tmp_path / "own"
    for file in ("aircraft/ball/ball.xml", "aircraft/ball/reset00.xml", "scripts/ball.xml"):
        (own / file).parent.mkdir(parents=True, exist_ok=True)
        (own / file).write_bytes((ROOT / file).read_bytes())
    (own / "aircraft" / "ball").rename(own / "aircraft" / "own_ball")
    (own / "aircraft/own_ball/ball.xml").rename(own / "aircraft/own_ball/own_ball.xml")
    script = own / "scripts" / "ball.xml"
    script.write_text(script.read_text().replace('aircraft="ball"', 'aircraft="own_ball"'))
    run = ["run", "own/scripts/ball.xml", "--duration", "1", "--save", "x.png"]
    assert main(run) != 0
    assert f"its JSBSim root is {str(own)!r}" in capsys.readouterr().err
    assert main([*run, "--root", "own"]) == 0
    assert main(["convert", "scripts/ball.xml", "--root", "own"]) == 0
    assert f'JSBSim_path="{own}"' in (tmp_path / "ball.py").read_text()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["run", str(ROOT / "aircraft/c172x/reset00.xml")], "is a reset file .*initialize=FILE"),
        (["convert", str(ROOT / "aircraft/c172x/c172x.xml")], "is an aircraft .*aircraft NAME"),
        (["run", "scripts/c1773.xml"], "no script 'scripts/c1773.xml'.*did you mean"),
        (["run", "elevator_doublet", "--root", "."], "--root is for JSBSim scripts"),
        (["convert", "scripts/x151.xml", "-o", "x.txt"], "output must end in .py"),
    ],
)
def test_what_is_no_script_is_refused(arguments, why, capsys):
    assert main(arguments) != 0
    assert re.search(why, capsys.readouterr().err)
