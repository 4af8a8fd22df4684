"""Cost of linear models: algebraic and flown, beside ``jsbsim.FGLinearization``.

    python benchmarks/linear_model.py

Each is made in a fresh process, in turn, and its processor time is taken there, with that of forked
children, without loading and trimming the aircraft that is linearised: FGLinearization stops the
clock of the aircraft for good, and ends the process for models without engines. The flown model
trims nine aircraft of its own, or one where a trim takes long.
BLAS has one thread, because idle ones would count. Each aircraft flies level where the fleet's
table has it. Targets are in s: 0.05 for the algebraic model and 1 for the flown one. Short_S23,
with four piston engines that settle in each trim, has 5 s for the flown model. FGLinearization does
not end within a minute there and is left out.
"""

import os
import subprocess
import sys
import warnings

from report import HEADER, row

REPETITIONS = 3

AIRCRAFT = ("737", "global5000", "c172p", "A320", "f16")
PEER = "FGLinearization"


def measured(name, way):
    """Processor time of one linear model, s."""
    import jsbsim

    from pathsim_jsbsim_blocks import Aircraft
    from pathsim_jsbsim_blocks.flight import level_flight

    level = level_flight(name)
    plane = Aircraft(name, condition=level.condition, create=level.create)
    start = sum(os.times()[:4])
    if way == PEER:
        jsbsim.FGLinearization(plane.fdm)
    else:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            plane.linear_model(way)
    return sum(os.times()[:4]) - start


def in_a_fresh_process(name, way):
    done = subprocess.run(
        [sys.executable, __file__, name, way],
        check=True,
        text=True,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    return float(done.stderr.split()[-1])


def rows():
    for name in AIRCRAFT:
        ways = ("algebraic", "flown", PEER)
        times = [{way: in_a_fresh_process(name, way) for way in ways} for _ in range(REPETITIONS)]
        taken = {way: [t[way] for t in times] for way in ways}
        for way in ways[:-1]:
            row(f"{way} linear model, {name}", PEER, taken[way], taken[PEER], "s", package="jsbsim")
    for way, target in (("algebraic", 0.05), ("flown", 5.0)):
        taken = [in_a_fresh_process("Short_S23", way) for _ in range(REPETITIONS)]
        row(f"{way} linear model, Short_S23", "the target", taken, [target] * REPETITIONS, "s", 1.0)


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(measured(*sys.argv[1:]), file=sys.stderr)
    else:
        print(HEADER)
        rows()
