"""The 680-point trim map of the 737: `trim_envelope` on one and two cores, and the published loop.

    python benchmarks/trim_sweep.py

The peer is what JSBSim's TrimEnvelope.py does, in our own words: one FGFDMExec with the model
loaded as it is (its two sockets open), console at level 0, engines running, alpha within
[-4, 12] deg, then for each airspeed and flight path angle three initial conditions, ``run_ic`` and
a full trim; the results of those that trim are kept in a list. What it prints, a line for each
failure, is thrown away. Our function makes the same points sealed and quiet, with a row for each.

Each repetition times all in turn, the peer and one core in fresh processes; imports are not
counted. The figures are medians over the repetitions, the ratios are formed within a repetition.
Worker processes take a second or so to start and to import PathSim: "cold" includes that, "warm" is
a second sweep in the same session.
"""

import math
import os
import statistics
import subprocess
import sys
import time

import jsbsim
import pandas  # noqa: F401 (so that no sweep pays for the import)

from pathsim_jsbsim_blocks.studies import trim_envelope

REPETITIONS = 5


def published_loop():
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(None)
    fdm.load_model("737")
    fdm["propulsion/set-running"] = -1
    fdm["aero/alpha-max-rad"] = math.radians(12.0)
    fdm["aero/alpha-min-rad"] = math.radians(-4.0)
    results = []
    for speed in range(120, 460, 10):
        for gamma in range(-10, 10):
            fdm["ic/h-sl-ft"] = 15000
            fdm["ic/vc-kts"] = speed
            fdm["ic/gamma-deg"] = gamma
            fdm.run_ic()
            try:
                fdm["simulation/do_simple_trim"] = 1
            except jsbsim.TrimFailureError:
                continue
            results.append((fdm["velocities/vc-kts"], fdm["aero/alpha-deg"], gamma,
                            fdm["fcs/throttle-cmd-norm[0]"]))
    assert len(results) == 364


def sweep(jobs):
    assert trim_envelope(jobs=jobs, progress=False).trimmed.sum() == 364


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


ALONE = {"published loop": (published_loop,), "one core": (sweep, 1)}


def in_a_fresh_process(name):
    done = subprocess.run([sys.executable, __file__, name], check=True, text=True,
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    return float(done.stderr)


def stop_workers():
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True)


def main():
    times = []
    for _ in range(REPETITIONS):
        stop_workers()
        times.append({name: in_a_fresh_process(name) for name in ALONE}
                     | {"two cores, cold": seconds(sweep, 2), "two cores, warm": seconds(sweep, 2)})
    print(f"jsbsim {jsbsim.__version__}, {os.cpu_count()} cores, {REPETITIONS} repetitions")
    for name in times[0]:
        values = [t[name] for t in times]
        print(f"{name:<16}{statistics.median(values):7.2f} s  "
              f"(from {min(values):.2f} to {max(values):.2f})")
    for over, under in (("published loop", "one core"), ("one core", "two cores, cold"),
                        ("one core", "two cores, warm")):
        ratios = [t[over] / t[under] for t in times]
        print(f"{over + ' / ' + under:<27}{statistics.median(ratios):6.2f}  "
              f"(from {min(ratios):.2f} to {max(ratios):.2f})")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(seconds(*ALONE[sys.argv[1]]), file=sys.stderr)
    else:
        main()
