"""What this package relies on beyond its libraries' documentation, each with the file that does.

PathSim's private names have tests of their own (``core/test_pathsim_seam.py``), JSBSim's traps
those of loading (``flight/test_sealed.py``) and of properties (``test_bad_input.py``).
"""

import importlib
import os
import signal
import sys
import tracemalloc

import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Constant, Scope

# module, name, file that uses it: each is looked for in its library and in our source
USED = [
    ("joblib.externals.loky.process_executor", "TerminatedWorkerError", "studies/workers.py"),
    ("joblib.parallel", "get_active_backend", "studies/workers.py"),
    ("pathview.app", "_sessions", "pathview/server.py"),
    ("pathview.app", "remove_session", "pathview/server.py"),
    ("pathview.app", "create_app", "pathview/server.py"),
    ("pathview.converter", "generate_python", "pathview/generate.py"),
    ("pathview.converter", "load_registry", "pathview/toolboxes.py"),
    ("waitress.channel", "HTTPChannel", "pathview/server.py"),
    ("waitress.parser", "HTTPRequestParser", "pathview/server.py"),
    ("waitress.task", "WSGITask", "pathview/server.py"),
    ("waitress.utilities", "Error", "pathview/server.py"),
]


@pytest.mark.parametrize(("module", "name", "file"), USED)
def test_a_name_beyond_the_documentation_is_there(module, name, file):
    pytest.importorskip(module.partition(".")[0])
    assert hasattr(importlib.import_module(module), name), f"{file} needs {module}.{name}"


def _ended(_):
    os.kill(os.getpid(), signal.SIGKILL)


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_joblib_raises_where_a_worker_is_killed():
    joblib = pytest.importorskip("joblib")
    from joblib.externals.loky.process_executor import TerminatedWorkerError

    parallel = joblib.Parallel(n_jobs=2, batch_size=1, return_as="generator_unordered")
    with pytest.raises(TerminatedWorkerError):
        list(parallel(joblib.delayed(_ended)(i) for i in range(2)))
    # and the next call has new workers
    assert joblib.Parallel(n_jobs=2)(joblib.delayed(abs)(-i) for i in range(3)) == [0, 1, 2]


def test_joblib_gives_equal_values_equal_sums():
    # of arguments of a resumed study
    joblib = pytest.importorskip("joblib")
    one, other = {"a": [1.0, "x"], "b": None}, {"b": None, "a": [1.0, "x"]}
    assert joblib.hash(one) == joblib.hash(other)
    assert joblib.hash(one) != joblib.hash({**one, "b": 0})


def test_a_scope_keeps_160_bytes_a_step_and_8_more_a_port():
    # `docs/conventions.md`: a list of arrays, whose heads weigh more than their numbers
    bytes_per_step = {}
    for ports in (1, 5):
        sources, scope = [Constant(float(i)) for i in range(ports)], Scope()
        wires = [Connection(source, scope[i]) for i, source in enumerate(sources)]
        sim = Simulation([*sources, scope], wires, dt=0.01, log=False)
        sim.run(1.0)
        tracemalloc.start()
        sim.run(20.0)
        bytes_per_step[ports] = tracemalloc.get_traced_memory()[0] / 2000
        tracemalloc.stop()
    assert bytes_per_step[1] == pytest.approx(160, abs=15)
    assert bytes_per_step[5] - bytes_per_step[1] == pytest.approx(4 * 8, abs=6)
