"""Where jsbsim is not installed the package imports, and everything that does not need it works."""

import json
import subprocess
import sys

from all_holds import HOLDS
from public_blocks import BLOCKS

import pathsim_jsbsim_blocks as package

CONTROLLERS = ["DiscretePID", *HOLDS]


def run(code, *args):
    done = subprocess.run(
        [sys.executable, "-c", code, *args], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


WITHOUT = """
import inspect, json, sys
# neither found by find_spec nor imported, as if it were not installed
sys.modules["jsbsim"] = None
from pathsim import Connection, Simulation
from pathsim.blocks import Block, Scope
import pathsim_jsbsim_blocks as package

offered = {n: getattr(package, n) for n in package.__all__}
blocks = {n: o() for n, o in offered.items() if inspect.isclass(o) and issubclass(o, Block)}
for name in sys.argv[1:]:
    blocks[name].update(0.0)
kick, hold, scope = package.DoubletSource(), package.PitchHold(), Scope()
wires = [Connection(kick, hold["theta"], hold["q"]), Connection(hold["elevator"], scope)]
Simulation([kick, hold, scope], wires, dt=1 / 120, log=False).run(2.0)
print(json.dumps([sorted(blocks), sorted(offered), dir(package), float(scope.read()[1].max())]))
"""


def test_all_but_the_aircraft_is_there_and_works():
    blocks, offered, shown, moved = run(WITHOUT, *CONTROLLERS)
    absent = {"Aircraft", "JSBSimFDM", "LinearAircraft", "TrimCondition", "TrimState"}
    assert {*package.__all__} - {*offered} == {*package.__all__} - {*shown} == absent
    assert len(blocks) > 20
    assert {*offered} & {*BLOCKS} == {*blocks}
    assert moved > 0.0
