"""Two hours at 120 Hz: a 737 on autopilot in turbulence. Steps, memory and pace, hour by hour.

    python benchmarks/long_flight.py

864,000 steps; takes some minutes. The Scope samples at 1 Hz: at 120 Hz it would keep everything.
"""

import pathlib
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "tests"))

from test_long_and_wide import T, megabytes, mission


def main():
    sim, plane, scope = mission(sampling_period=1.0)
    sim.run(60)
    for hour in (1, 2):
        memory, start = megabytes(), time.perf_counter()
        sim.run(3600 * hour - sim.time)
        seconds = time.perf_counter() - start
        print(
            f"hour {hour}: {plane.samples} samples, {seconds:.0f} s, "
            f"memory {megabytes() - memory:+.2f} MB"
        )
    # PathSim's run may take one step more than asked for: its clock has drifted by then
    assert plane.samples == round(sim.time / T) in (864_000, 864_001)
    _, (h, _) = scope.read()
    print(f"altitude {h.min():.0f} to {h.max():.0f} ft")


if __name__ == "__main__":
    main()
