"""How many cases the long tests have."""

import os


def cases(usual, full):
    """The usual number, or the full one where ``PATHSIM_JSBSIM_LONG`` is ``full``."""
    return full if os.environ.get("PATHSIM_JSBSIM_LONG") == "full" else usual
