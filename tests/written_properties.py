"""Every writable property of a model gets odd values: which of them end the process, or never end.

The values are written before the model is initialised, after the trim and in flight, in a process
of its own. It says what it is about to write, so that its last word names what ended it; another
process goes on with the next property.
"""

import contextlib
import random
import re
import signal
import subprocess
import sys
from pathlib import Path

VALUES = (0.0, 1.0, 2.0, -1.0, 99.0)
LONGEST = 60  # s for one value


def deaths(aircraft, pattern=""):
    """What ends the process, and how, among the properties that a pattern matches."""
    found, start = [], 0
    while True:
        worker = subprocess.run(
            [sys.executable, Path(__file__), aircraft, pattern, str(start)],
            capture_output=True,
            text=True,
        )
        *said, last = worker.stdout.splitlines() or [""]
        if last == "done":
            assert len(said) > 2 * len(VALUES)
            return found
        found.append(f"{last}: {worker.returncode} {worker.stderr[-300:]}")
        assert said, found
        start = int(last.split()[0]) + 1


def write_all(aircraft, pattern, start):
    from fleet_conditions import FLYING
    from how_many import bounded
    from jsbsim import BaseError

    from pathsim_jsbsim_blocks import BlocksError, TrimCondition
    from pathsim_jsbsim_blocks.flight import Airframe, trim

    altitude, speed, gear, _ = FLYING.get(aircraft, (5000, 150, None, ()))
    missing = FLYING.get(aircraft, FLYING["fokker100"])[3]
    create = {n: 0.0 for n in missing if n.startswith("/") or aircraft in FLYING}
    at = {"altitude": altitude, "speed": speed, "gear": gear}
    mode = "full" if aircraft in FLYING else "none"

    def attempt(airframe, said, action, *args, **options):
        print(*said)
        with contextlib.suppress(BlocksError, BaseError):
            action(airframe, *args, **options)
            for _ in range(3):
                airframe.fdm.run()

    def wire(airframe, name, value):
        airframe.writer(name)(value)

    first = Airframe(aircraft, create=create)
    writable = [n for n in first.property_names() if first.has(n) and "w" in first.access(n)]
    names = [n for n in writable if re.match(pattern, n)]
    if not pattern:  # of all, a sample
        names = random.Random(52).sample(names, len(names) // bounded(4, 1))
    for i, name in [*enumerate(names)][start:]:
        before, after = Airframe(aircraft, create=create), Airframe(aircraft, create=create)
        attempt(after, (i, name), trim, TrimCondition(**at, mode=mode), hint=False)
        for value in VALUES:
            signal.alarm(LONGEST)
            condition = TrimCondition(**at, mode="none", setup={name: value})
            attempt(before, (i, name, value, "before the start"), trim, condition, hint=False)
            attempt(after, (i, name, value, "after the trim"), Airframe.write, {name: value})
            attempt(after, (i, name, value, "in flight"), wire, name, value)
    print("done")


if __name__ == "__main__":
    sys.stdout.reconfigure(line_buffering=True)
    write_all(sys.argv[1], sys.argv[2], int(sys.argv[3]))
