"""All benchmarks in one table: python benchmarks

Each row gives our time, that of a peer measured alternately in the same run, and their ratio;
below 1 ours takes less. "<=" is the target of the ratio, a star marks a ratio above it. Times vary
from machine to machine: quote the ratios, which are medians over repetitions. A range as a target
is that of the ratios on different machines: JSBSim's step is compiled, ours is Python, and
processors differ in what they gain from each. On a loaded machine, which the first line tells, no
ratio counts.
"""

import air_data
import autopilot
import batches
import environment
import fdm_block
import host
import import_time
import linear_model
import trim_sweep
from report import HEADER

print(HEADER)
for benchmark in (
    fdm_block,
    host,
    autopilot,
    environment,
    air_data,
    trim_sweep,
    linear_model,
    batches,
    import_time,
):
    benchmark.rows()
