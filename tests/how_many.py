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


# diagrams with several aircraft or linear models, which take seconds to build
HEAVY = (
    "doublet_linear_nonlinear",
    "dutch_roll",
    "f16_autopilot",
    "fleet_pitch_hold",
    "gust_response",
    "microburst_approach",
    "stall_protection",
    "turbulence_rides",
)


def families_once(names):
    """Diagram names for an expensive test: none that is heavy, and of the check cases the first."""
    return [
        pytest.param(n, marks=pytest.mark.long)
        if n in HEAVY or (n.startswith("check_case_") and n != "check_case_01")
        else n
        for n in names
    ]


def bounded(usual, full):
    """The usual number, or the full one where ``PATHSIM_JSBSIM_LONG`` is ``full``."""
    return full if os.environ.get("PATHSIM_JSBSIM_LONG") == "full" else usual
