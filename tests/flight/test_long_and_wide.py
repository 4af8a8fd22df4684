"""Long flights, many aircraft, many lives: exact counts, bounded memory."""

import gc
import subprocess
import sys

import numpy as np
import psutil
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, Autopilot

ANGLES = ("theta", "phi", "psi", "p", "q", "r")
MEASURED = (*ANGLES, "h", "hdot", "vc", "elev_sat", "ail_sat", "thr_sat")
COMMANDS = ("elevator", "aileron", "rudder", "throttle")
TURBULENCE = {
    "atmosphere/randomseed": 7,
    "atmosphere/turb-type": 3,
    "atmosphere/turbulence/milspec/severity": 3,
    "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 30,
}


def megabytes():
    gc.collect()
    return psutil.Process().memory_info().rss / 2**20


def mission():
    """A 737 that its autopilot holds in turbulence, its fuel frozen, and h each second."""
    plane = Aircraft(
        "737",
        altitude=10000,
        speed=280,
        gear=0,
        properties=TURBULENCE,
        setup={"propulsion/fuel_freeze": 1},
    )
    pilot = Autopilot(gains="737")
    scope = Scope(sampling_period=1.0)
    wires = [
        Connection(plane[MEASURED], pilot[MEASURED]),
        Connection(pilot[COMMANDS], plane[COMMANDS]),
        Connection(plane["h"], scope),
    ]
    sim = Simulation([plane, pilot, scope], wires, dt=plane.T, log=False)
    return sim, plane, scope


def minutes(count):
    """Memory that a flight of some minutes takes after the first, in MB."""
    sim, plane, scope = mission()
    sim.run(60)
    before = megabytes()
    sim.run(60 * (count - 1))
    growth = megabytes() - before
    assert plane.samples == 7200 * count
    assert plane.fdm.get_sim_time() == pytest.approx(60.0 * count, abs=1e-6)
    time, [h] = scope.read()
    assert len(time) == 60 * count + 1
    assert np.abs(h - 10000.0).max() < 64.0
    return growth


def lives(count):
    """Memory that lives of a diagram leave behind after the first tenth of them, in MB."""

    def life():
        plane, scope = Aircraft("c172p", altitude=5000, speed=90), Scope()
        wires = [Connection(plane["theta"], scope)]
        Simulation([plane, scope], wires, dt=plane.T, log=False).run(0.1)

    for _ in range(count // 10):
        life()
    before = megabytes()
    for i in range(count - count // 10):
        life()
        if i % 10 == 0:
            gc.collect()  # a block and its events refer to each other: only what stays counts
    return megabytes() - before


@pytest.mark.long
@pytest.mark.parametrize(
    ("flight", "count", "most"),
    [
        # 64800 steps with two numbers a second are 10 kB; a leak of 100 bytes a step were 6 MB
        (minutes, 10, 3.0),
        # an aircraft takes 0.37 MB: 270 that stay were 100 MB
        (lives, 300, 8.0),
    ],
)
def test_memory_stays_bounded(flight, count, most):
    # in a process of its own, whose memory no other test moves
    done = subprocess.run(
        [sys.executable, __file__, flight.__name__, str(count)],
        capture_output=True,
        text=True,
        timeout=500,
    )
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) < most


if __name__ == "__main__":
    print({f.__name__: f for f in (minutes, lives)}[sys.argv[1]](int(sys.argv[2])))
