"""Each fault of the published examples, rebuilt the naive way, beside the diagram that is right.

The naive loops are written with plain JSBSim and PathSim after the description of the notebooks.
The numbers are those of the table in docs/published-examples.md.
"""

import json
import math
import shutil
import socket
import subprocess
import sys
from pathlib import Path

import jsbsim
import numpy as np
import pytest
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Constant, Function, Integrator, Scope, StepSource
from plain_jsbsim import open_fdm, trimmed

from pathsim_jsbsim_blocks import Aircraft
from pathsim_jsbsim_blocks.air import cas_to_tas, isa
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.flight.airframe import Airframe
from pathsim_jsbsim_blocks.plots import signal

TESTS = Path(__file__).parents[1]
INSTALLED = Path(jsbsim.get_default_root_dir())
ALPHA_LIMITS = {"aero/alpha-min-rad": math.radians(-4.0), "aero/alpha-max-rad": math.radians(12.0)}


def pitch_flown(gain, signs="+-", duration=2.0, labels=("command", "error")):
    """A pitch hold of PathSim's blocks on the c172p, the error as it was added; its scopes."""
    plane, reference, error = (
        Aircraft("c172p", altitude=5000, speed=90),
        Constant(3.0),
        Adder(signs),
    )
    controller, theta, control = Amplifier(gain), Scope(), Scope(labels=[*labels])
    sim = Simulation(
        [plane, reference, error, controller, control, theta],
        [
            Connection(reference, error[0], control[1]),
            Connection(plane["theta"], error[1], theta),
            Connection(error, controller, control[0]),
            Connection(controller, plane["elevator"]),
        ],
        dt=1 / 120,
        log=False,
    )
    sim.run(duration)
    return theta, control


def test_a_pitch_hold_with_the_wrong_sign_never_holds_3_deg():
    # positive elevator is nose down: the published sign drives the aircraft away from 3 deg;
    # the other sign raises it from the trimmed 1.2863
    wrong, right = (pitch_flown(gain, duration=8.0)[0].read() for gain in (+0.01, -0.01))
    assert wrong[1][0][wrong[0] > 4.0].max() < 1.0
    assert right[1][0][right[0] > 4.0].min() > 1.2865
    diagram = load_diagram("pitch_hold")
    diagram.sim.run(8.0)
    time, theta = signal(diagram.pitch, "pitch angle")
    assert np.abs(theta[time > 4.0] - 3.0).max() < 0.05


def naive_doublet(duration, *extra):
    """A Function that steps JSBSim whenever PathSim evaluates it; returns its frames."""
    fdm = open_fdm("c172p", 1 / 120)
    fdm.run_ic()
    steps = []

    def step(elevator):
        fdm["fcs/elevator-cmd-norm"] = elevator
        fdm.run()
        steps.append(1)
        return fdm["aero/alpha-deg"]

    pulse = StepSource(amplitude=[-0.1, 0.0, 0.1, 0.0], tau=[10.0, 11.0, 12.0, 13.0])
    aircraft, scope = Function(step), Scope()
    sim = Simulation(
        [pulse, aircraft, scope, *extra],
        [Connection(pulse, aircraft), Connection(aircraft, scope)]
        + [Connection(aircraft, block) for block in extra],
        dt=1 / 120,
        log=False,
    )
    sim._update(0.0)
    steps.clear()
    sim.run(duration)
    return len(steps)


def test_an_aircraft_in_a_function_runs_ahead_of_the_clock():
    # once more for each of the four events of the pulse, and once for the run itself
    assert naive_doublet(40.0) == 4805
    # with an integrator in the diagram it flies two to three times real time
    assert 2 * 1680 <= naive_doublet(14.0, Integrator()) <= 3.1 * 1680
    diagram = load_diagram("elevator_doublet")
    diagram.sim.run(14.0)
    assert round(diagram.aircraft.fdm.get_sim_time() * 120) == 1680


def test_the_published_scope_of_the_oscillator_names_the_velocity_position():
    velocity, position, force = Integrator(), Integrator(1.0), Amplifier(-1.0)
    scope = Scope(labels=["position x", "velocity v"])
    wires = [
        Connection(velocity, position, scope[0]),
        Connection(position, force, scope[1]),
        Connection(force, velocity),
    ]
    Simulation([velocity, position, force, scope], wires, dt=0.01, log=False).run(3.0)
    time, _ = scope.read()
    # x'' = -x from x = 1: x is cos t, v is -sin t
    np.testing.assert_allclose(signal(scope, "position x")[1], -np.sin(time), atol=1e-4)
    diagram = load_diagram("damped_oscillator")
    diagram.sim.run(0.1)
    assert signal(diagram.scope, "position x")[1][0] == 1.0
    assert signal(diagram.scope, "velocity v")[1][0] == 0.0


def test_the_published_scope_of_the_pitch_hold_names_the_error_a_command():
    theta, control = pitch_flown(1.0 / 90.0, "+--", labels=("elevator_cmd", "pitch_error"))
    assert (signal(control, "pitch_error")[1] == 3.0).all()
    command = signal(control, "elevator_cmd")[1]
    assert (command == 3.0 - theta.read()[1][0]).all()
    assert command[0] > 1.7  # deg; a command of the elevator is at most 1


def test_the_table_of_true_airspeeds_needs_the_formula_of_cas():
    knot, height = 1852 / 3600, 40_000 * 0.3048
    # density ratio of the standard atmosphere at 12,192 m of geometric altitude
    sigma = isa(height).density / isa(0.0).density
    assert 120 / math.sqrt(sigma) == pytest.approx(241.4, abs=0.05)
    assert cas_to_tas(120 * knot, isa(height)) / knot == pytest.approx(237.3, abs=0.05)


def copied(aircraft, folder, *changes):
    """A JSBSim root of one's own with a copy of one model, changed."""
    root = folder / "root"
    shutil.copytree(INSTALLED / "aircraft" / aircraft, root / "aircraft" / aircraft)
    for part in ("engine", "systems"):
        (root / part).symlink_to(INSTALLED / part)
    model = root / "aircraft" / aircraft / f"{aircraft}.xml"
    text = model.read_text(encoding="utf-8")
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    model.write_text(text, encoding="utf-8")
    return root, model


def test_a_cg_edited_after_loading_is_flown_by_the_next_case(tmp_path):
    root, model = copied("c172p", tmp_path)
    text = model.read_text(encoding="utf-8")
    assert text.count("<x> 41 </x>") == 1
    naive = []
    for x in (39.0, 43.0):
        fdm = jsbsim.FGFDMExec(str(root))
        fdm.load_model("c172p")
        # too late: the model is loaded
        model.write_text(text.replace("<x> 41 </x>", f"<x> {x} </x>"), encoding="utf-8")
        fdm.run_ic()
        naive.append(fdm["inertia/cg-x-in"])
    # and the shared file has been modified
    assert model.read_text(encoding="utf-8") != text
    model.write_text(text, encoding="utf-8")
    ours, before = [], (model.stat().st_mtime_ns, sorted(root.rglob("*")))
    for x in (39.0, 41.0, 43.0):
        airframe = Airframe("c172p", root=str(root), empty_cg_x=x)
        airframe.run_ic()
        ours.append(airframe.fdm["inertia/cg-x-in"])
    assert (model.stat().st_mtime_ns, sorted(root.rglob("*"))) == before
    # the first case flew with the original CG, the second with that of the first
    assert naive == pytest.approx([ours[1], ours[0]], abs=1e-9)
    assert ours[0] < ours[1] < ours[2]


SOCKETS = """
import json, psutil, sys
kind, root = sys.argv[1:]
if kind == "plain":
    import jsbsim
    fdm = jsbsim.FGFDMExec(root)
    fdm.load_model("737")
    fdm.run_ic()
else:
    from pathsim_jsbsim_blocks.flight.airframe import Airframe
    airframe = Airframe("737", root=root)
    airframe.run_ic()
print(json.dumps(sorted({c.laddr.port for c in psutil.Process().net_connections(kind="inet")})))
"""


def test_the_737_opens_a_port_in_plain_jsbsim(tmp_path):
    # another process may hold the ports that the model asks for, so a copy asks for free ones
    with socket.create_server(("", 0)) as one, socket.create_server(("", 0)) as other:
        ports = [server.getsockname()[1] for server in (one, other)]
    root, _ = copied(
        "737",
        tmp_path,
        ('port="5137"', f'port="{ports[0]}"'),
        ('port="5139"', f'port="{ports[1]}"'),
    )
    found = {}
    for kind in ("plain", "ours"):
        done = subprocess.run(
            [sys.executable, "-c", SOCKETS, kind, str(root)],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert done.returncode == 0, done.stderr
        found[kind] = json.loads(done.stdout.splitlines()[-1])
    assert found == {"plain": sorted(ports), "ours": []}


def test_the_rudder_kick_overruns_its_commands():
    fdm = trimmed("737", 1000.0, 200.0, setup=ALPHA_LIMITS)
    for _ in range(2400):
        # counts the instant 0 and the instant 3 s: 361 increments of 1/360
        if fdm.get_sim_time() <= 3.0:
            fdm["fcs/aileron-cmd-norm"] += 1.0 / 360
            fdm["fcs/rudder-cmd-norm"] += 0.92 / 360
        fdm.run()
    naive = [fdm[name] for name in ("fcs/aileron-cmd-norm", "fcs/rudder-cmd-norm")]
    assert naive == pytest.approx([1.0028, 0.9226], abs=5e-5)
    end = [fdm["attitude/phi-deg"], fdm["attitude/psi-deg"]]
    assert end == pytest.approx([17.9, 338.6], abs=0.05)
    diagram = load_diagram("rudder_kick")
    diagram.sim.run(20.0)
    ours = [
        signal(diagram.commands, label)[1].max() for label in ("aileron command", "rudder command")
    ]
    assert ours == pytest.approx([1.0, 0.92], abs=1e-12)
    end = [diagram.aircraft.outputs[port] for port in ("phi", "psi")]
    assert end == pytest.approx([18.7, 339.5], abs=0.05)
