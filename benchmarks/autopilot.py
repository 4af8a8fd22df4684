"""Cost of one step on autopilot: `Autopilot` in one block, against the same loops from core blocks.

    python benchmarks/autopilot.py

One process flies the same c172p in turn under both: altitude hold over rate of climb and pitch
angle, heading hold over roll angle, autothrottle, yaw damper, 120 Hz, one Scope. The core blocks
are Adder, Amplifier, Clip, RateLimiter, AntiWindupPID, Function and a Butterworth high-pass; they
have neither set-point weights nor switches nor bumpless transfer. Both climb 100 ft and turn by
20 deg, which is checked.
"""

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

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.control.gains import GAINS

T = 1 / 120
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
    plane, scope, gains = cruise(), Scope(), GAINS["c172p"]
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


def rows():
    ours, core = [], []
    for _ in range(REPETITIONS):
        ours.append(time_flight(one_block))
        core.append(time_flight(core_blocks))
    row(
        "Autopilot: a step on autopilot",
        f"{len(core_blocks()[0].blocks) - 2} core blocks",
        ours,
        core,
        "us",
        0.25,
    )


if __name__ == "__main__":
    print(HEADER)
    rows()
