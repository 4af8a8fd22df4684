"""Air data: this package against ambiance, fluids and pathsim-flight, side by side in one run.

    python benchmarks/air_data.py

Ours and the peer's are measured in turn, several times.
"""

import time

import ambiance
import numpy as np
import pathsim_flight
from fluids.atmosphere import ATMOSPHERE_1976
from report import HEADER, row

import pathsim_jsbsim_blocks
from pathsim_jsbsim_blocks.air import isa

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


def compare(what, peer, functions, unit="us", calls=2000, per_call=1, faster=None):
    """A row for two functions timed in turn; ``faster`` is how many times ours should be."""
    samples = [[], []]
    for _ in range(15 if calls > 1 else 5):
        for function, times in zip(functions, samples, strict=True):
            start = time.perf_counter()
            for _ in range(calls):
                function()
            times.append((time.perf_counter() - start) / (calls * per_call))
    row(what, peer, *samples, unit, faster and 1 / faster, peer.partition(",")[0])


def rows():
    million = "ISA, 10^6 altitudes: p, rho, T, a"
    compare(
        million,
        "ambiance",
        [lambda: four(isa(HEIGHTS)), lambda: four(ambiance.Atmosphere(HEIGHTS))],
        "ms",
        1,
        faster=5,
    )
    compare(
        million,
        "fluids, loop",
        [lambda: four(isa(HEIGHTS)), lambda: [four_of_fluids(h) for h in HEIGHTS.tolist()]],
        "ms",
        1,
        faster=30,
    )
    compare(
        "ISA, one altitude: isa(h), p, rho, T, a",
        "fluids",
        [
            lambda: [four(isa(h)) for h in IN_EACH_LAYER],
            lambda: [four_of_fluids(h) for h in IN_EACH_LAYER],
        ],
        per_call=7,
        faster=1,
    )
    ours, theirs = pathsim_jsbsim_blocks.ISAtmosphere(), pathsim_flight.ISAtmosphere()
    compare(
        "ISA, one altitude: ISAtmosphere._eval(h)",
        "pathsim-flight",
        [
            lambda: [ours._eval(h) for h in IN_EACH_LAYER],
            lambda: [theirs._eval(h) for h in IN_EACH_LAYER],
        ],
        per_call=7,
        faster=2,
    )
    compare("ISAtmosphere block update", "pathsim-flight", updates("ISAtmosphere", 5000.0))
    compare("CAStoTAS block update", "pathsim-flight", updates("CAStoTAS", 120.0, 5000.0), faster=4)
    compare("CAStoMach block update", "pathsim-flight", updates("CAStoMach", 120.0, 5000.0))
    compare("CAStoEAS block update", "pathsim-flight", updates("CAStoEAS", 120.0, 5000.0))
    compare("EAStoTAS block update", "pathsim-flight", updates("EAStoTAS", 120.0, 5000.0))
    compare("TAStoCAS block update", "pathsim-flight", updates("TAStoCAS", 150.0, 5000.0))
    compare("MachtoCAS block update", "pathsim-flight", updates("MachtoCAS", 0.5, 5000.0))


if __name__ == "__main__":
    print(HEADER)
    rows()
