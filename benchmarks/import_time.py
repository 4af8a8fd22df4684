"""Cost of `import pathsim_jsbsim_blocks` against that of `import pathsim`.

    python benchmarks/import_time.py

Fresh interpreters in turn, A B A B ...; the ratio of each pair, and the median of the ratios. The
target is at most 1.1 of the processor time: what we add to PathSim is a tenth of it.
"""

import os
import subprocess
import sys

from report import HEADER, row

PAIRS = 15


def cost(module):
    """Processor time in s of a fresh interpreter that imports a module."""
    before = os.times()
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True)
    after = os.times()
    return (after.children_user - before.children_user
            + after.children_system - before.children_system)


def rows():
    cost("pathsim"), cost("pathsim_jsbsim_blocks")  # byte code and disk cache
    pairs = [(cost("pathsim_jsbsim_blocks"), cost("pathsim")) for _ in range(PAIRS)]
    row("import of the package, processor time", "import pathsim", *zip(*pairs, strict=True), "s",
        1.1)


if __name__ == "__main__":
    print(HEADER)
    rows()
