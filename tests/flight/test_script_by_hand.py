"""A JSBSim script and the diagram that rebuilds it, as docs/jsbsim-scripts.md describes."""

import math
import re
from pathlib import Path

import jsbsim
import numpy as np
import pytest
from models_from_outside import BUNDLED, changed
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import JSBSimFDM, TrimCondition

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
    root = changed(tmp_path_factory.mktemp("jsbsim"), "737", ("<input port.*?/>", ""))
    fdm = jsbsim.FGFDMExec(root)
    fdm.set_debug_level(0)
    assert fdm.load_script(str(BUNDLED / "scripts/rudder_kick.xml"))
    assert fdm.run_ic()
    states, commands = [], []
    while fdm.get_sim_time() < 15.0 and fdm.run():
        states.append([fdm[name] for name in PROPERTIES.values()])
        commands.append([fdm[name] for name in COMMANDS])
    return np.array(states), np.array(commands)


def test_the_rudder_kick_is_jsbsims_own_script(script):
    states, commands = script
    *_, code = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)
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


def test_an_aircraft_at_rest_moves_its_controls_as_jsbsims_c1721_does():
    T = 0.008333
    inputs = ["fcs/aileron-cmd-norm", "fcs/rudder-cmd-norm", "fcs/elevator-cmd-norm"]
    outputs = {  # and how near: the springs of the gear make more of the last digit
        "fcs/left-aileron-pos-rad": 1e-12,
        "fcs/rudder-pos-rad": 1e-12,
        "fcs/elevator-pos-rad": 1e-12,
        "position/h-agl-ft": 1e-7,
        "attitude/theta-deg": 1e-7,
        "attitude/phi-deg": 1e-7,
        "attitude/psi-deg": 1e-7,
    }
    fdm = jsbsim.FGFDMExec(None)
    fdm.set_debug_level(0)
    assert fdm.load_script("scripts/c1721.xml")
    assert fdm.run_ic()
    rows, given = [], []
    while fdm.run():
        rows.append([fdm[name] for name in outputs])
        given.append([fdm[name] for name in inputs])

    def ramp(t, step, size):
        return size * min(max((t - step * T) / 0.5, 0.0), 1.0)

    def approach(t, step, size):  # FG_EXP
        return size * (1.0 - math.exp(-max(t - step * T, 0.0) / 0.5))

    # 0.25, 0.5, 1.5 and 2.5 s are reached at the end of the steps from these samples
    sources = [
        Source(lambda t: 0.25 * (t > 29.5 * T) + approach(t, 60, 0.5)),
        Source(lambda t: ramp(t, 180, 0.5)),
        Source(lambda t: ramp(t, 180, 0.25) + approach(t, 300, 0.5)),
    ]
    condition = TrimCondition(
        mode="none",
        speed=0.0,
        heading=330.0,
        engines_off="all",
        setup={
            "ic/lat-gc-deg": 47.0,
            "ic/long-gc-deg": 122.0,
            "ic/h-agl-ft": 4.4265,
            "ic/theta-deg": 0.302,
        },
    )
    plane = JSBSimFDM(
        T=T,
        input_properties=inputs,
        output_properties=list(outputs),
        aircraft_model="c172r",
        condition=condition,
    )
    states, commands = Scope(labels=list(outputs)), Scope(labels=inputs)
    sim = Simulation(
        [plane, *sources, states, commands],
        [
            *(Connection(s, plane[i], commands[i]) for i, s in enumerate(sources)),
            *(Connection(plane[i], states[i]) for i in range(len(outputs))),
        ],
        dt=T,
        log=False,
    )
    sim.run(len(rows) * T)
    n = len(rows)
    assert n > 1000
    np.testing.assert_allclose(commands.read()[1].T[:n], given, atol=1e-12)
    away = np.abs(states.read()[1].T[1 : n + 1] - rows).max(axis=0)
    assert (away < list(outputs.values())).all(), dict(zip(outputs, away, strict=True))
