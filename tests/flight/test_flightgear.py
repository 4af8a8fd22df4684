"""FlightGear's native FDM packets, received and decoded, and the pace of the flight."""

import contextlib
import re
import socket
import struct
import time

import numpy as np
import pytest
from models_from_outside import changed
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, SinusoidalSource
from pathsim.events import Schedule
from plane_diagram import diagram

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, ParameterError, fly
from pathsim_jsbsim_blocks.cli import main
from pathsim_jsbsim_blocks.cli.contexts import in_real_time
from pathsim_jsbsim_blocks.tracks.recording import recorded_flights, tracks

# FlightGear's net_fdm.hxx, version 24: version, padding, longitude, latitude (rad), altitude (m),
# height above ground (m), phi, theta, psi (rad), alpha, beta (rad), big endian
PACKET = struct.Struct(">II3d6f")


@contextlib.contextmanager
def listening(port=0):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as receiver:
        receiver.bind(("127.0.0.1", port))
        receiver.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
        receiver.setblocking(False)
        yield receiver


@pytest.fixture
def receiver():
    with listening() as receiver:
        yield receiver


def address(receiver):
    return f"127.0.0.1:{receiver.getsockname()[1]}"


def packets(receiver):
    found = []
    while True:
        try:
            found.append(receiver.recv(4096))
        except BlockingIOError:
            return found


def kicked(receiver=None):
    plane = Aircraft("c172p", speed=90, flightgear=receiver and address(receiver))
    kick = DoubletSource(0.3, start=0.1, width=0.3)
    return diagram(plane, ("theta", "phi", "h", "lat"), {"aileron": kick})


def test_packets_hold_the_flight(receiver):
    with recorded_flights() as recordings:
        sim, _ = kicked(receiver)
    sim.run(1.0)
    [track] = tracks(recordings)
    received = packets(receiver)
    assert len(received) >= 60
    assert {len(packet) for packet in received} == {408}
    rows = [PACKET.unpack_from(packet) for packet in received]
    assert {row[0] for row in rows} == {24}
    flown = np.array([row for row in rows if row[3] > 0])
    # it flies north: each packet is of the instant with its latitude
    assert len(flown) == 60
    at = np.abs(np.radians(track.lat)[:, None] - flown[:, 3]).argmin(axis=0)
    assert np.array_equal(np.diff(at), np.full(59, 2))
    # every second of JSBSim's steps, those that the search for the trim has made included
    assert at[-1] in (119, 120)
    for column, values in (
        (2, np.radians(track.lon)),
        (3, np.radians(track.lat)),
        (6, np.radians(track.phi)),
        (7, np.radians(track.theta)),
    ):
        assert flown[:, column] == pytest.approx(values[at], abs=1e-6)
    assert np.ptp(flown[:, 6]) > 0.05
    turned = np.angle(np.exp(1j * (flown[:, 8] - np.radians(track.psi[at]))))
    assert np.abs(turned).max() < 1e-6
    # above the ellipsoid, in m
    assert flown[:, 4] == pytest.approx(track.h[at] * 0.3048, abs=0.5)


def test_sending_changes_no_bit_of_the_flight(receiver):
    plain, there = kicked()
    shown, here = kicked(receiver)
    for sim in (plain, shown):
        sim.run(0.5)
        sim.run(0.5, reset=True)
    assert np.array_equal(there.read()[1], here.read()[1])
    # both flights were sent
    assert len(packets(receiver)) > 60


@pytest.mark.parametrize("network", [False, True])
@pytest.mark.parametrize("files", [False, True])
@pytest.mark.parametrize("shown", [False, True])
def test_network_files_and_flightgear_are_allowed_apart(
    network, files, shown, receiver, tmp_path, monkeypatch
):
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    port = receiver.getsockname()[1]
    csv = tmp_path / "own.csv"
    outputs = (
        f'<output name="127.0.0.1" type="SOCKET" port="{port}" protocol="UDP" rate="60">'
        "<rates>ON</rates></output>"
        f'<output name="{csv}" type="CSV" rate="60"><rates>ON</rates></output>'
    )
    root = changed(tmp_path, "c172p", ("</fdm_config>", outputs + "</fdm_config>"))
    with listening() as flightgear:
        plane = Aircraft(
            "c172p",
            speed=90,
            root=root,
            allow_network=network,
            allow_files=files,
            flightgear=address(flightgear) if shown else None,
        )
        Simulation([plane], dt=plane.T, log=False).run(0.2)
        assert bool(packets(flightgear)) == shown
    assert bool(packets(receiver)) == network
    written = [path for path in tmp_path.rglob("*.csv") if path.stat().st_size]
    assert bool(written) == files


@pytest.mark.parametrize(
    "bad", ["a b", "127.0.0.1:0", "127.0.0.1:99999", ":x", 5550, "no.such.host.invalid:5550"]
)
def test_an_address_that_cannot_be_is_refused(bad):
    with pytest.raises(ParameterError) as error:
        Aircraft("c172p", speed=90, flightgear=bad)
    assert error.value.parameter == "flightgear"


SCRIPT = """
from pathsim import Simulation
from pathsim_jsbsim_blocks import Aircraft

one, two = Aircraft("c172p", speed=90), Aircraft("c172p", speed=100)
Simulation([one, two], dt=1 / 120, log=False).run(0.5)
"""


def test_the_command_flies_in_real_time_and_sends_every_aircraft(tmp_path, capsys):
    (tmp_path / "script.py").write_text(SCRIPT)
    with contextlib.ExitStack() as stack:
        for _ in range(50):  # two ports in a row that are free
            one = stack.enter_context(listening())
            with contextlib.suppress(OSError):
                two = stack.enter_context(listening(one.getsockname()[1] + 1))
                break
        began = time.perf_counter()
        assert main(["run", str(tmp_path / "script.py"), "--flightgear", address(one)]) == 0
        assert time.perf_counter() - began > 0.5
        for receiver in (one, two):
            assert len(packets(receiver)) > 20
    said = capsys.readouterr().out
    assert re.search(r"real time: 0\.5 s flown in \d+\.\d s, late by \d+ ms", said)


def test_the_most_that_a_run_is_late(monkeypatch):
    # a clock that only waiting moves on
    now = [50.0]

    def sleep(seconds):
        now[0] += seconds

    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
    monkeypatch.setattr(time, "sleep", sleep)
    source, scope = SinusoidalSource(), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.01, log=False)
    sim.run(1.0)
    usual = Simulation.run
    sim.add_event(Schedule(t_start=1.3, t_period=1e3, func_act=lambda t: sleep(0.25)))
    with in_real_time() as pace:
        sim.run(1.0)
    # a step and a wait of 1 ms
    assert pace.worst == pytest.approx(0.25, abs=0.012)
    assert Simulation.run is usual
    assert (pace.simulated, pace.real) == pytest.approx((1.0, 1.0), abs=0.012)


def test_a_run_after_a_reset_or_a_stop_keeps_the_pace_too():
    source, scope = SinusoidalSource(), Scope()
    sim = Simulation([source, scope], [Connection(source, scope)], dt=0.01, log=False)
    sim.run(0.5)
    with in_real_time() as pace:
        statistics = fly(sim, 0.2, reset=True)
    assert sim.time == pytest.approx(0.2)
    assert statistics["total_steps"] == statistics["successful_steps"] == 20
    assert statistics["runtime_ms"] > 150
    assert pace.real > 0.15
    sim.stop()
    with in_real_time() as pace:
        sim.run(0.2)
    assert sim.time == pytest.approx(0.4)
    assert pace.real > 0.15
