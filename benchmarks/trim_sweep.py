"""The 680-point trim map of the 737: `trim_envelope`, both solvers, and the published loop.

    python benchmarks/trim_sweep.py

The peer is what JSBSim's TrimEnvelope.py does, in our own words: one FGFDMExec with the model
loaded as it is (its two sockets open), console at level 0, engines running, alpha within
[-4, 12] deg, then for each airspeed and flight path angle three initial conditions, ``run_ic`` and
a full trim; the results of those that trim are kept in a list. What it prints, a line for each
failure, is thrown away. Our function makes the same points sealed and quiet, with a row for each.

Each repetition times all in turn, the peer and one core in fresh processes; imports are not
counted. The figures are medians over the repetitions, the ratios are formed within a repetition.
Worker processes take a second or so to start and to import PathSim: "cold" includes that, "warm" is
a second sweep in the same process.

The ratio of the Newton search depends on the machine: three tenths of its time are JSBSim's (14,700
evaluations, 65 loaded models, flights from 364 trims), the rest is Python between them. Half of the
time goes into showing that 316 points do not trim.
"""

import math
import subprocess
import sys
import time

import jsbsim
from report import HEADER, row

from pathsim_jsbsim_blocks.studies import trim_envelope, trim_sweep

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
            results.append(
                (
                    fdm["velocities/vc-kts"],
                    fdm["aero/alpha-deg"],
                    gamma,
                    fdm["fcs/throttle-cmd-norm[0]"],
                )
            )
    assert len(results) == 364


def sweep(jobs):
    assert trim_envelope(jobs=jobs, progress=False).trimmed.sum() == 364


def newton(jobs):
    grid = {"altitude": 15000, "alpha_min": -4.0, "alpha_max": 12.0, "solver": "newton"}
    axes = {"speed": range(120, 460, 10), "gamma": range(-10, 10)}
    assert trim_sweep("737", {**grid, **axes}, jobs=jobs, progress=False).trimmed.sum() == 364


def import_everything():
    trim_sweep("737", {"speed": [200]}, jobs=1, progress=False)


def seconds(function, *arguments):
    start = time.perf_counter()
    function(*arguments)
    return time.perf_counter() - start


ALONE = {"published loop": (published_loop,), "one core": (sweep, 1), "Newton": (newton, 1)}


def in_a_fresh_process(name):
    done = subprocess.run(
        [sys.executable, __file__, name],
        check=True,
        text=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    return float(done.stderr)


def stop_workers():
    from joblib.externals.loky import get_reusable_executor

    get_reusable_executor().shutdown(wait=True)


def rows():
    import_everything()
    times = []
    for _ in range(REPETITIONS):
        stop_workers()
        times.append(
            {name: in_a_fresh_process(name) for name in ALONE}
            | {"two cores, cold": seconds(sweep, 2), "two cores, warm": seconds(sweep, 2)}
            | {"Newton, two cores": seconds(newton, 2)}
        )
    loop, one, search, cold, warm, searches = ([t[name] for t in times] for name in times[0])
    row("680-point trim map on one core", "published loop", one, loop, "s", 2.0, "jsbsim")
    row("the same by the Newton search", "published loop", search, loop, "s", (0.4, 0.6), "jsbsim")
    row("the same on two cores", "published loop", searches, loop, "s", 0.22, "jsbsim")
    row("680-point trim map on two cores", "one core", warm, one, "s", 1 / 1.8)
    row("the same with the workers' start", "one core", cold, one, "s")


if __name__ == "__main__":
    if len(sys.argv) > 1:
        function, *arguments = ALONE[sys.argv[1]]
        if function is not published_loop:  # the peer keeps JSBSim's own console
            import_everything()
        print(seconds(function, *arguments), file=sys.stderr)
    else:
        print(HEADER)
        rows()
