"""A JSBSim script and the diagram that rebuilds it, as docs/jsbsim-scripts.md describes."""

import re
from pathlib import Path

import jsbsim
import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, RampSource

PAGE = Path(__file__).parents[2] / "docs" / "jsbsim-scripts.md"
PROPERTIES = {
    "h": "position/h-sl-ft",
    "vc": "velocities/vc-kts",
    "alpha": "aero/alpha-deg",
    "beta": "aero/beta-deg",
    "theta": "attitude/theta-deg",
    "phi": "attitude/phi-deg",
    "psi": "attitude/psi-deg",
}
COMMANDS = ["fcs/rudder-cmd-norm", "fcs/aileron-cmd-norm"]


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    """What JSBSim's own run of its rudder_kick shows after each step, without the 737's port."""
    installed = Path(jsbsim.get_default_root_dir())
    root = tmp_path_factory.mktemp("jsbsim")
    for folder in ("aircraft/737", "scripts"):
        (root / folder).mkdir(parents=True)
    for folder in ("engine", "systems"):
        (root / folder).symlink_to(installed / folder)
    for file in (installed / "aircraft/737").iterdir():
        if file.is_file():
            text = file.read_text(encoding="utf-8", errors="surrogateescape")
            text = re.sub(r"<input port.*?/>", "", text)
            (root / "aircraft/737" / file.name).write_text(
                text, encoding="utf-8", errors="surrogateescape"
            )
    fdm = jsbsim.FGFDMExec(str(root))
    fdm.set_debug_level(0)
    assert fdm.load_script(str(installed / "scripts/rudder_kick.xml"))
    assert fdm.run_ic()
    states, commands = [], []
    while fdm.get_sim_time() < 15.0 and fdm.run():
        states.append([fdm[name] for name in PROPERTIES.values()])
        commands.append([fdm[name] for name in COMMANDS])
    return np.array(states), np.array(commands)


def test_the_rudder_kick_is_jsbsims_own_script(script):
    states, commands = script
    [code] = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
    page = {}
    exec(compile(code, PAGE.name, "exec"), page)  # flies it
    _, flown = page["states"].read()
    # after n runs the script's row is the diagram's instant n
    n = len(states)
    away = flown.T[1 : n + 1] - states
    away[:, -1] = (away[:, -1] + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(away, 0.0, atol=1e-9)
    # row n holds the command of the step before it
    _, given = page["commands"].read()
    np.testing.assert_allclose(given.T[:n], commands, atol=1e-12)


def test_a_command_at_the_time_in_the_script_is_a_step_late(script):
    T, start = 0.008333, 13 * 0.008333
    plane = Aircraft("737", altitude=1000.0, speed=200.0, mode="full", gear=1.0, T=T)
    ramps = [RampSource(final=value, start=start, rise_time=3.0) for value in (0.92, 1.0)]
    scope = Scope(labels=["sideslip angle [deg]"])
    sim = Simulation(
        [plane, *ramps, scope],
        [
            Connection(ramps[0], plane["rudder"]),
            Connection(ramps[1], plane["aileron"]),
            Connection(plane["beta"], scope),
        ],
        dt=T,
        log=False,
    )
    sim.run(2.0)
    beta = scope.read()[1][0]
    assert abs(beta[1:] - script[0][: len(beta) - 1, 3]).max() > 0.01
