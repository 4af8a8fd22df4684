"""FlightGear itself, without a window: it receives a flight, and its property tree is read back."""

import contextlib
import os
import shutil
import signal
import socket
import subprocess
import time

import numpy as np
import pytest

from pathsim_jsbsim_blocks.cli import main

SCRIPT = """
from pathsim import Connection, Simulation
from pathsim_jsbsim_blocks import Aircraft, DoubletSource
plane = Aircraft("c172p", altitude=5000.0, speed=90.0, heading=50.0)
kick = DoubletSource(amplitude=0.3, start=1.0, width=2.0)
sim = Simulation([plane, kick], [Connection(kick, plane["aileron"])], dt=1 / 120, log=False)
if __name__ == "__main__":
    sim.run(6.0)
"""
# in the order of the columns of a track
SHOWN = (
    "/position/latitude-deg",
    "/position/longitude-deg",
    "/position/altitude-ft",
    "/orientation/pitch-deg",
    "/orientation/roll-deg",
    "/orientation/heading-deg",
)
PATH = os.environ["PATH"] + os.pathsep + "/usr/games"  # where Debian has it
STARTED = 900.0  # s; FlightGear indexes its airports when it first starts


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as taken:
        taken.bind(("127.0.0.1", 0))
        return taken.getsockname()[1]


def properties(port):
    """What FlightGear shows; None while it cannot be asked."""
    with (
        contextlib.suppress(OSError, ValueError),
        socket.create_connection(("127.0.0.1", port), timeout=60) as connection,
        connection.makefile("rw", newline="\r\n") as telnet,
    ):
        print("data", file=telnet, flush=True)
        found = []
        for name in ("/sim/sceneryloaded", *SHOWN):
            print("get", name, file=telnet, flush=True)
            found.append(telnet.readline().strip())
        return [float(x) for x in found[1:]] if found[0] == "true" else None
    return None


def told(port, limit, wanted=lambda shown: True):
    """What FlightGear shows, as soon as it is what is wanted."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        shown = properties(port)
        if shown and wanted(shown):
            return shown
        time.sleep(1.0)
    pytest.fail(f"FlightGear shows {shown}")


@contextlib.contextmanager
def running(folder, *options):
    """FlightGear with further options; yields the port at which its properties are read."""
    missing = [
        p for p in ("fgfs", "xvfb-run", "dbus-run-session") if not shutil.which(p, path=PATH)
    ]
    if missing:
        pytest.skip(f"not installed: {', '.join(missing)}")
    telnet = free_port(socket.SOCK_STREAM)
    command = [
        *("dbus-run-session", "--", "xvfb-run", "-a", "-s", "-screen 0 640x480x24", "fgfs"),
        *options,
        # little to draw: the processor does it all
        *(f"--telnet={telnet}", "--geometry=320x240"),
        "--prop:/sim/rendering/shaders/quality-level=0",
        *("--disable-sound", "--disable-terrasync", "--disable-real-weather-fetch"),
        *("--disable-ai-models", "--disable-ai-traffic", "--log-level=alert"),
    ]
    of_its_own = {"PATH": PATH, "LIBGL_ALWAYS_SOFTWARE": "1", "FG_HOME": str(folder / "fgfs")}
    with open(folder / "fgfs.log", "w") as log:
        process = subprocess.Popen(
            command,
            env={**os.environ, **of_its_own},
            stdout=log,
            stderr=log,
            start_new_session=True,
        )
    try:
        told(telnet, STARTED)
        yield telnet
    finally:
        os.killpg(process.pid, signal.SIGTERM)
        process.wait(60)


@pytest.fixture
def flightgear(tmp_path):
    """Its native FDM port, and the port at which its properties are read."""
    fdm = free_port(socket.SOCK_DGRAM)
    native = f"--native-fdm=socket,in,60,,{fdm},udp"
    # the smallest aircraft
    with running(tmp_path, "--fdm=null", native, "--aircraft=ufo") as telnet:
        yield fdm, telnet


@pytest.mark.flightgear
def test_flightgear_shows_the_position_and_the_attitude_that_were_sent(
    flightgear, tmp_path, monkeypatch
):
    fdm, telnet = flightgear
    monkeypatch.chdir(tmp_path)
    (tmp_path / "own.py").write_text(SCRIPT)
    to = f"127.0.0.1:{fdm}"
    assert main(["run", "own.py", "--flightgear", to, "--track", "flight.csv"]) == 0
    flown = np.genfromtxt("flight.csv", delimiter=",", skip_header=1)[:, 1:7]
    # the doublet has moved it; every other instant is sent, the last one among them
    assert np.ptp(flown[:, 4]) > 5.0
    last = flown[-1]
    shown = told(telnet, 60.0, lambda shown: abs(shown[0] - last[0]) < 1e-9)
    # deg, deg, ft, deg, deg, deg: about 0.1 mm, and the single precision of the angles
    assert (np.abs(np.subtract(shown, last)) <= [2e-9, 2e-9, 0.01, 1e-5, 1e-5, 1e-4]).all()
