"""Warnings reach the user of a diagram, in the way that the user has chosen."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from how_many import first

SCRIPT = Path(__file__).parent / "warned_script.py"
SAID = [
    "jumps over a sample instant",
    "DiscretePID measures 0 where no wire comes in: y",
    "a worker process died while these points were under way",
    "worker died at x=2",
    "the user's own",
]

BUILD = """
import logging, sys, warnings
from pathsim import Connection, Simulation
from pathsim.blocks import Constant
def simulate(**options):
    from pathsim_jsbsim_blocks import DiscretePID
    c, p = Constant(1.0), DiscretePID(Kp=0.5, T=0.01)
    Simulation([c, p], [Connection(c, p["r"])], dt=0.01, **{"log": False, **options}).run(0.05)
"""
WARNING = "measures 0 where no wire comes in"


def python(*arguments, code=1):
    """What a process of its own prints: stdout and stderr."""
    env = {k: v for k, v in os.environ.items() if k != "PYTHONWARNINGS"}
    ended = subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, env=env, timeout=120
    )
    assert ended.returncode == code, ended.stderr
    return ended.stdout, ended.stderr


def count(errors):
    return [errors.count(text) for text in SAID]


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
@pytest.mark.parametrize("start", first([[], ["-m", "pathsim_jsbsim_blocks.cli", "run"]]))
def test_each_warning_is_seen_once(start):
    _, errors = python(*start, str(SCRIPT), code=0)
    assert count(errors) == [1] * len(SAID)
    assert "RuntimeWarning" in errors


@pytest.mark.parametrize(
    "code",
    first(
        [
            # PathSim has redirected warnings before this package is there
            "Simulation([], [], log=False)\nsimulate()",
            # PathSim's own log level is unchanged
            "simulate(log=True)",
            "import pathsim_jsbsim_blocks\nimport importlib; importlib.reload(pathsim_jsbsim_blocks)\n"
            "simulate()",
        ],
    ),
)
def test_a_warning_goes_to_stderr_by_default(code):
    output, errors = python("-c", BUILD + code, code=0)
    assert errors.count(WARNING) == 1
    assert WARNING not in output
    assert ("FINISHED" in output) == ("log=True" in code)


@pytest.mark.parametrize(
    "code",
    first(
        [
            "logging.captureWarnings(True)\nlogging.basicConfig(stream=sys.stdout)\nsimulate()",
            "import pathsim_jsbsim_blocks\nlogging.captureWarnings(True)\n"
            "logging.basicConfig(stream=sys.stdout)\nsimulate()",
            # a redirection by PathSim that has a handler is left alone
            "Simulation([], [], log=False)\nlogging.basicConfig(stream=sys.stdout)\nsimulate()",
            "logging.captureWarnings(True)\n"
            "logging.getLogger('py.warnings').addHandler(logging.StreamHandler(sys.stdout))\nsimulate()",
            "warnings.showwarning = lambda message, *rest, **named: print(message)\nsimulate()",
            "with warnings.catch_warnings(record=True) as said:\n    simulate()\n"
            "print([str(w.message) for w in said])",
            "from pytest import warns\nwith warns(RuntimeWarning) as said: simulate()\n"
            "print(*[w.message for w in said])",
            "logging.config = __import__('logging.config').config\n"
            "import pathsim_jsbsim_blocks\nlogging.captureWarnings(True)\n"
            "logging.config.dictConfig({'version': 1, 'handlers': {'h': {'class': 'logging.StreamHandler',"
            " 'stream': 'ext://sys.stdout'}}, 'root': {'handlers': ['h']}})\nsimulate()",
        ],
    ),
)
def test_who_listens_elsewhere_still_does(code):
    output, errors = python("-c", BUILD + code, code=0)
    assert output.count(WARNING) == 1
    assert WARNING not in errors


def test_filters_still_count():
    assert WARNING not in "".join(python("-W", "ignore", "-c", BUILD + "simulate()", code=0))
    _, errors = python("-W", "error", "-c", BUILD + "simulate()")
    assert f"RuntimeWarning: DiscretePID {WARNING}" in errors
