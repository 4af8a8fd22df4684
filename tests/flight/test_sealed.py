"""Sealed and quiet: no socket, no file, nothing on the console, looked at from outside the process.

Each test flies in a process of its own and measures there what the kernel knows of it: descriptors
and listening ports, the folders that a file could land in, the bytes on descriptors 1 and 2.
"""

import contextlib
import hashlib
import json
import logging
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
import weakref
from pathlib import Path

import jsbsim
import numpy as np
import pytest
from fleet_conditions import FLYING
from models_from_outside import changed
from pathsim import Connection, Simulation
from pathsim.blocks import StepSource

from pathsim_jsbsim_blocks import Aircraft, AircraftError, FlightError, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, empty_weight_cg
from pathsim_jsbsim_blocks.flight.console import capture_console, messages

INSTALLED = Path(jsbsim.__file__).parent
TESTS = Path(__file__).parents[1]

# models that write a file as they come
WRITERS = ["B17", "ball", "ballx", "c172x", "global5000", "pogo-jsbsim"]

# One interpreter with the imports, which take longer than most flights; each test has a fork of it,
# which has loaded no model and ends as an interpreter does.
FLIGHTS = """
import json, os, psutil, signal, sys, tempfile
from fleet_conditions import keywords
from pathsim import Simulation
from pathsim_jsbsim_blocks import AircraftError, JSBSimFDM, TrimCondition
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names

def sockets():
    me = psutil.Process()
    return sorted([str(kind), c.laddr.port] for kind in ("tcp", "udp")
                  for c in me.net_connections(kind=kind))

def files():
    return sorted(f.path for f in psutil.Process().open_files())

for line in sys.stdin:
    task = json.loads(line)
    read, write = os.pipe()
    if not os.fork():
        break
    os.close(write)
    with open(read, "rb") as pipe:
        printed = pipe.read()
    _, status = os.wait()
    print(json.dumps([os.waitstatus_to_exitcode(status), printed.decode("latin-1")]), flush=True)
else:
    sys.exit()
signal.alarm(300)
nothing = os.open(os.devnull, os.O_RDONLY)
for opened, number in ((nothing, 0), (write, 1), (write, 2)):
    os.dup2(opened, number)
for opened in (read, write, nothing):
    os.close(opened)
os.chdir(task["work"])
os.environ.update(dict.fromkeys(("TMPDIR", "TMP"), task["temporary"]))
tempfile.tempdir = None
exec(task["code"])
with open(task["report"], "w") as file:
    json.dump(report, file)
"""


@pytest.fixture(scope="module")
def interpreter():
    path = os.pathsep.join([str(TESTS), os.environ.get("PYTHONPATH", "")])
    with subprocess.Popen(
        [sys.executable, "-c", FLIGHTS],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONPATH": path, "PYTHONDONTWRITEBYTECODE": "1"},
    ) as process:
        yield process
        process.stdin.close()


@pytest.fixture
def outside(interpreter, tmp_path):
    """Run code in a process of its own, which prints and leaves nothing else; returns its report."""

    def run(code, prints=b"", leaves=()):
        work, temporary, report = (tmp_path / name for name in ("work", "tmp", "report.json"))
        work.mkdir()
        temporary.mkdir()
        task = {"code": code, "work": work, "temporary": temporary, "report": report}
        interpreter.stdin.write(json.dumps(task, default=str) + "\n")
        interpreter.stdin.flush()
        status, printed = json.loads(interpreter.stdout.readline())
        assert status == 0, printed
        assert printed.encode("latin-1") == prints
        assert sorted(os.listdir(work)) == [*leaves]
        assert os.listdir(temporary) == []
        return json.loads(report.read_text())

    return run


def fingerprint(folder):
    """Every file below a folder: size, time of change, contents."""
    return {
        str(p.relative_to(folder)): (
            p.stat().st_size,
            p.stat().st_mtime_ns,
            hashlib.sha256(p.read_bytes()).hexdigest(),
        )
        for p in folder.rglob("*")
        if p.is_file() and p.suffix != ".pyc"
    }


FLY_ALL = f"""
report = dict(flown=[], refused=[], sockets=[], files=[])
before = files()
for name in aircraft_names():
    try:
        # each as far as it goes: opened, initialised, in the air where it trims
        if name in {list(FLYING)!r}:
            fdm = JSBSimFDM(**keywords(name))
            Simulation([fdm], dt=fdm.T, log=False).run(0.5)
            report["flown"].append(name)
        else:
            airframe = Airframe(name)
            airframe.run_ic()
            for _ in range(60):
                airframe.fdm.run()
    except AircraftError as error:
        report["refused"].append(name)
    # while the model is alive
    report["sockets"] += [[name, *socket] for socket in sockets()]
    report["files"] += [[name, file] for file in files() if file not in before]
"""


@pytest.mark.long
def test_all_models_open_no_socket_write_no_file_and_print_nothing(outside):
    before = fingerprint(INSTALLED), sorted(os.listdir("/"))
    report = outside(FLY_ALL)
    assert report["sockets"] == []
    assert report["files"] == []
    assert (fingerprint(INSTALLED), sorted(os.listdir("/"))) == before
    assert sorted(report["flown"]) == sorted(FLYING)
    # the others were initialised too, but for those that cannot be
    assert report["refused"] == ["blank", "dr1", "fokker50", "Pterosaur"]


def test_a_typo_in_ones_own_model_is_answered_with_the_nearest_property(tmp_path):
    typo = r"\A(.*?)aero/alpha-rad", r"\1aero/alfa-rad"
    with pytest.raises(AircraftError) as caught:
        Airframe("c172p", root=changed(tmp_path, "c172p", typo))
    assert caught.value.missing == ("aero/alfa-rad",)
    assert caught.value.nearest[0] == "aero/alpha-rad"


@pytest.mark.long
def test_a_root_of_ones_own_stays_as_it_is(outside, tmp_path):
    # with a root given JSBSim writes its files there, not into the current directory
    root = tmp_path / "root"
    for name in WRITERS:
        changed(root, name)
    before = fingerprint(root)
    report = outside(
        f"""
report = []
for name in {WRITERS!r}:
    airframe = Airframe(name, root={str(root)!r})
    airframe.run_ic()
    report.append(airframe.fdm.run())
"""
    )
    assert report == [True] * len(WRITERS)
    assert fingerprint(root) == before


@pytest.mark.long
def test_sealing_goes_on_to_the_last_output(outside, tmp_path):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", 0))
        receiver.setblocking(False)
        # below an absolute path, or else the output path of a sealed model keeps it from the disk
        outputs = ['<output name="left.csv" type="CSV" rate="1"/>'] * 1000 + [
            f'<output name="{tmp_path / "work" / "left.csv"}" type="CSV" rate="1"/>',
            '<output name="127.0.0.1" type="SOCKET" protocol="UDP" rate="1" '
            f'port="{receiver.getsockname()[1]}"/>',
        ]
        end = "</fdm_config>", "".join(outputs) + "</fdm_config>"
        root = Path(changed(tmp_path / "root", "c172p", end))
        before = fingerprint(root)
        report = outside(
            f"""
airframe = Airframe("c172p", root={str(root)!r})
airframe.run_ic()
report = [airframe.fdm.run(), files()]
"""
        )
        received = []
        with contextlib.suppress(BlockingIOError):
            received.append(receiver.recv(1000))
    assert report == [True, []]
    assert fingerprint(root) == before
    assert received == []


def test_a_failed_trim_prints_nothing_whatever_jsbsims_own_variable_says(outside):
    # JSBSim does, and Python's last-resort handler prints warnings of loggers without handlers
    report = outside(
        """
os.environ["JSBSIM_DEBUG"] = "127"
from pathsim_jsbsim_blocks import TrimError
from pathsim_jsbsim_blocks.flight import trim
report = []
for solver in ("jsbsim", "newton"):
    try:
        trim(Airframe("737"), TrimCondition(speed=90, altitude=30000, solver=solver), hint=False)
    except TrimError as error:
        report.append(error.reason)
"""
    )
    assert len(report) == 2


def test_the_network_can_be_allowed(outside, tmp_path):
    # another process may hold the ports that the 737 asks for, so a copy asks for free ones
    with socket.create_server(("", 0)) as one, socket.create_server(("", 0)) as other:
        tcp, udp = (server.getsockname()[1] for server in (one, other))
    ports = [(f'port="{theirs}"', f'port="{ours}"') for theirs, ours in ((5137, tcp), (5139, udp))]
    root = changed(tmp_path / "root", "737", *ports)
    report = outside(
        f"""
report = []
for allow in (False, True):
    fdm = JSBSimFDM(**keywords("737"), JSBSim_path={root!r}, allow_network=allow)
    report.append(sockets())
"""
    )
    assert report == [[], [["tcp", tcp], ["udp", udp]]]


@pytest.mark.parametrize("mode", ["full", "none"])
def test_a_file_that_is_allowed_has_the_last_flight_without_its_trim(mode, tmp_path):
    output = '<output name="flight.csv" type="CSV" rate="10"><velocities> ON </velocities></output>'
    root = changed(tmp_path / "root", "c172p", ("</fdm_config>", f"{output}</fdm_config>"))
    plane = Aircraft("c172p", mode=mode, root=root, allow_files=True)
    simulation = Simulation([plane], dt=plane.T, log=False)
    for _ in range(2):
        simulation.run(1.0, reset=True)
        plane.response("elevator", [0.01], "q")
        title, *rows = Path(root, "flight.csv").read_text().splitlines()
        assert title.startswith("Time")
        assert len(rows) == 10
        assert np.ptp([float(row.partition(",")[0]) for row in rows]) == pytest.approx(0.9)


def test_files_of_another_cg_and_planet_are_gone_after_loading(outside):
    x, _, _ = empty_weight_cg("global5000")
    before = fingerprint(INSTALLED)
    # `outside` asserts that the temporary folder is empty in the end
    report = outside(
        f"""
fdm = JSBSimFDM(aircraft_model="global5000", planet="round", condition=TrimCondition(
    altitude=15000, speed=250, gear=0, empty_cg_x={0.97 * x!r}))
report = [os.listdir(os.environ["TMPDIR"])]
Simulation([fdm], dt=fdm.T, log=False).run(0.5)
Simulation([fdm], dt=fdm.T, log=False).run(0.5, reset=True)
"""
    )
    assert report == [[]]
    assert fingerprint(INSTALLED) == before


def refused_trim():
    with pytest.raises(TrimError):
        Aircraft("737", altitude=15000, speed=120, solver="jsbsim")


def test_what_jsbsim_says_after_a_search_keeps_its_level(caplog):
    refused_trim()
    console = capture_console()
    with caplog.at_level(logging.DEBUG, logger="pathsim_jsbsim_blocks.jsbsim"):
        console.set_level(jsbsim.LogLevel.ERROR)
        console.message("no fuel")
        console.flush()
    assert [(r.levelno, r.getMessage()) for r in caplog.records] == [(logging.ERROR, "no fuel")]


def test_what_jsbsim_says_in_other_threads_reaches_the_logger(caplog, capfd):
    with caplog.at_level(logging.DEBUG, logger="pathsim_jsbsim_blocks.jsbsim"):
        threads = [threading.Thread(target=refused_trim, name=f"flight {i}") for i in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    speakers = {
        r.threadName for r in caplog.records if "doesn't appear to be trimmable" in r.getMessage()
    }
    assert speakers == {thread.name for thread in threads}
    assert capfd.readouterr() == ("", "")


def in_a_thread(action):
    thread = threading.Thread(target=action)
    thread.start()
    thread.join()
    time.sleep(0.1)  # a thread frees its storage after it can be joined


def test_a_flight_goes_on_in_a_thread_that_has_the_number_of_an_ended_one(capfd):
    # below absolute zero JSBSim complains in each step
    plane = Aircraft("c172p", altitude=5000, speed=90, input_properties=["atmosphere/delta-T"])
    cold = StepSource(amplitude=-2000, tau=0.9)
    sim = Simulation(
        [plane, cold], [Connection(cold, plane["atmosphere/delta-T"])], dt=1 / 120, log=0
    )
    numbers = []

    def go_on():
        numbers.append(threading.get_ident())
        with contextlib.suppress(FlightError):
            sim.run(0.5)

    for _ in range(3):
        in_a_thread(go_on)
    assert len({*numbers}) < 3
    assert capfd.readouterr() == ("", "")


def test_the_end_of_a_thread_frees_no_logger():
    # JSBSim drops its reference without the GIL: if that were the last one, the process would
    # crash occasionally
    class Own(jsbsim.FGLogger):
        pass

    loggers = []

    def listen():
        loggers.append(capture_console())

    def listen_oneself():
        capture_console()
        own = Own()
        loggers.append(weakref.ref(own))
        jsbsim.set_logger(own)
        messages(lambda: None)  # puts it back
        in_a_thread(listen)  # JSBSim's module knows this one from now on

    in_a_thread(listen)
    in_a_thread(listen_oneself)
    console, own, again = loggers
    assert console is again is capture_console()
    assert own() is not None


@pytest.mark.long
def test_threads_that_end_while_others_count_take_no_process_with_them(outside):
    # In 20,000 threads beside a busy one, one count came out wrong. What many such losses add up to
    # is subtracted at once: it freed members of JSBSim's enumerations while they were in use
    report = outside(
        """
import ctypes, jsbsim, threading
from pathsim_jsbsim_blocks import Aircraft
def fly(i):
    plane = Aircraft("c172p", altitude=5000, speed=90)
    Simulation([plane], dt=plane.T, log=False).run(0.1)
    flown[i] = plane.outputs["theta"]
for thing in (*jsbsim.LogLevel, *jsbsim.LogFormat):
    for _ in range(50):
        ctypes.pythonapi.Py_DecRef(ctypes.py_object(thing))
flown = {}
for batch in range(4):
    threads = [threading.Thread(target=fly, args=(10 * batch + i,)) for i in range(10)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
report = len(flown), len(set(flown.values())), len([*jsbsim.LogLevel])
"""
    )
    assert report == [40, 1, 7]


def test_each_thread_keeps_what_is_said_to_it():
    console, heard = capture_console(), {}
    said = threading.Barrier(2)

    def listen(name):
        def speak():
            console.set_level(jsbsim.LogLevel.INFO)
            said.wait()
            console.message(name)
            said.wait()
            console.flush()

        heard[name] = [text for _, text in messages(speak)[1]]

    threads = [threading.Thread(target=listen, args=(name,)) for name in ("one", "two")]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert heard == {"one": ["one"], "two": ["two"]}


def test_a_handler_that_raises_does_no_harm(capfd):
    class Broken(logging.Handler):
        def emit(self, record):
            raise OSError("disk full")

    logger, broken = logging.getLogger("pathsim_jsbsim_blocks.jsbsim"), Broken()
    logger.addHandler(broken)
    try:
        refused_trim()
    finally:
        logger.removeHandler(broken)
    assert capfd.readouterr() == ("", "")


def test_the_watch_sees_what_it_looks_for(outside):
    # show that the checks above detect violations: open a port, a file, and print
    report = outside(
        """
import socket
server = socket.create_server(("127.0.0.1", 0))
file = open("left.csv", "w")
os.write(1, b"one")
os.write(2, b"two")
report = [sockets() == [["tcp", server.getsockname()[1]]], files()]
""",
        prints=b"onetwo",
        leaves=["left.csv"],
    )
    assert report[0]
    assert report[1][0].endswith("left.csv")


def test_a_copy_is_removed_even_if_loading_fails(monkeypatch, tmp_path):
    broken = "<aerodynamics>", '<system file="nowhere"/><aerodynamics>'
    root, temporary = changed(tmp_path / "root", "global5000", broken), tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(temporary))
    with pytest.raises(AircraftError):
        Airframe("global5000", root=root, empty_cg_x=700.0)
    assert list(temporary.iterdir()) == []
