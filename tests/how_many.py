"""Which cases belong to every run of the tests, and how many a long test has."""

import os

import pytest


def first(cases, count=1):
    """Parameters of an expensive test: the first few belong to every run, the rest to ``long``."""
    rows = [case if isinstance(case, tuple) else (case,) for case in cases]
    return [
        *(pytest.param(*row) for row in rows[:count]),
        *(pytest.param(*row, marks=pytest.mark.long) for row in rows[count:]),
    ]


# each with something of its own: an aircraft, a hold, events, turbulence, continuous states alone
EXPORTED = ("aileron_turn", "autopilot_mission", "elevator_doublet", "pitch_hold", "step_response")


def bounded(usual, full):
    """The usual number, or the full one where ``PATHSIM_JSBSIM_LONG`` is ``full``."""
    return full if os.environ.get("PATHSIM_JSBSIM_LONG") == "full" else usual
