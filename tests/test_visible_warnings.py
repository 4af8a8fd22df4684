"""Warnings reach the user of a diagram, in the way that the user has chosen."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

BUILD = """
import logging, sys, warnings
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
def simulate(**options):
    from pathsim_jsbsim_blocks import DiscretePID
    c, p = Constant(1.0), DiscretePID(Kp=0.5, T=0.01)
    Simulation([c, p], [Connection(c, p["r"])], dt=0.01, **{"log": False, **options}).run(0.05)
"""
WARNING = "measures 0 at unconnected inputs"


def python(*arguments, code=1):
    """What a process of its own prints: stdout and stderr."""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONWARNINGS"}
    ended = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, env=env, timeout=120
    )
    assert ended.returncode == code, ended.stderr
    return ended.stdout, ended.stderr


MINE = """
from pathsim import Simulation
from pathsim_jsbsim_blocks import Aircraft, JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, linear_model, trim

fast = TrimCondition(altitude=10_000, speed=280)
plane = Aircraft("737", altitude=10_000, speed=280)  # gear
JSBSimFDM(aircraft_model="737", condition=fast)  # gear
state = trim(Airframe("737"), fast)  # gear
sim = Simulation([plane], dt=plane.T, log=False)
sim.reset()
plane.speed = 290  # gear, next
sim.reset()  # gear
linear_model("787-8", TrimCondition(altitude=10_000, speed=250, gear=1))  # response
slow = Aircraft("pa28", altitude=2000, speed=95)
slow.linear_model(inputs=["throttle"])  # response
"""


# in one process: core/test_wiring.py
@pytest.mark.long
@pytest.mark.parametrize("start", [[], ["-m", "pathsim_jsbsim_blocks.cli", "run"]])
def test_a_warning_shows_the_line_of_the_users_script(start, tmp_path):
    script = tmp_path / "mine.py"
    script.write_text(MINE)
    _, errors = python(*start, str(script), code=0)
    said = re.findall(
        rf"^{re.escape(str(script))}:(\d+): RuntimeWarning: .*(gear|response|next) ", errors, re.M
    )
    expected = [
        (number, what)
        for number, line in enumerate(MINE.splitlines(), 1)
        for what in re.findall("gear|response|next", line.partition("# ")[2])
    ]
    assert [(int(line), what) for line, what in said] == expected
    assert errors.count("RuntimeWarning") == len(expected)
    # the cause of a piston engine's is not known
    assert errors.count("throttle is not linear (a turbine's spools") == 1
    assert errors.count("throttle is not linear: ") == 1


def test_a_command_without_a_script_prints_a_warning_without_a_line(capsys):
    from pathsim_jsbsim_blocks.cli import main

    assert main(["modes", "787-8", "--altitude", "10000", "--speed", "250"]) == 0
    out, err = capsys.readouterr()
    assert err == ""
    gear, response = out.splitlines()[-2:]
    assert gear.startswith("  787-8 at 250 KCAS: the landing gear is down")
    assert response.startswith("  787-8: the response of vt to throttle is not linear (a turbine's")


RECIPE = (Path(__file__).parents[1] / "docs" / "messages.md").read_text("utf-8")
RECIPE = RECIPE.partition("## Warnings")[2].partition("```python")[2].partition("```")[0]


@pytest.mark.long
@pytest.mark.parametrize("first", ["", "simulate()\n"])
def test_an_application_that_captures_warnings_gets_all(first):
    """By the recipe of the page: the handler gets ours and others', and nothing undoes it."""
    mine = (
        "handler = logging.getLogger('py.warnings').handlers[-1]\nhandler.setStream(sys.stdout)\n"
    )
    after = "simulate()\nwarnings.warn('of others', stacklevel=1)\n"
    out, errors = python("-c", BUILD + first + RECIPE + mine + after, code=0)
    assert [out.count(text) for text in (WARNING, "of others")] == [1, 1]
    assert errors.count(WARNING) == bool(first)


@pytest.mark.long
def test_filters_still_count():
    assert WARNING not in "".join(python("-W", "ignore", "-c", BUILD + "simulate()", code=0))
    _, errors = python("-W", "error", "-c", BUILD + "simulate()")
    assert f"RuntimeWarning: DiscretePID {WARNING}" in errors
