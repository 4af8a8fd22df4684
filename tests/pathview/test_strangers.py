"""Scripts of strangers become models that fly as they do, or are refused; none is exported wrong.

The oracle knows nothing of the exporter: Python runs the script and the converted model. Compared
are what the scopes record, the plain values of all blocks, and what their functions return long
after the run: a limit that the flight does not reach must not differ either.
"""

import inspect
import os
import random
import runpy
import signal
import subprocess
import sys
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from how_many import first
from pathsim import Simulation
from pathsim.blocks import Block
from strangers import HEAD, SCRIPTS, SRC

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script

pytest.importorskip("pathview")

LATE = (7.0, 60.0)  # s, after all runs


class Done(BaseException):
    pass


def said(function, t):
    """What a function of a block returns, or which error it raises."""
    try:
        parameters = inspect.signature(function).parameters.values()
        n = sum(p.kind is not p.KEYWORD_ONLY and p.default is p.empty for p in parameters)
        return np.array(function(*[t] * n), float).tolist()
    except Exception as error:
        return type(error).__name__


def facts(simulation):
    """What a simulation has recorded, its blocks' plain values, and what their functions say."""
    recorded, held = [], []
    for block in simulation.blocks:
        if type(block).__name__ == "Scope":
            recorded.append(block.read())
        for name, value in vars(block).items():
            if isinstance(value, (bool, int, float, np.ndarray)) and not name.startswith("_"):
                held.append((name, type(value).__name__, np.array(value).tolist()))
        function = getattr(block, "func", None)
        if inspect.isfunction(function) or inspect.ismethod(function):
            held.append([said(function, t) for t in LATE])
    return recorded, held


def first_run(path, monkeypatch):
    """`facts` at the end of a script's first run; without `run` at the end of the script."""
    found, built = [], []
    run, build, rng = Simulation.run, Simulation.__init__, np.random.default_rng

    def observed(simulation, *args, **kwargs):
        run(simulation, *args, **kwargs)
        found.append(facts(simulation))
        raise Done

    def noted(simulation, blocks=(), *args, **kwargs):
        for place, block in enumerate(blocks):
            block._place = place  # PathSim orders sources by their hash
        build(simulation, blocks, *args, **kwargs)
        built.append(simulation)

    with monkeypatch.context() as patched:
        patched.setattr(Simulation, "run", observed)
        patched.setattr(Simulation, "__init__", noted)
        patched.setattr(Block, "__hash__", lambda b: getattr(b, "_place", id(b)), raising=False)
        patched.setattr(sys, "argv", [str(path)])
        patched.setattr(time, "time", lambda: 1e9)
        patched.setattr(np.random, "default_rng", lambda seed=8: rng(seed))
        np.random.seed(8)  # noqa: NPY002
        random.seed(8)
        try:
            runpy.run_path(str(path), run_name="__main__")
            found.append(facts(built[0]))
        except Done:
            pass
    return found[0]


def assert_equal(script, model):
    (recorded, held), (recorded_there, held_there) = script, model
    assert repr(held) == repr(held_there)  # nan is equal to itself, 0.0 is not -0.0
    assert len(recorded) == len(recorded_there) > 0
    for (t, signals), (t_there, signals_there) in zip(recorded, recorded_there, strict=True):
        assert len(t) >= 5
        first = list(t_there).index(t[0])  # a loop of steps samples no t = 0, and has no end
        here = slice(first, first + len(t))
        np.testing.assert_array_equal(t_there[here], t)
        np.testing.assert_array_equal(np.array(signals_there)[:, here], signals)


ORDINARY = (
    "shared: list within a factory",
    "shared: view within a factory",
    "changed: slots changed by an assigned call",
    "changed: global set by a function only",
    "changed: function chosen by a block",
    "changed: source function replaced",
    "random: Generator already drawn from, used late",
    "random: generator shared with a block",
    "numpy: float32 in a loop",
    "pathsim: stop replaced on the simulation",
    "pathsim: scipy patched",
    "world: loop of time steps",
    "numpy: float subclass counts",
    "random: seed alias late",
    "pathsim: operator of a block replaced, late",
    "world: csv reader read",
)


@pytest.mark.parametrize(
    "case", first([*ORDINARY, *(n for n in SCRIPTS if n not in ORDINARY)], len(ORDINARY))
)
def test_the_model_flies_as_the_strangers_script_or_is_refused(case, tmp_path, monkeypatch):
    source, verdict = SCRIPTS[case]
    path = tmp_path / "script.py"
    path.write_text(HEAD + source, encoding="utf-8")
    monkeypatch.setenv("GAIN", "1")  # a script changes it
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*the model is the diagram of the first run")
        try:
            model = export_script(path)
        except DiagramError:
            if verdict == "equal":
                raise
            return
    monkeypatch.setenv("GAIN", "1")
    again = convert_model(model, tmp_path / "again.py")
    assert_equal(first_run(path, monkeypatch), first_run(again, monkeypatch))


def test_there_are_ninety_of_which_most_are_to_become_models():
    assert len(SCRIPTS) >= 90
    assert sum(verdict == "equal" for _, verdict in SCRIPTS.values()) >= 36


STEPS = HEAD + SCRIPTS["world: try and finally"][0]


@pytest.mark.filterwarnings("ignore:the model is the diagram of the first run")
def test_two_exports_at_once_and_a_script_that_leaves_its_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        (tmp_path / f"{name}.py").write_text(
            f"import os\nos.chdir('/')\nos.environ['STRANGE'] = '1'\n{STEPS}", encoding="utf-8"
        )
    with ThreadPoolExecutor() as threads:
        models = list(threads.map(export_script, ("one.py", "two.py")))
    assert [m.read_text() for m in models]  # beside their scripts
    assert os.getcwd() == str(tmp_path)
    assert "STRANGE" not in os.environ


@pytest.mark.parametrize(
    ("end", "said"),
    [("os._exit(7)", "ends the process"), ("raise KeyboardInterrupt", "fails: Key")],
)
def test_a_model_that_ends_its_process_is_refused(end, said, tmp_path):
    (tmp_path / "a.py").write_text(
        f"{HEAD}import os, sys\ndef f(t):\n    if sys.argv[0] == 'pathview':\n        {end}\n"
        f"    return t\nsrc = Source(f)\n{SRC}",
        encoding="utf-8",
    )
    with pytest.raises(DiagramError, match=said):
        export_script(tmp_path / "a.py")


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "fork"), reason="the model flies in a copy of a process")
def test_an_interrupted_export_leaves_no_process(tmp_path):
    (tmp_path / "a.py").write_text(
        f"{HEAD}import os, sys, time\ndef f(t):\n    if sys.argv[0] == 'pathview':\n"
        f"        open({str(tmp_path / 'pid')!r}, 'w').write(f'{{os.getpid()}}\\n')\n"
        f"        time.sleep(60)\n    return t\nsrc = Source(f)\n{SRC}",
        encoding="utf-8",
    )
    export = subprocess.Popen(
        [sys.executable, "-m", "pathsim_jsbsim_blocks.cli", "export", str(tmp_path / "a.py")],
        stderr=subprocess.DEVNULL,
        # it is ignored in what a shell starts in the background
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.default_int_handler),
    )
    pid = tmp_path / "pid"
    end = time.monotonic() + 60
    while not (pid.exists() and pid.read_text().endswith("\n")) and time.monotonic() < end:
        time.sleep(0.05)
    export.send_signal(signal.SIGINT)
    assert export.wait(30) == 130
    end = time.monotonic() + 10
    while time.monotonic() < end:
        try:
            os.kill(int(pid.read_text()), 0)
        except ProcessLookupError:
            return
        time.sleep(0.05)
    pytest.fail("the model goes on flying")
