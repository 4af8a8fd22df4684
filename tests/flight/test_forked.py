"""What may end the process, or never end, is tried in a copy of it."""

import os
import signal
import sys

import pytest

from pathsim_jsbsim_blocks import TrimCondition, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, trim
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


@pytest.mark.long
def test_a_search_without_end_is_given_up():
    # its turboprops do not settle up there: JSBSim's search takes 20 s
    with pytest.raises(TrimError, match=r"given up after 10 s of computing"):
        trim(Airframe("DHC6"), TrimCondition(altitude=32341, speed=158), hint=False)
