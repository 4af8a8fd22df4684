"""Futures of a flight equal flights that were flown without a branch."""

import gc
import os
import random
import signal
import subprocess
import sys
import threading
import time

import jsbsim
import numpy as np
import psutil
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import (
    Aircraft,
    DrydenTurbulence,
    FlightError,
    ParameterError,
    PitchHold,
    fly,
)
from pathsim_jsbsim_blocks.errors import BranchError
from pathsim_jsbsim_blocks.pathview.server import Server
from pathsim_jsbsim_blocks.studies import branch

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork")


@pytest.fixture(autouse=True)
def nothing_stays_behind():
    gc.collect()  # files of earlier tests
    process = psutil.Process()
    children, files = process.children(), process.num_fds()
    yield
    assert process.children() == children
    assert process.num_fds() == files


def in_turbulence():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    hold, air = PitchHold("c172p", theta_ref=3.0), DrydenTurbulence(seed=4)
    scope = Scope(labels=["theta"])
    wires = [
        Connection(plane["theta"], hold["theta"], scope[0]),
        Connection(plane["q"], hold["q"]),
        Connection(hold["elevator"], plane["elevator"]),
        *(Connection(plane[port], air[port]) for port in ("h", "vt", "psi")),
        Connection(air["down"], plane["wind_down"]),
    ]
    sim = Simulation([plane, hold, air, scope], wires, dt=1 / 120, log=False)
    return sim, hold, scope


def test_each_future_is_the_flight_that_goes_on_and_a_fresh_one():
    def flown(sim, hold, scope, theta):
        hold.theta_ref = theta
        fly(sim, 4)
        return scope.read()[1][0]

    sim, hold, scope = in_turbulence()
    fly(sim, 6)
    start = scope.read()[1][0]
    pitches = [3.0, 3.0, 5.0, 0.0]
    ends = branch([lambda theta=theta: flown(sim, hold, scope, theta) for theta in pitches])
    assert np.array_equal(scope.read()[1][0], start)
    assert np.array_equal(flown(sim, hold, scope, 3.0), ends[0])
    for theta, end in zip(pitches, ends, strict=True):
        fresh = in_turbulence()
        fly(fresh[0], 6)
        assert np.array_equal(flown(*fresh, theta), end)
    assert abs(ends[2][-1] - ends[3][-1]) > 3.0


def test_a_future_of_plain_jsbsim_is_the_plain_loop():
    def plain(steps, elevator=0.0, fdm=None):
        if fdm is None:
            fdm = jsbsim.FGFDMExec(None)
            fdm.set_debug_level(0)
            fdm.load_model("f16")
            fdm["ic/h-sl-ft"], fdm["ic/vc-kts"] = 10_000, 350
            fdm.run_ic()
        fdm["fcs/elevator-cmd-norm"] = elevator
        for _ in range(steps):
            fdm.run()
        return fdm

    fdm = plain(240)
    elevators = [-0.1, 0.0, 0.1]
    ends = branch([lambda u=u: plain(120, u, fdm)["attitude/theta-rad"] for u in elevators])
    assert ends == [plain(120, u, plain(240))["attitude/theta-rad"] for u in elevators]


def test_a_tree_of_futures():
    counter = [0]

    def grow(depth):
        counter[0] += 1
        if depth == 0:
            return [counter[0]]
        leaves = branch([lambda: grow(depth - 1)] * 3, jobs=2)
        return [leaf for part in leaves for leaf in part]

    assert grow(3) == [4] * 27
    assert counter == [1]


def test_the_errors_of_a_future_are_raised_as_they_are():
    plane = Aircraft("c172p", altitude=300, speed=90)
    sim = Simulation([plane], [], dt=1 / 120, log=False)

    def dive():
        plane.inputs["elevator"] = 0.3
        fly(sim, 60)

    with pytest.raises(FlightError) as here:
        branch([lambda: 1, dive])
    assert "dive" in str(here.value.__cause__)
    with pytest.raises(FlightError) as fresh:
        dive()
    assert (str(here.value), vars(here.value)) == (str(fresh.value), vars(fresh.value))


def raising(error):
    def future():
        raise error

    return future


class TakesMore(Exception):
    def __init__(self, message, *, height):
        super().__init__(message)


@pytest.mark.parametrize(
    ("future", "reason"),
    [
        (lambda: os.kill(os.getpid(), signal.SIGKILL), "killed by SIGKILL"),
        (lambda: os.kill(os.getpid(), signal.SIGTERM), "killed by SIGTERM"),
        (lambda: os._exit(7), "exit status 7"),
        (lambda: os._exit(0), "exit status 0"),
        (lambda: sys.exit("no more"), r"sys\.exit\('no more'\)"),
        (lambda: lambda: 0, "cannot be pickled"),
        (lambda: threading.Lock(), "cannot be pickled"),
        (raising(TakesMore("low", height=3)), "cannot be sent: TakesMore: low"),
        (raising(type("Local", (Exception,), {})("here")), "cannot be sent: Local: here"),
    ],
)
def test_a_future_without_a_result_is_named_with_its_reason(future, reason):
    with pytest.raises(BranchError, match=reason) as error:
        branch([lambda: 1, future, lambda: time.sleep(60)])
    assert error.value.future == 1


def test_of_several_errors_the_first_in_the_list_is_raised():
    late = [lambda: (time.sleep(0.5), 1 / 0), raising(KeyError()), lambda: time.sleep(60)]
    with pytest.raises(ZeroDivisionError):
        branch(late, jobs=3)


@pytest.mark.parametrize("jobs", [1, 2, 40, -1, None])
def test_results_have_the_order_of_the_futures(jobs):
    waits = [0.2, 0.0, 0.1, 0.0, 0.0]
    futures = (lambda i=i, s=s: (time.sleep(s), i)[1] for i, s in enumerate(waits))
    assert branch(futures, jobs) == [0, 1, 2, 3, 4]


def test_no_futures_have_no_results():
    assert branch([]) == []


def test_a_large_result():
    ones, text = branch([lambda: np.ones(2_000_000), lambda: b"x" * 5_000_000])
    assert ones.sum() == 2_000_000
    assert len(text) == 5_000_000


@pytest.mark.parametrize(
    ("futures", "jobs", "parameter"),
    [
        (lambda: 1, None, "futures"),
        (None, None, "futures"),
        ("abc", None, "futures"),
        ([lambda: 1, 3], None, "futures[1]"),
        ([lambda: 1], 0, "jobs"),
        ([lambda: 1], 1.5, "jobs"),
        ([lambda: 1], "2", "jobs"),
    ],
)
def test_bad_arguments_are_refused(futures, jobs, parameter):
    with pytest.raises(ParameterError) as error:
        branch(futures, jobs)
    assert error.value.parameter == parameter


def test_random_numbers_are_those_of_this_instant():
    random.seed(3)
    np.random.seed(4)  # noqa: NPY002, the global one
    draw = lambda: (random.random(), np.random.random())  # noqa: E731, NPY002
    numbers = branch([draw, draw, lambda: (random.seed(8), random.random())[1]])
    assert numbers[0] == numbers[1] == draw()
    assert numbers[2] != numbers[0][0]


def test_output_is_printed_once(tmp_path):
    script = "\n".join(
        [
            "from pathsim_jsbsim_blocks.studies import branch",
            "print('before')",
            "branch([lambda i=i: print('future', i) for i in range(12)], jobs=1)",
            "print('after')",
        ]
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    futures = [f"future {i}" for i in range(12)]
    assert done.stdout.splitlines() == ["before", *futures, "after"]
    assert done.stderr == ""


def test_without_fork_with_sockets_or_beside_a_flight_there_is_no_branch(monkeypatch):
    plane = Aircraft("c172p", altitude=5000, speed=90, flightgear="127.0.0.1:5560")
    with pytest.raises(BranchError, match="'c172p' is connected to FlightGear"):
        branch([lambda: 1])
    del plane
    assert branch([lambda: 1]) == [1]

    sim, inside, end = in_turbulence()[0], threading.Event(), threading.Event()
    wait = Scope()
    wait.sample = lambda t, dt: (inside.set(), end.wait())
    sim.add_block(wait)
    thread = threading.Thread(target=sim.run, args=(0.01,), name="flies beside")
    thread.start()
    inside.wait()
    with pytest.raises(BranchError, match=r"another thread runs PathSim \(flies beside\)"):
        branch([lambda: 1])
    end.set()
    thread.join()
    assert branch([lambda: 1]) == [1]

    # PathView flies in processes of its own
    with Server({}, port=0) as server:
        threading.Thread(target=server.run, daemon=True).start()
        assert branch([lambda: 1]) == [1]

    monkeypatch.delattr(os, "fork")
    with pytest.raises(BranchError, match=r"no os\.fork") as error:
        branch([lambda: 1])
    assert error.value.future is None


INTERRUPTED = """
import os, sys
import psutil
from pathsim_jsbsim_blocks.studies import branch

def busy():
    while True:
        pass

files = os.listdir("/dev/fd")
print("ready", flush=True)
try:
    branch([busy, lambda: branch([busy, busy])], jobs=2)
except KeyboardInterrupt:
    print(len(psutil.Process().children()), len(os.listdir("/dev/fd")) - len(files))
"""


@pytest.mark.parametrize("how", ["SIGINT", "SIGKILL"])
def test_nothing_outlives_an_interrupt_or_the_end_of_this_process(how):
    with subprocess.Popen(
        [sys.executable, "-c", INTERRUPTED], stdout=subprocess.PIPE, start_new_session=True
    ) as parent:
        assert parent.stdout.readline() == b"ready\n"
        deadline = time.monotonic() + 20
        while len(copies := psutil.Process(parent.pid).children(recursive=True)) < 4:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        if how == "SIGINT":
            os.killpg(parent.pid, signal.SIGINT)  # as a terminal does
            assert parent.stdout.readline() == b"0 0\n"
        else:
            parent.kill()
    deadline = time.monotonic() + 10
    while any(c.is_running() and c.status() != psutil.STATUS_ZOMBIE for c in copies):
        assert time.monotonic() < deadline
        time.sleep(0.05)
