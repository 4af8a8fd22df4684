"""Two hours at 120 Hz: a 737 on autopilot in turbulence. Steps, memory and pace, hour by hour.

    python benchmarks/long_flight.py

864,000 steps; takes some minutes. The Scope samples at 1 Hz: at 120 Hz it would keep everything.
"""

import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests" / "flight"))

from report import HEADER
from test_long_and_wide import T, megabytes, mission

from pathsim_jsbsim_blocks import fly


def main():
    sim, plane, scope = mission(sampling_period=1.0)
    print(HEADER.splitlines()[0])
    fly(sim, 60.0)
    for hour in (1, 2):
        memory, start = megabytes(), time.perf_counter()
        fly(sim, 3600.0 * hour - sim.time)
        seconds = time.perf_counter() - start
        print(
            f"hour {hour}: {plane.samples} samples, {seconds:.0f} s, "
            f"memory {megabytes() - memory:+.2f} MB"
        )
    assert plane.samples == round(sim.time / T) == 864_000
    _, (h, _) = scope.read()
    print(f"altitude {h.min():.0f} to {h.max():.0f} ft")


if __name__ == "__main__":
    main()
