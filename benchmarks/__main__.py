"""All benchmarks in one table: python benchmarks

Each row names ours, a peer measured in turn with it in the same run, and the ratio of the two;
below 1 ours takes less. "<=" is the target that the ratio has. Times vary from machine to machine:
the ratios, medians over repetitions, are what to quote.
"""

import air_data
import autopilot
import fdm_block
import import_time
import trim_sweep
from report import HEADER

print(HEADER)
for benchmark in (fdm_block, autopilot, air_data, trim_sweep, import_time):
    benchmark.rows()
