import os
import sys

# before NumPy comes: the matrices are small, and with threads BLAS spends more time on waiting for
# them than on the numbers, above all beside other workers. What the tests start inherits it
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# derandomized: a run finds what the run before it found
settings.register_profile("quick", max_examples=100, deadline=None, derandomize=True)
settings.register_profile("thorough", max_examples=500, deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))


def pytest_addoption(parser):
    parser.addoption(
        "--screenshots", metavar="FOLDER", help="take the pictures of docs/drawing.md there"
    )


@pytest.fixture(scope="session", autouse=True)
def _state_of_the_tests(tmp_path_factory):
    """``export`` remembers what it wrote: not in the folder of the user who runs the tests."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("XDG_STATE_HOME", str(tmp_path_factory.mktemp("state")))
        yield


@pytest.fixture(autouse=True)
def _figures_of_one_test():
    """No test sees the figures that another one left open."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")
