"""Environments for learning, resets, and steps of an aircraft with a hold, beside plain JSBSim.

    python benchmarks/environment.py [PYTHON]

Each figure is the median over repetitions, each ratio the median of those within a repetition.
PYTHON, optional, is the interpreter of an environment with gymnasium-jsbsim 0.1.1: the steps of its
``JSBSim-HeadingControlTask-Cessna172P-Shaping.STANDARD-NoFG-v0`` are then measured too, in a
process of its own between ours; three quarters of it are JSBSim's own. At equal task both move
aileron, elevator and rudder of a Cessna 172, hold them for 12 frames of 1/60 s, observe attitude,
rates and speeds, and judge heading and altitude. A step of our pitch task is compared with its 12
frames in JSBSim alone.
"""

import subprocess
import sys
import time

import gymnasium
import jsbsim
import numpy as np
from pathsim import Connection, Simulation
from report import HEADER, row

from pathsim_jsbsim_blocks import Aircraft, PitchHold, fly
from pathsim_jsbsim_blocks.gym import make_env

STEPS = 300
RESETS = 15
PERIODS = 12_000
REPETITIONS = 9
FIGURES = ("step", "peer", "pitch", "frames", "ours", "plain", "fly", "loop")

PEER = """
import sys, time
import gymnasium as gym, numpy as np, gymnasium_jsbsim
env = gym.make("JSBSim-HeadingControlTask-Cessna172P-Shaping.STANDARD-NoFG-v0")
env = env.unwrapped
action = np.zeros(env.action_space.shape)
for line in sys.stdin:
    env.reset()
    start = time.perf_counter()
    n = 0
    while n < %d:
        done = env.step(action)[2]
        n += 1
        if done:
            pause = time.perf_counter()
            env.reset()
            start += time.perf_counter() - pause
    print("\\nseconds", (time.perf_counter() - start) / n, flush=True)
"""


def heading():
    plane = Aircraft("c172p", altitude=5000, speed=100, heading=270, T=12 / 60, substeps=12)
    sim = Simulation([plane], [], dt=12 / 60, log=False)
    ports = ("h", "theta", "phi", "p", "q", "r", "vt", "alpha", "beta", "nx", "nz", "psi")
    return make_env(
        sim,
        action={f"plane.{port}": (-1, 1) for port in ("aileron", "elevator", "rudder")},
        observation=[f"plane.{port}" for port in ports],
        reward=lambda v: -abs(v["plane.psi"] - 270) - abs(v["plane.h"] - 5000) / 100,
        step=12 / 60,
        duration=10_000.0,
    )


def time_plain_steps():
    """Seconds per step of the pitch task by JSBSim alone: 12 frames with a command."""
    fdm = plain()
    put = fdm.get_property_manager().get_node("fcs/elevator-cmd-norm").set_double_value
    run = fdm.run
    start = time.perf_counter()
    for _ in range(STEPS):
        put(0.0)
        for _ in range(12):
            run()
    return (time.perf_counter() - start) / STEPS


def time_steps(env):
    """Seconds per step of an environment, its controls trimmed."""
    env.reset()
    action = np.zeros(env.action_space.shape)
    start = time.perf_counter()
    for _ in range(STEPS):
        env.step(action)
    return (time.perf_counter() - start) / STEPS


def plain():
    """A trimmed Cessna 172 in JSBSim alone."""
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    fdm.load_model("c172p")
    trim_plain(fdm)
    return fdm


def trim_plain(fdm):
    fdm["propulsion/set-running"] = -1
    fdm["ic/h-sl-ft"], fdm["ic/vc-kts"], fdm["ic/gamma-deg"] = 5000, 90, 0
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["simulation/do_simple_trim"] = 1


def time_resets(reset):
    start = time.perf_counter()
    for _ in range(RESETS):
        reset()
    return (time.perf_counter() - start) / RESETS


def time_our_resets():
    plane = Aircraft("c172p", altitude=5000, speed=90)
    plane.reset()
    return time_resets(plane.reset)


def time_diagram():
    """Seconds per period of an aircraft with a pitch hold under `fly`."""
    plane, hold = Aircraft("c172p", altitude=5000, speed=90), PitchHold(gains="c172p")
    wires = [Connection(plane[port], hold[port]) for port in ("theta", "q", "elev_sat")]
    wires.append(Connection(hold["elevator"], plane["elevator"]))
    sim = Simulation([plane, hold], wires, dt=1 / 120, log=False)
    start = time.perf_counter()
    fly(sim, PERIODS / 120, progress=False)
    return (time.perf_counter() - start) / PERIODS


def time_loop():
    """Seconds per period of a loop written by hand: a PI law with feedback of the pitch rate."""
    fdm = plain()
    nodes = fdm.get_property_manager()
    read_theta = nodes.get_node("attitude/theta-deg").get_double_value
    read_q = nodes.get_node("velocities/q-rad_sec").get_double_value
    put = nodes.get_node("fcs/elevator-cmd-norm").set_double_value
    run, theta_ref, integral = fdm.run, read_theta(), 0.0
    start = time.perf_counter()
    for _ in range(PERIODS):
        error = theta_ref - read_theta()
        integral += 0.063 / 120 * error
        put(-(0.064 * error + integral - 0.143 * read_q()))
        run()
    return (time.perf_counter() - start) / PERIODS


def rows(python=None):
    jsbsim.FGJSBBase().debug_lvl = 0
    found = {name: [] for name in FIGURES}
    env, pitch = heading(), gymnasium.make("pathsim-jsbsim/PitchHold-v1").unwrapped
    peer = python and subprocess.Popen(
        [python, "-c", PEER % STEPS], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    for _ in range(REPETITIONS):
        found["step"].append(time_steps(env))
        if peer:
            peer.stdin.write("\n")
            peer.stdin.flush()
            # between the lines that JSBSim prints
            line = next(line for line in peer.stdout if line.startswith("seconds"))
            found["peer"].append(float(line.split()[1]))
        found["pitch"].append(time_steps(pitch))
        found["frames"].append(time_plain_steps())
        found["ours"].append(time_our_resets())
        found["plain"].append(time_resets(plain))
        found["fly"].append(time_diagram())
        found["loop"].append(time_loop())
    if peer:
        peer.stdin.close()
        peer.wait()
        name = "gymnasium-jsbsim 0.1.1"
        row("environment: a step of 12 frames", name, found["step"], found["peer"], "us")
    what = "PitchHold-v1: a step of 12 frames"
    row(what, "plain loop", found["pitch"], found["frames"], "us", 2.5, "jsbsim")
    what = "reset: load, initialise and trim"
    row(what, "plain loop", found["ours"], found["plain"], "ms", 2.0, "jsbsim")
    row(
        "Aircraft and PitchHold, fly",
        "plain loop",
        found["fly"],
        found["loop"],
        "us",
        2.2,
        "jsbsim",
    )


if __name__ == "__main__":
    print(HEADER)
    rows(*sys.argv[1:])
