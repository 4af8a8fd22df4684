"""Small PathSim scripts as a stranger may write them, and what an export must make of each.

"equal": it becomes a model that flies as the script does. "refused": it need not, but a model that
is written flies as the script does.
"""

import re
from pathlib import Path

from scripts_of_tests import LOOP

TAILS = {
    "SRC": """
scope = Scope()
sim = Simulation([src, scope], [Connection(src, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
    "AMP": """
src, scope = Source(np.sin), Scope()
sim = Simulation([src, amp, scope], [Connection(src, amp), Connection(amp, scope)], dt=0.05, log=False)
sim.run(0.5)
""",
}

TEXT = (Path(__file__).parents[1] / "data" / "strangers.txt").read_text(encoding="utf-8")
SCRIPTS = {
    name: (re.sub("^LOOP\n", LOOP, source) + TAILS.get(tail, ""), verdict)
    for name, verdict, tail, source in re.findall(
        r"^## (.+) -> (\w+)(?: \+(\w+))?\n((?:(?!## ).*\n)*)", TEXT, re.M
    )
}
