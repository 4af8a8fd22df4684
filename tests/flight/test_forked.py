"""What may end the process, or never end, is tried in a copy of it."""

import os
import signal
import sys

import pytest

from pathsim_jsbsim_blocks.flight.forked import Outcome, run_in_fork

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no fork")


def goes_on():
    while True:
        pass


def fails():
    raise OSError("not the process's end")


@pytest.mark.parametrize(
    ("action", "outcome"),
    [
        (lambda: None, Outcome.OK),
        (fails, Outcome.OK),
        (lambda: os.kill(os.getpid(), signal.SIGSEGV), Outcome.CRASH),
        (goes_on, Outcome.TIMEOUT),
    ],
)
def test_outcomes(action, outcome):
    assert run_in_fork(action, seconds=1) is outcome
