"""Plain JSBSim loops, written without this package: what the blocks are compared with."""

import os

import jsbsim
import numpy as np

# aircraft: (altitude ft, speed KCAS, inputs that a random test may move)
FLIGHTS = {
    "c172p": (5000.0, 90.0),
    "c172x": (5000.0, 90.0),
    "737": (10000.0, 280.0),
    "global5000": (15000.0, 250.0),
    "A4": (10000.0, 300.0),
    "f16": (10000.0, 350.0),
}


# the integrators that this package calls precise
PRECISE = {
    "simulation/integrator/rate/rotational": 4,
    "simulation/integrator/rate/translational": 4,
    "simulation/integrator/position/rotational": 7,
    "simulation/integrator/position/translational": 4,
}


def open_fdm(aircraft, dt, setup=None, root=None):
    """A loaded model that opens no socket and writes no file."""
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(root)
    fdm.disable_input()
    fdm.disable_output()
    fdm.set_output_path(os.path.join(os.devnull, "none"))
    fdm.set_dt(dt)
    fdm.load_model(aircraft)
    fdm.disable_output()
    for name, value in (setup or {}).items():
        fdm[name] = value
    return fdm


def trimmed(aircraft, altitude, speed, dt=1 / 120, gamma=0.0, heading=0.0, setup=None):
    """A trimmed model, as the published examples do it."""
    fdm = open_fdm(aircraft, dt, setup)
    fdm["propulsion/set-running"] = -1
    if heading:
        fdm["ic/psi-true-deg"] = heading
    fdm["ic/h-sl-ft"] = altitude
    fdm["ic/vc-kts"] = speed
    fdm["ic/gamma-deg"] = gamma
    fdm.run_ic()
    fdm["propulsion/set-running"] = -1
    fdm["simulation/do_simple_trim"] = 1
    return fdm


def fly(fdm, inputs, u, outputs, substeps=1):
    """Write u[k], run, read y[k+1]; returns y of shape (len(u) + 1, len(outputs))."""
    y = [[fdm[name] for name in outputs]]
    for row in np.asarray(u, dtype=float).tolist():
        for name, value in zip(inputs, row, strict=True):
            fdm[name] = value
        for _ in range(substeps):
            fdm.run()
        y.append([fdm[name] for name in outputs])
    return np.array(y)


def flown_script(script, outputs, seconds, trims=True):
    """Rows of JSBSim's own flight of a script, the start first, until its end or an exception.

    ``trims`` adds the trim that a reset file asks for, as JSBSim's command line does.
    """
    jsbsim.FGJSBBase().debug_lvl = 0
    fdm = jsbsim.FGFDMExec(None)
    fdm.disable_output()
    fdm.disable_input()
    fdm.set_output_path(os.path.join(os.devnull, "none"))
    assert fdm.load_script(script)
    fdm.disable_output()
    return rows_from_start(fdm, outputs, seconds, trims)


def flown_reset_file(aircraft, file, outputs, seconds, dt=1 / 120):
    """Rows of JSBSim's own flight from a reset file, with the trim that the file asks for."""
    fdm = open_fdm(aircraft, dt)
    assert fdm.load_ic(file, True)
    return rows_from_start(fdm, outputs, seconds, True)


def rows_from_start(fdm, outputs, seconds, trims):
    fdm.run_ic()
    asked = fdm.get_ic().trim_requested()
    if trims and asked != jsbsim.TrimMode.NONE:
        jsbsim.FGTrim(fdm, asked).do_trim()
    rows = [[fdm[name] for name in outputs]]
    for _ in range(round(seconds / fdm.get_delta_t())):
        going = fdm.run()
        rows.append([fdm[name] for name in outputs])
        if not going:
            break
    return np.array(rows)
