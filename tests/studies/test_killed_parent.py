"""Workers end with the process that started them, also when that is killed."""

import os
import signal
import subprocess
import sys
import time

import psutil
import pytest

STUDY = """
import sys, time
from pathsim_jsbsim_blocks.studies.workers import run_parts

def work(part):
    import os, pathlib, time
    (pathlib.Path(sys.argv[1]) / str(os.getpid())).touch()
    while BUSY:
        time.sleep(0.05)
    return [{}]

BUSY = sys.argv[2] == "busy"
run_parts(work, [[i] for i in range(4)], death={}, describe=str, title="", job=dict, jobs=2,
          resume=None, progress=False)
print("done", flush=True)
time.sleep(600)
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL")
@pytest.mark.parametrize("state", ["busy", "idle"])
def test_no_worker_outlives_a_killed_parent(state, tmp_path):
    with subprocess.Popen(
        [sys.executable, "-c", STUDY, str(tmp_path), state], stdout=subprocess.PIPE
    ) as parent:
        if state == "idle":
            assert parent.stdout.readline() == b"done\n"
        deadline = time.monotonic() + 60
        while len(os.listdir(tmp_path)) < (2 if state == "busy" else 1):
            assert time.monotonic() < deadline
            time.sleep(0.05)
        children = psutil.Process(parent.pid).children(recursive=True)
        workers = {int(pid) for pid in os.listdir(tmp_path)}
        assert workers <= {child.pid for child in children}
        parent.kill()
    left = psutil.wait_procs(children, timeout=8)[1]
    for process in left:
        process.kill()
    assert left == []
