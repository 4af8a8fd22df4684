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


def files(folders, **names):
    """Folders of the tests, and files by folder ("_" is this one)."""
    rows = {"" if folder == "_" else f"{folder}/": row.split() for folder, row in names.items()}
    return (
        *(f"{folder}/" for folder in folders.split()),
        *(f"{folder}test_{name}.py" for folder, row in rows.items() for name in row),
    )


# what needs no flight of more than seconds: folders and files of `pytest -m fast`, which reads no others
FAST = files(
    "air axes core scripts wind",
    control="gains laws pid sensor_actuator",
    guidance="laws_of_approaches",
    design="plant",
    linear="plots_of_models",
    flight="aircraft contact fields limits",
    pathview="convert layout",
    _="budgets conventions promises sources units",
)
# rooms in depth: all tests of these files are `deep`, beyond the selection of the README's command,
# which does not read them
DEEP = files(
    "design",
    check_cases="check_cases f16",
    control="disturbances holds schedules sensor_actuator",
    core="attributes copies ends_of_steps random_diagrams running sampling wiring",
    daveml="daveml",
    diagrams="diagrams_air_data diagrams_axes diagrams_control diagrams_studies diagrams_wind "
    "result_lines",
    flight="checkpoint engines fleet flightgear forked from_outside integrators_and_planet life "
    "newton property_ports recording reset scripts sealed setup_acts",
    guidance="climbs gains_of_autopilots landing navigation protection",
    linear="diagrams every_block governed_propellers laws_at_limits margins model modes plots_of_models servos",
    pathview="access committed convert export first_run hosted_editor layout needless_refusals "
    "positions roundtrip strangers trust whole_scripts",
    studies="aircraft_report batch batch_seeds branch performance published resume sweep",
    tracks="odd_inputs",
    wind="turbulence",
    _="bad_input claims conventions extreme_numbers gym host import physical_bounds plots "
    "script_commands shared_options visible_warnings without_jsbsim",
)
assert [name for name in (*FAST, *DEEP) if not (TESTS / name).exists()] == []
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
