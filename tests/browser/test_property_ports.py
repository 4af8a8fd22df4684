"""Further ports of an `Aircraft` in PathView: drawn, wired and flown; kept when it saves."""

import json

import numpy as np
import pytest

from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.pathview import export_script

SCRIPT = """
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource
from pathsim_jsbsim_blocks import Aircraft

DURATION = 2.0
plane = Aircraft("737", altitude=10000.0, speed=250.0, gear=0.0,
                 input_properties=["flaps", "throttle[1]"],
                 output_properties=["flaps", "propulsion/engine[1]/thrust-lbs"])
flaps = StepSource(0.4, 0.5)
cut = StepSource(-0.2, 0.5)
scope = Scope(labels=["flaps [-]", "thrust [lbf]", "roll angle [deg]"])
sim = Simulation(
    [plane, flaps, cut, scope],
    [Connection(flaps, plane["flaps"]), Connection(cut, plane["throttle[1]"]),
     Connection(plane["flaps"], scope[0]),
     Connection(plane["propulsion/engine[1]/thrust-lbs"], scope[1]),
     Connection(plane["phi"], scope[2])],
    dt=1 / 120, log=False)
if __name__ == "__main__":
    sim.run(DURATION)
"""


@pytest.mark.long
def test_further_ports_are_drawn_wired_and_flown(tmp_path, models, editor):
    script = tmp_path / "further.py"
    script.write_text(SCRIPT)
    models["further.pvm"] = json.loads(export_script(script).read_text())
    editor.open("further.pvm")
    (_, shown, ports) = next(b for b in editor.blocks() if b[0] == "plane")
    assert ports == 9 + 24
    names = shown.splitlines()[-33:]
    assert (names[7:9], names[-2:]) == (["flaps", "throttle[1]"], ["flaps", "thrust-lbs"])
    assert editor.run() == "Simulation completed successfully"
    assert editor.complaints() == []
    ((_, signals),) = editor.runs[-1].values()
    diagram = load_diagram(str(script))
    diagram.sim.run(diagram.DURATION)
    _, expected = diagram.scope.read()
    assert np.array_equal(np.array(signals)[:, : expected.shape[1]], expected)
    assert "Connection(plane[23], scope[1])" in editor.python()
    assert not editor.errors
