"""Where jsbsim is not installed the package imports, and everything that does not need it works."""

import inspect
import json
import subprocess
import sys

import pytest
from all_holds import HOLDS
from pathsim.blocks import Block

import pathsim_jsbsim_blocks as package

CONTROLLERS = ["DiscretePID", *HOLDS]


def run(code, *args):
    done = subprocess.run(
        [sys.executable, "-c", code, *args], capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def without():
    return run(
        """
import inspect, json, sys
# neither found by find_spec nor imported, as if it were not installed
sys.modules["jsbsim"] = None
from pathsim import Connection, Simulation
from pathsim.blocks import Block, Scope
import pathsim_jsbsim_blocks as package

offered = {n: getattr(package, n) for n in package.__all__}
blocks = {n: o() for n, o in offered.items() if inspect.isclass(o) and issubclass(o, Block)}

kick, hold, scope = package.DoubletSource(), package.PitchHold(), Scope()
sim = Simulation([kick, hold, scope],
                 [Connection(kick, hold["theta"], hold["q"]),
                  Connection(hold["elevator"], scope)],
                 dt=1 / 120, log=False)
sim.run(2.0)
for name in sys.argv[1:]:
    blocks[name].update(0.0)
print(json.dumps({
    "blocks": sorted(blocks), "jsbsim": "jsbsim._jsbsim" in sys.modules,
    "aircraft": [n for n in ("Aircraft", "JSBSimFDM", "TrimCondition", "TrimState")
                 if hasattr(package, n)],
    "moved": float(abs(scope.read()[1]).max())}))
""",
        *CONTROLLERS,
    )


def test_what_needs_jsbsim_is_absent(without):
    assert without["aircraft"] == []
    assert not without["jsbsim"]


def test_all_other_blocks_are_there_and_can_be_built(without):
    names = sorted(
        n
        for n in set(package.__all__) - {"Aircraft", "JSBSimFDM", "LinearAircraft"}
        if inspect.isclass(o := getattr(package, n)) and issubclass(o, Block)
    )
    assert len(names) > 20
    assert without["blocks"] == names


def test_controllers_and_a_diagram_work(without):
    assert without["moved"] > 0.0
