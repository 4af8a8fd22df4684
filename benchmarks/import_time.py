"""Cost of `import pathsim_jsbsim_blocks` against that of `import pathsim`.

    python benchmarks/import_time.py

Fresh interpreters in turn, A B A B ...; the ratio of each pair, and the median of the ratios. The
target is at most 1.1 of the processor time: what we add to PathSim is a tenth of it.
"""

import os
import statistics
import subprocess
import sys

PAIRS = 15


def cost(module):
    """Processor time in s of a fresh interpreter that imports a module."""
    before = os.times()
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True)
    after = os.times()
    return (after.children_user - before.children_user
            + after.children_system - before.children_system)


def main():
    cost("pathsim"), cost("pathsim_jsbsim_blocks")  # byte code and disk cache
    pairs = [(cost("pathsim_jsbsim_blocks"), cost("pathsim")) for _ in range(PAIRS)]
    ours, peer = (statistics.median(side) for side in zip(*pairs, strict=True))
    ratio = statistics.median(a / b for a, b in pairs)
    print(f"import pathsim_jsbsim_blocks {ours:.3f} s, import pathsim {peer:.3f} s, "
          f"ratio {ratio:.3f}   (target at most 1.1)")


if __name__ == "__main__":
    main()
