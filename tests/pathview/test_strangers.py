"""Scripts of strangers become models that fly as they do, or are refused; none is exported wrong.

The oracle knows nothing of the exporter: Python runs the script and the converted model. Compared
are what the scopes record, the plain values of all blocks, and what their functions return after
the run. What no export can know (docs/pathview.md) is not among them.
"""

import os
import signal
import subprocess
import sys
import time
import warnings
from concurrent.futures import ThreadPoolExecutor

import pytest
from how_many import first
from oracle import assert_equal, first_run
from scripts_of_tests import HEAD
from strangers import SCRIPTS, TAILS

from pathsim_jsbsim_blocks.errors import DiagramError
from pathsim_jsbsim_blocks.pathview import convert_model, export_script

ORDINARY = (
    "changed: global set by a function only",
    "changed: source function replaced",
    "random: Generator already drawn from, used late",
    "random: generator shared with a block",
    "world: loop of time steps",
)


@pytest.mark.parametrize(
    "case", first([*ORDINARY, *(n for n in SCRIPTS if n not in ORDINARY)], len(ORDINARY))
)
def test_the_model_flies_as_the_strangers_script_or_is_refused(case, tmp_path, monkeypatch):
    source, verdict = SCRIPTS[case]
    path = tmp_path / "script.py"
    path.write_text(HEAD + source, encoding="utf-8")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*the model is the diagram of the first run")
        try:
            model = export_script(path)
        except DiagramError:
            if verdict == "equal":
                raise
            return
    again = convert_model(model, tmp_path / "again.py")
    assert_equal(first_run(path, monkeypatch), first_run(again, monkeypatch))


SRC = TAILS["SRC"]
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
