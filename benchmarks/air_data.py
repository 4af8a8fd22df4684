"""Air data: this package against ambiance, fluids and pathsim-flight, side by side in one run.

    python benchmarks/air_data.py

Ours and the peer's are measured in turn, several times; the table gives the medians of one call.
"""

import statistics
import time

import ambiance
import numpy as np
import pathsim_flight
from fluids.atmosphere import ATMOSPHERE_1976

import pathsim_jsbsim_blocks
from pathsim_jsbsim_blocks.atmosphere import isa

HEIGHTS = np.random.default_rng(1).uniform(-500.0, 80_000.0, 1_000_000)  # m, in no order
IN_EACH_LAYER = [5e3, 15e3, 25e3, 40e3, 49e3, 60e3, 75e3]  # m


def four(air):
    return air.pressure, air.density, air.temperature, air.speed_of_sound


def four_of_fluids(height):
    air = ATMOSPHERE_1976(height)
    return air.P, air.rho, air.T, air.v_sonic


def update(package, name, speed_or_altitude, altitude=0.0):
    block = getattr(package, name)()
    block.inputs[0] = speed_or_altitude
    block.inputs[1] = altitude
    return lambda: block.update(0.0)


def updates(name, *inputs):
    return [update(package, name, *inputs) for package in (pathsim_jsbsim_blocks, pathsim_flight)]


def medians(functions, calls):
    """Median time of one call in s, of each function."""
    samples = [[] for _ in functions]
    for _ in range(15 if calls > 1 else 5):
        for function, times in zip(functions, samples, strict=True):
            start = time.perf_counter()
            for _ in range(calls):
                function()
            times.append((time.perf_counter() - start) / calls)
    return [statistics.median(times) for times in samples]


def row(what, peer, functions, calls=2000, per_call=1, target=""):
    ours, other = (1e6 * seconds / per_call for seconds in medians(functions, calls))
    print(f"{what:40} {peer:15} {ours:12.2f} {other:12.2f} {other / ours:7.1f} {target:>7}")


def main():
    print(f"{'':40} {'peer':15} {'ours, us':>12} {'peer, us':>12} {'ratio':>7} {'target':>7}")
    million = "ISA, 10^6 altitudes: p, rho, T, a"
    row(million, "ambiance", [lambda: four(isa(HEIGHTS)),
                              lambda: four(ambiance.Atmosphere(HEIGHTS))], 1, target=5)
    row(million, "fluids, loop", [lambda: four(isa(HEIGHTS)),
                                  lambda: [four_of_fluids(h) for h in HEIGHTS.tolist()]], 1,
        target=30)
    row("ISA, one altitude: isa(h), p, rho, T, a", "fluids",
        [lambda: [four(isa(h)) for h in IN_EACH_LAYER],
         lambda: [four_of_fluids(h) for h in IN_EACH_LAYER]], per_call=7, target=1)
    ours, theirs = pathsim_jsbsim_blocks.ISAtmosphere(), pathsim_flight.ISAtmosphere()
    row("ISA, one altitude: ISAtmosphere._eval(h)", "pathsim-flight",
        [lambda: [ours._eval(h) for h in IN_EACH_LAYER],
         lambda: [theirs._eval(h) for h in IN_EACH_LAYER]], per_call=7, target=2)
    row("ISAtmosphere block update", "pathsim-flight", updates("ISAtmosphere", 5000.0))
    row("CAStoTAS block update", "pathsim-flight", updates("CAStoTAS", 120.0, 5000.0), target=4)
    row("CAStoMach block update", "pathsim-flight", updates("CAStoMach", 120.0, 5000.0))
    row("CAStoEAS block update", "pathsim-flight", updates("CAStoEAS", 120.0, 5000.0))
    row("EAStoTAS block update", "pathsim-flight", updates("EAStoTAS", 120.0, 5000.0))
    row("TAStoCAS block update", "pathsim-flight", updates("TAStoCAS", 150.0, 5000.0))
    row("MachtoCAS block update", "pathsim-flight", updates("MachtoCAS", 0.5, 5000.0))


if __name__ == "__main__":
    main()
