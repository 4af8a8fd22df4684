import os
import signal
import sys
import time
from pathlib import Path

# before NumPy comes: the matrices are small, and with threads BLAS spends more time on waiting for
# them than on the numbers, above all beside other workers. What the tests start inherits it
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# a shell that starts the tests in the background has them ignore Ctrl-C, and with them the programs
# that they start and interrupt
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# derandomized: a run finds what the run before it found
settings.register_profile("quick", max_examples=100, deadline=None, derandomize=True)
settings.register_profile("thorough", max_examples=500, deadline=None, derandomize=True)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "quick"))


TESTS = Path(__file__).parent
# what needs no flight of more than seconds: folders and files of `pytest -m fast`, which reads no others
FAST = (
    *(f"{name}/" for name in ("air", "axes", "core", "scripts", "wind")),
    *(
        f"control/test_{name}.py"
        for name in ("gains", "laws", "pid", "response", "sensor_actuator")
    ),
    "guidance/test_laws_of_approaches.py",
    "design/test_plant.py",
    "linear/test_plots_of_models.py",
    *(f"flight/test_{name}.py" for name in ("aircraft", "contact", "fields", "limits", "points")),
    *(f"pathview/test_{name}.py" for name in ("convert", "layout", "unreadable")),
    *(f"test_{name}.py" for name in ("budgets", "conventions", "promises", "sources", "units")),
)
# rooms in depth: all tests of these files are `deep`, beyond the selection of the README's command,
# which does not read them
DEEP = (
    "check_cases/test_f16.py",
    *(f"control/test_{name}.py" for name in ("disturbances", "holds", "schedules")),
    *(f"core/test_{name}.py" for name in ("attributes", "copies", "ends_of_steps", "running")),
    "design/",
    "diagrams/test_result_lines.py",
    *(
        f"flight/test_{name}.py"
        for name in (
            "checkpoint",
            "engines",
            "fleet",
            "flightgear",
            "from_outside",
            "integrators_and_planet",
            "life",
            "newton",
            "property_ports",
            "recording",
            "reset",
            "scripts",
            "sealed",
            "setup_acts",
        )
    ),
    *(f"guidance/test_{name}.py" for name in ("climbs", "landing", "navigation", "protection")),
    *(
        f"linear/test_{name}.py"
        for name in (
            "diagrams",
            "governed_propellers",
            "laws_at_limits",
            "margins",
            "model",
            "servos",
        )
    ),
    *(
        f"pathview/test_{name}.py"
        for name in (
            "access",
            "export",
            "hosted_editor",
            "needless_refusals",
            "roundtrip",
            "strangers",
            "trust",
            "whole_scripts",
        )
    ),
    *(
        f"studies/test_{name}.py"
        for name in ("aircraft_report", "batch", "branch", "performance", "resume")
    ),
    *(
        f"test_{name}.py"
        for name in (
            "bad_input",
            "gym",
            "host",
            "import",
            "plots",
            "script_commands",
            "shared_options",
            "without_jsbsim",
        )
    ),
    "wind/test_turbulence.py",
)
FAST_SECONDS = 2.0  # of processor time; the first test of a module may import it


def is_fast(path):
    return path.relative_to(TESTS).as_posix().startswith(FAST)


def is_deep(path):
    return path.relative_to(TESTS).as_posix().startswith(DEEP)


def pytest_ignore_collect(collection_path, config):
    """Files without a test of these marks are not even read: that takes longer than the tests."""
    if collection_path.name.startswith("test_"):
        wanted = config.option.markexpr
        if wanted == "fast" and not is_fast(collection_path):
            return True
        if wanted == "not long and not deep" and is_deep(collection_path):
            return True
        if wanted.startswith("matrix") and "mark.matrix" not in collection_path.read_text("utf-8"):
            return True
    return None


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    for item in items:
        if is_fast(item.path) and not item.get_closest_marker("long"):
            item.add_marker("fast")
        if is_deep(item.path):
            item.add_marker("deep")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item):
    start = time.process_time()
    result = yield
    if item.config.option.markexpr == "fast" and time.process_time() - start > FAST_SECONDS:
        pytest.fail(
            f"takes more than {FAST_SECONDS:g} s: mark it long, or move it to a file beside"
        )
    return result


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


@pytest.fixture(scope="session", autouse=True)
def _first_simulation():
    """PathSim's first simulation in a process logs warnings from then on: no ``pytest.warns`` that
    contains it would see one.
    """
    from pathsim import Simulation

    Simulation(log=False)


@pytest.fixture(autouse=True)
def _figures_of_one_test():
    """No test sees the figures that another one left open."""
    yield
    if pyplot := sys.modules.get("matplotlib.pyplot"):
        pyplot.close("all")
