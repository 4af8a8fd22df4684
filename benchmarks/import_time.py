"""Cost of importing an aircraft, and of the command's help, against that of `import pathsim`.

    python benchmarks/import_time.py

Fresh interpreters in turn, A B C A B C ...; their processor time. Byte code is kept as in an
installed package, in a separate folder, regardless of the environment.
"""

import os
import subprocess
import sys
import tempfile

from report import HEADER, row

REPETITIONS = 15
PEER = "import pathsim"
# what, code, target
OURS = (
    ("import Aircraft, processor time", "from pathsim_jsbsim_blocks import Aircraft", 1.05),
    (
        "pathsim-jsbsim --help, processor time",
        "from pathsim_jsbsim_blocks.cli import main; main(['--help'])",
        0.30,
    ),
)


def cost(code, byte_code):
    """Processor time in s of a fresh interpreter that runs some code."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "", "PYTHONPYCACHEPREFIX": byte_code}
    before = os.times()
    subprocess.run(
        [sys.executable, "-c", code], check=True, env=environment, stdout=subprocess.DEVNULL
    )
    after = os.times()
    return (
        after.children_user - before.children_user + after.children_system - before.children_system
    )


def rows():
    with tempfile.TemporaryDirectory() as byte_code:
        codes = [PEER, *(code for _, code, _ in OURS)]
        for code in codes:  # fill both caches: byte code and the disk's
            cost(code, byte_code)
        times = [{code: cost(code, byte_code) for code in codes} for _ in range(REPETITIONS)]
    for what, code, most in OURS:
        row(what, PEER, [t[code] for t in times], [t[PEER] for t in times], "s", most, "pathsim")


if __name__ == "__main__":
    print(HEADER)
    rows()
