"""Cost of linear models: algebraic and flown, beside ``jsbsim.FGLinearization``.

    python benchmarks/linear_model.py

Each is made in a fresh process, in turn, and its processor time is taken there, without loading and
trimming the aircraft that is linearised: FGLinearization stops the clock of the aircraft for good,
and ends the process for models without engines. The flown model trims nine aircraft of its own.
Targets are in s: 0.05 for the algebraic model and 1 for the flown one (Short_S23, with four piston
engines that settle in each trim: 5).
"""

import subprocess
import sys
import time
import warnings

from report import HEADER, row

REPETITIONS = 3

# altitude in ft, KCAS, gear; whether the peer is measured: it takes half a minute with a propeller
CASES = {
    "737": (5000, 260, 0.0, True),
    "global5000": (5000, 241, 0.0, True),
    "c172p": (5000, 89, None, True),
    "Short_S23": (2000, 130, None, False),
}


def measured(name, way):
    """Processor time of one linear model, s."""
    import jsbsim

    from pathsim_jsbsim_blocks import Aircraft

    altitude, speed, gear, _ = CASES[name]
    plane = Aircraft(name, altitude=altitude, speed=speed, gear=gear)
    start = time.process_time()
    if way == "FGLinearization":
        jsbsim.FGLinearization(plane.fdm)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            plane.linear_model(way)
    return time.process_time() - start


def in_a_fresh_process(name, way):
    done = subprocess.run(
        [sys.executable, __file__, name, way],
        check=True,
        text=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    return float(done.stderr.split()[-1])


def rows():
    for name, (_, _, _, with_peer) in CASES.items():
        repetitions = 1 if name == "c172p" else REPETITIONS
        ways = ["algebraic", "flown"] + ["FGLinearization"] * with_peer
        times = [{w: in_a_fresh_process(name, w) for w in ways} for _ in range(repetitions)]
        taken = {way: [t[way] for t in times] for way in ways}
        peer = "FGLinearization" if with_peer else "flown"
        for way in ("algebraic", "flown")[: 2 if with_peer else 1]:
            what = f"{way} linear model, {name}"
            row(what, peer, taken[way], taken[peer], "s", package="jsbsim" if with_peer else None)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(measured(*sys.argv[1:]), file=sys.stderr)
    else:
        print(HEADER)
        rows()
