"""Cost of `import pathsim_jsbsim_blocks` against that of `import pathsim`.

    python benchmarks/import_time.py

Fresh interpreters in turn, A B A B ...; the ratio of each pair, and the median of the ratios. The
target is at most 1.05 of the processor time. Byte code is kept as in an installed package, in a
separate folder, regardless of the environment.
"""

import os
import subprocess
import sys
import tempfile

from report import HEADER, row

PAIRS = 15


def cost(module, byte_code):
    """Processor time in s of a fresh interpreter that imports a module."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": byte_code}
    before = os.times()
    subprocess.run([sys.executable, "-c", f"import {module}"], check=True, env=environment)
    after = os.times()
    return (
        after.children_user - before.children_user + after.children_system - before.children_system
    )


def rows():
    with tempfile.TemporaryDirectory() as byte_code:
        cost("pathsim", byte_code), cost("pathsim_jsbsim_blocks", byte_code)  # and the disk's cache
        pairs = [
            (cost("pathsim_jsbsim_blocks", byte_code), cost("pathsim", byte_code))
            for _ in range(PAIRS)
        ]
    row(
        "import of the package, processor time",
        "import pathsim",
        *zip(*pairs, strict=True),
        "s",
        1.05,
    )


if __name__ == "__main__":
    print(HEADER)
    rows()
