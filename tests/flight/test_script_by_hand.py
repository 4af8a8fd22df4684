"""A JSBSim script and the diagram that rebuilds it, as docs/jsbsim-scripts.md describes."""

import math
import re
from pathlib import Path

import numpy as np
from pathsim.blocks import Source
from plain_jsbsim import flown_script
from plane_diagram import diagram

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


def test_the_rudder_kick_is_jsbsims_own_script():
    rows = flown_script("scripts/rudder_kick.xml", [*PROPERTIES.values(), *COMMANDS], 15.0)
    # the script trims in its first step
    states, commands = np.hsplit(rows[1:], [len(PROPERTIES)])
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
    # the script ends with its last row, which no event moves
    rows = flown_script("scripts/c1721.xml", [*outputs, *inputs], 60.0)[:-1]
    n = len(rows) - 1
    assert n > 1000

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
    sim, scope = diagram(plane, outputs, dict(zip(inputs, sources, strict=True)), inputs=True)
    sim.run(n * T)
    flown = scope.read()[1].T[: n + 1]
    # row n holds the command of the step before it
    np.testing.assert_allclose(flown[:-1, len(outputs) :], rows[1:, len(outputs) :], atol=1e-12)
    away = np.abs(flown[1:] - rows[1:]).max(axis=0)[: len(outputs)]
    assert (away < list(outputs.values())).all(), dict(zip(outputs, away, strict=True))
