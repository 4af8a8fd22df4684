"""What may end the process, or never end, is tried in a copy of it."""

import os
import signal
import sys

import pytest

from pathsim_jsbsim_blocks.flight.forked import Outcome, rehearse

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no fork")


def goes_on():
    while True:
        pass


def fails():
    raise OSError("not the process's end")


@pytest.mark.parametrize(
    ("action", "outcome"),
    [
        (lambda: None, Outcome.ENDS),
        (fails, Outcome.ENDS),
        (lambda: os.kill(os.getpid(), signal.SIGSEGV), Outcome.KILLS),
        (goes_on, Outcome.GOES_ON),
    ],
)
def test_outcomes(action, outcome):
    assert rehearse(action, seconds=1) is outcome
