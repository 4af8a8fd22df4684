"""Flights of JSBSim's scripts and reset files by the block, to compare with plain JSBSim."""

import contextlib
import warnings
from pathlib import Path

import jsbsim
from plane_diagram import diagram

from pathsim_jsbsim_blocks import JSBSimFDM
from pathsim_jsbsim_blocks.errors import FlightError

OUTPUTS = [
    "position/h-sl-ft",
    "velocities/vt-fps",
    *(f"velocities/{axis}-fps" for axis in "uvw"),
    *(f"velocities/{axis}-rad_sec" for axis in "pqr"),
    *(f"attitude/{angle}-rad" for angle in ("phi", "theta", "psi")),
    "position/lat-geod-deg",
    "position/long-gc-deg",
    "forces/fbx-total-lbs",
    "forces/fbz-total-lbs",
    "inertia/weight-lbs",
    "fcs/elevator-cmd-norm",
    "fcs/aileron-cmd-norm",
    "fcs/rudder-cmd-norm",
    "simulation/sim-time-sec",
]

ROOT = Path(jsbsim.get_default_root_dir())


def bundled_scripts():
    files = sorted(ROOT.glob("scripts/*.xml"))
    return [p.stem for p in files if "<runscript" in p.read_text("utf-8", errors="replace")]


def bundled_reset_files():
    """Pairs of an aircraft and a reset file of its own."""
    files = sorted(ROOT.glob("aircraft/*/*.xml"))
    return [(p.parent.name, p.stem) for p in files if b"<initialize" in p.read_bytes()]


def recorded(fdm, seconds, reset=False):
    """Rows of the block's outputs at each of its steps, after a reset if so.

    A FlightError ends them.
    """
    sim, scope = diagram(fdm, OUTPUTS)
    with warnings.catch_warnings(), contextlib.suppress(FlightError):
        # some scripts end, crash or fail to trim; tests of warnings are apart
        warnings.simplefilter("ignore")
        sim.run(round(seconds / fdm.T) * fdm.T, reset=reset)
    return scope.read()[1].T.copy()


def scripted(script, **parameters):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return JSBSimFDM(script=script, output_properties=OUTPUTS, **parameters)
