"""Cost of one step on autopilot: `Autopilot` in one block, against the same loops from core blocks.

    python benchmarks/autopilot.py

Then the cost of a step under `fly`: of a c172p with `PitchHold` against a hand-written JSBSim loop
with the same control law, and of the diagram autopilot_mission against `sim.run`.

One process flies the same c172p in turn under both: altitude hold over rate of climb and pitch
angle, heading hold over roll angle, autothrottle, yaw damper, 120 Hz, one Scope. The core blocks
are Adder, Amplifier, Clip, RateLimiter, AntiWindupPID, Function and a Butterworth high-pass; they
have neither set-point weights nor switches nor bumpless transfer. Both climb 100 ft and turn by
20 deg, which is checked.
"""

import math
import time

from pathsim import Connection, Simulation
from pathsim.blocks import (
    Adder,
    Amplifier,
    AntiWindupPID,
    ButterworthHighpassFilter,
    Clip,
    Constant,
    Function,
    RateLimiter,
    Scope,
)
from report import HEADER, row

from pathsim_jsbsim_blocks import Aircraft, Autopilot, PitchHold, fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.control.gain_tables import table

T = 1 / 120
DEG = 180.0 / math.pi
SECONDS = 60.0
REPETITIONS = 5
CLIMB, TURN = 100.0, 20.0  # ft, deg
SEEN = ("theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "elev_sat", "ail_sat", "thr_sat")
DRIVEN = ("elevator", "aileron", "rudder", "throttle")


def cruise():
    return Aircraft("c172p", altitude=5000.0, speed=90.0, heading=90.0)


def one_block():
    plane, autopilot, scope = cruise(), Autopilot("c172p"), Scope()
    climb, turn = Constant(CLIMB), Constant(TURN)
    sim = Simulation(
        [plane, autopilot, climb, turn, scope],
        [
            Connection(plane[SEEN], autopilot[SEEN]),
            Connection(autopilot[DRIVEN], plane[DRIVEN]),
            Connection(climb, autopilot["h_ref"]),
            Connection(turn, autopilot["psi_ref"]),
            Connection(plane["h", "psi", "vc"], scope[:3]),
        ],
        dt=T,
        log=False,
    )
    return sim, plane


def core_blocks():
    plane, scope, gains = cruise(), Scope(), table("c172p").points[0].gains
    blocks, connections = [plane, scope], [Connection(plane["h", "psi", "vc"], scope[:3])]

    def add(block, *sources):
        blocks.append(block)
        connections.extend(Connection(s, block[i]) for i, s in enumerate(sources))
        return block

    def pid(kp, ki, low, high, error, kd=0.0):
        # an integral that unwinds as fast as the sampled law's
        law = AntiWindupPID(Kp=kp, Ki=ki, Kd=kd, f_max=5.0, Ks=1.0 / kp, limits=[low, high])
        return add(Clip(low, high), add(law, error))

    y = plane.outputs
    # elevator: altitude, rate of climb, pitch angle
    h_ref, hdot_max = add(Constant(float(y["h"]) + CLIMB)), gains.altitude.hdot_max
    climb = add(
        Clip(-hdot_max, hdot_max),
        add(Amplifier(gains.altitude.Kh), add(Adder("+-"), h_ref, plane["h"])),
    )
    theta = float(y["theta"])
    pitch_up = pid(
        gains.altitude.Kp,
        gains.altitude.Ki,
        -10.0 - theta,
        15.0 - theta,
        add(Adder("+-"), climb, plane["hdot"]),
    )
    theta_cmd = add(RateLimiter(gains.pitch.ramp), pitch_up)
    theta_now = add(Adder("+-"), plane["theta"], add(Constant(theta)))
    elevator = pid(
        gains.pitch.Kp, gains.pitch.Ki, -1.0, 1.0, add(Adder("+-"), theta_cmd, theta_now)
    )
    damped = add(Adder("+-"), elevator, add(Amplifier(gains.pitch.Kr), plane["q"]))
    connections.append(
        Connection(add(Clip(-1.0, 1.0), add(Amplifier(-1.0), damped)), plane["elevator"])
    )
    # aileron: heading, roll angle
    psi_ref = add(Constant(float(y["psi"]) + TURN))
    off_course = add(
        Function(lambda e: (e + 180.0) % 360.0 - 180.0), add(Adder("+-"), psi_ref, plane["psi"])
    )
    bank = pid(gains.heading.Kp, gains.heading.Ki, -25.0, 25.0, off_course)
    phi_cmd = add(RateLimiter(gains.roll.ramp), bank)
    aileron = pid(gains.roll.Kp, gains.roll.Ki, -1.0, 1.0, add(Adder("+-"), phi_cmd, plane["phi"]))
    damped = add(Adder("+-"), aileron, add(Amplifier(gains.roll.Kr), plane["p"]))
    connections.append(Connection(add(Clip(-1.0, 1.0), damped), plane["aileron"]))
    # throttle: airspeed
    vc_cmd = add(Constant(float(y["vc"])))
    thrust = pid(
        gains.speed.Kp,
        gains.speed.Ki,
        -1.0,
        1.0,
        add(Adder("+-"), vc_cmd, plane["vc"]),
        gains.speed.Kd,
    )
    fed = add(Adder("++"), thrust, add(Amplifier(gains.speed.Kc), plane["hdot"]))
    connections.append(Connection(add(Clip(-1.0, 1.0), fed), plane["throttle"]))
    # rudder: yaw rate
    washed = add(ButterworthHighpassFilter(1 / (2 * 3.14159265 * gains.yaw.tau), 1), plane["r"])
    connections.append(
        Connection(add(Clip(-1.0, 1.0), add(Amplifier(gains.yaw.K), washed)), plane["rudder"])
    )
    return Simulation(blocks, connections, dt=T, log=False), plane


def time_flight(build):
    """Seconds per step."""
    sim, plane = build()
    start = time.perf_counter()
    sim.run(SECONDS)
    cost = (time.perf_counter() - start) / (SECONDS / T)
    assert abs(plane.outputs["h"] - 5000.0 - CLIMB) < 10.0
    assert abs(plane.outputs["psi"] - 90.0 - TURN) < 1.0
    assert abs(plane.outputs["vc"] - 90.0) < 2.0
    return cost


def time_pitch_hold():
    """Seconds per step of a diagram that holds the pitch angle at 3 deg, and where it ends."""
    plane, hold, scope = cruise(), PitchHold("c172p", theta_ref=3.0), Scope()
    sim = Simulation(
        [plane, hold, scope],
        [
            Connection(plane["theta", "q", "elev_sat"], hold["theta", "q", "elev_sat"]),
            Connection(hold["elevator"], plane["elevator"]),
            Connection(plane["theta", "alpha", "h", "vc"], scope[:4]),
        ],
        dt=T,
        log=False,
    )
    start = time.perf_counter()
    fly(sim, SECONDS)
    cost = (time.perf_counter() - start) / (SECONDS / T)
    return cost, float(plane.outputs["theta"])


def time_hand_written_loop():
    """Seconds per step of the same flight without PathSim and without our blocks."""
    trimmed, gains, count = cruise(), table("c172p").points[0].gains.pitch, round(SECONDS / T)
    fdm = trimmed.fdm
    nodes = fdm.get_property_manager()

    def reader(name):
        return nodes.get_node(name).get_double_value

    theta, q = reader("attitude/theta-deg"), reader("velocities/q-rad_sec")
    alpha, h = reader("aero/alpha-deg"), reader("position/h-sl-ft")
    vc = reader("velocities/vc-kts")
    elevator = nodes.get_node("fcs/elevator-cmd-norm").set_double_value
    trim, run, rows = trimmed.trim.elevator, fdm.run, []
    step, ki = gains.ramp * T, gains.Ki * T
    unwind = T / max(gains.Kp / gains.Ki, 2 * T)
    reference, damping = theta(), gains.Kr * DEG * q()
    integral, passing, fade = gains.Kp * (1 - gains.b) * reference, damping, math.exp(-T / 0.3)
    start = time.perf_counter()
    for k in range(count):
        y = theta()
        rows.append((k * T, y, alpha(), h(), vc()))
        if k:
            reference += min(max(3.0 - reference, -step), step)
        v = gains.Kp * (gains.b * reference - y) + integral + passing - gains.Kr * DEG * q()
        u = min(max(v, -1.0), 1.0)
        integral += ki * (reference - y) + unwind * (u - v)
        passing *= fade
        elevator(min(max(trim - u, -1.0), 1.0))
        run()
    return (time.perf_counter() - start) / count, theta()


def time_alone():
    """Seconds per step of an aircraft alone by `fly`, and of JSBSim's ``run()``."""
    plane, run, count = cruise(), cruise().fdm.run, round(SECONDS / T)
    sim = Simulation([plane], [], dt=T, log=False)
    start = time.perf_counter()
    fly(sim, SECONDS)
    flown = time.perf_counter()
    for _ in range(count):
        run()
    return (flown - start) / count, (time.perf_counter() - flown) / count


def time_mission(run):
    """Seconds per step of the diagram autopilot_mission."""
    sim = load_diagram("autopilot_mission").sim
    start = time.perf_counter()
    run(sim, SECONDS)
    return (time.perf_counter() - start) / (SECONDS / sim.dt)


def rows():
    ours, core, held, hand, flown, ran = [], [], [], [], [], []
    alone, bare = [], []
    for _ in range(REPETITIONS):
        ours.append(time_flight(one_block))
        core.append(time_flight(core_blocks))
        (diagram, theta), (loop, same) = time_pitch_hold(), time_hand_written_loop()
        assert abs(theta - same) < 1e-6
        held.append(diagram)
        hand.append(loop)
        steps, runs = time_alone()
        alone.append(steps)
        bare.append(runs)
        flown.append(time_mission(fly))
        ran.append(time_mission(Simulation.run))
    peer = f"{len(core_blocks()[0].blocks) - 2} core blocks"
    row("Autopilot: a step on autopilot", peer, ours, core, "us", 0.25, "pathsim")
    row(
        "Aircraft + PitchHold: a step, fly",
        "hand-written loop",
        held,
        hand,
        "us",
        (2.1, 3.1),
        "jsbsim",
    )
    row("Aircraft alone: a step, fly", "fdm.run()", alone, bare, "us", 1.9, "jsbsim")
    row("autopilot mission of the 737: a step, fly", "sim.run", flown, ran, "us", None, "pathsim")


if __name__ == "__main__":
    print(HEADER)
    rows()
