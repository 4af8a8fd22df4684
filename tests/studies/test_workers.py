"""Workers: what a kill leaves, what a dying worker says, and the same work on a Dask cluster."""

import contextlib
import json
import os
import signal
import subprocess
import sys
import time
from functools import partial

import pandas as pd
import psutil
import pytest

from pathsim_jsbsim_blocks import ParameterError
from pathsim_jsbsim_blocks.studies import trim_sweep
from pathsim_jsbsim_blocks.studies.workers import run_parts

GRID = {"altitude": 15000, "speed": [160, 250, 350], "gamma": [-3, 0, 3]}

run = partial(
    run_parts,
    describe="point {}".format,
    title="numbers",
    job=lambda: {"study": "numbers"},
    jobs=2,
    resume=None,
    progress=False,
    death={"square": None},
)

PARTS = [[1, 2], [3, 4, 5], [6], [7, 8]]


def squaring(deadly=None):
    """Work that a worker does not survive at a deadly point."""

    # a function inside a function travels whole: workers need not import this module
    def work(part):
        if deadly in part:
            os.kill(os.getpid(), signal.SIGKILL)
        return [{"square": x * x} for x in part]

    return work


squares = squaring()
SQUARES = [{"square": x * x} for x in range(1, 9)]


@pytest.mark.parametrize("jobs", [0, -2, "all", 10**9, 1025, 10**400, None])
def test_a_bad_number_of_workers_is_refused(jobs):
    with pytest.raises(ParameterError) as error:
        run(squares, PARTS, jobs=jobs)
    assert error.value.parameter == "jobs"


@pytest.mark.long
def test_there_are_no_more_workers_than_parts():
    start = time.monotonic()
    run(squares, [[1], [2]], jobs=1024)
    assert time.monotonic() - start < 60


@pytest.mark.long
def test_workers_are_in_the_folder_of_their_study(tmp_path, monkeypatch):
    def place(part):
        return [{"folder": os.getcwd()} for _ in part]

    for name in ("first", "second"):
        (tmp_path / name).mkdir()
        monkeypatch.chdir(tmp_path / name)
        folders = {row["folder"] for row in run(place, [[1], [2], [3]])}
        assert folders == {str(tmp_path / name)}


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="a folder in use cannot be deleted")
@pytest.mark.parametrize("jobs", [1, 2])
def test_a_study_goes_on_in_a_folder_that_is_deleted(jobs, tmp_path, monkeypatch):
    folder = str(tmp_path / "gone")

    def work(part):
        with contextlib.suppress(FileNotFoundError):
            os.rmdir(folder)
        return squares(part)

    os.mkdir(folder)
    monkeypatch.chdir(folder)
    assert run(work, PARTS, jobs=jobs) == SQUARES


def test_without_workers_the_folder_of_the_process_is_left_alone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inner").mkdir()

    def work(part):
        folder = os.getcwd()
        os.chdir(tmp_path / "inner")
        return [{"folder": folder}]

    rows = run(work, [[1], [2]], jobs=1)
    assert [row["folder"] for row in rows] == [str(tmp_path), str(tmp_path / "inner")]


@pytest.mark.long
def test_a_point_that_kills_its_worker_is_named_and_the_others_are_computed(tmp_path):
    path = tmp_path / "squares.jsonl"
    with pytest.warns(RuntimeWarning) as said:
        rows = run(squaring(deadly=4), PARTS, resume=path)
    assert rows == [{"square": x * x if x != 4 else None} for x in range(1, 9)]
    assert [str(w.message) for w in said][-1] == "worker died at point 4"
    # it is not finished: a resumed study tries it again
    assert run(squares, PARTS, resume=path) == SQUARES


@pytest.mark.long
def test_a_worker_killed_from_outside_costs_nothing(tmp_path):
    marker = tmp_path / "killed"

    def work(part):
        if 4 in part and not marker.exists():
            marker.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return [{"square": y * y} for y in part]

    with pytest.warns(RuntimeWarning, match=r"computed these points: .*point 3 to point 5"):
        rows = run(work, PARTS)
    assert rows == SQUARES


def test_a_resumed_sweep_does_not_repeat_what_is_finished(tmp_path):
    path = tmp_path / "squares.jsonl"
    run(squares, PARTS, resume=path, jobs=1)
    lines = path.read_text().splitlines()
    assert [json.loads(line.partition(" ")[2])[0] for line in lines[1:]] == [0, 1, 2, 3]

    path.write_text("\n".join(lines[:3]) + "\n" + lines[3][:20])  # cut off in the fourth line
    computed = []
    rows = run(lambda part: computed.append(part) or squares(part), PARTS, resume=path, jobs=1)
    assert rows == SQUARES
    assert len(computed) == 2
    assert sorted(path.read_text().splitlines()) == sorted(lines)


def test_an_interrupted_sweep_keeps_what_is_finished(tmp_path):
    path = tmp_path / "squares.jsonl"

    def interrupted(part):
        if 6 in part:
            raise KeyboardInterrupt
        return squares(part)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        run(interrupted, PARTS, resume=path, jobs=1)
    assert len(path.read_text().splitlines()) == 3
    assert run(squares, PARTS, resume=path, jobs=1) == SQUARES
    with pytest.raises(KeyboardInterrupt, match=r"^5 of 8 points done, lost; .*--resume FILE"):
        run(interrupted, PARTS, jobs=1)
    assert signal.getsignal(signal.SIGINT) is before


def wait_for(reached):
    deadline = time.monotonic() + 60
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.01)


INTERRUPTED = """
import sys, time
from tqdm import tqdm
from pathsim_jsbsim_blocks.studies.workers import run_parts

def work(part):
    for _ in tqdm(part, disable=True):  # its lock is a semaphore
        time.sleep(0.2)
    return [{"square": x * x} for x in part]

run_parts(work, [[x, x + 1] for x in range(1, 101, 2)], death={}, describe=str, title="numbers",
          job=lambda: {}, jobs=2, resume=sys.argv[1], progress=False)
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
@pytest.mark.parametrize("times", [1, 2])
def test_ctrl_c_says_how_to_resume_and_leaves_nothing_behind(tmp_path, times):
    path = tmp_path / "squares.jsonl"
    with subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED, str(path)],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        wait_for(lambda: path.exists() and path.read_bytes().count(b"\n") >= 3)
        # as a terminal does, to all processes; impatient users do it twice
        for _ in range(times):
            os.killpg(process.pid, signal.SIGINT)
            time.sleep(0.05)
        said = process.communicate(timeout=60)[1]
    assert process.returncode == -signal.SIGINT
    parts = path.read_bytes().count(b"\n") - 1
    told = f"KeyboardInterrupt: {2 * parts} of 100 points done, resume with --resume {str(path)!r}"
    assert told in said.splitlines()
    assert said.count("Traceback") == 1
    # a second Ctrl-C may fall into the interpreter's end, where joblib's tracker warns
    if times == 1:
        assert said.splitlines()[-1] == told
        assert "joblib" not in said


SLOW_TO_IMPORT = """
import os, pathlib, time

if marker := os.environ.get("IMPORTING"):
    pathlib.Path(f"{marker}{os.getpid()}").touch()
    time.sleep(3)
"""


@pytest.mark.long
@pytest.mark.skipif(not hasattr(os, "killpg"), reason="needs process groups")
def test_ctrl_c_while_workers_import_leaves_the_message_alone(tmp_path):
    (tmp_path / "sitecustomize.py").write_text(SLOW_TO_IMPORT)
    begin = f"import os\nos.environ['IMPORTING'] = {str(tmp_path / 'importing')!r}\n"
    with subprocess.Popen(
        [sys.executable, "-c", begin + INTERRUPTED, str(tmp_path / "squares.jsonl")],
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
    ) as process:
        # joblib's tracker and both workers
        wait_for(lambda: len(list(tmp_path.glob("importing*"))) >= 3)
        os.killpg(process.pid, signal.SIGINT)
        said = process.communicate(timeout=60)[1]
    assert said.count("Traceback") == 1
    assert "0 of 100 points done, resume with --resume" in said.splitlines()[-1]


KILLED = """
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
        [sys.executable, "-c", KILLED, str(tmp_path), state], stdout=subprocess.PIPE
    ) as parent:
        if state == "idle":
            assert parent.stdout.readline() == b"done\n"
        wait_for(lambda: len(os.listdir(tmp_path)) >= (2 if state == "busy" else 1))
        children = psutil.Process(parent.pid).children(recursive=True)
        workers = {int(pid) for pid in os.listdir(tmp_path)}
        assert workers <= {child.pid for child in children}
        parent.kill()
    left = psutil.wait_procs(children, timeout=8)[1]
    for process in left:
        process.kill()
    assert left == []


@pytest.fixture(scope="module")
def dask_client():
    if not os.environ.get("CI"):
        pytest.importorskip("distributed", reason="Dask is not installed")
    import dask
    from distributed import Client, LocalCluster

    # one death is enough to give a task up (three are allowed by default)
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 0}),
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        yield client


@pytest.mark.long
def test_a_dask_cluster_gives_the_same_table(dask_client):
    import joblib

    local = trim_sweep("737", GRID, chunk=2, jobs=1, progress=False)
    with joblib.parallel_config("dask"):
        remote = trim_sweep("737", GRID, chunk=2, progress=False)
    pd.testing.assert_frame_equal(local, remote, check_exact=True)


@pytest.mark.long
def test_on_a_dask_cluster_a_point_that_kills_its_workers_is_named(dask_client):
    import joblib

    with joblib.parallel_config("dask"), pytest.warns(RuntimeWarning) as said:
        rows = run(squaring(deadly=4), PARTS)
    assert rows == [{"square": x * x if x != 4 else None} for x in range(1, 9)]
    assert "worker died at point 4" in [str(w.message) for w in said]
