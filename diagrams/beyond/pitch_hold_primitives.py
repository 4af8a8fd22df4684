"""The pitch hold built from PathSim's own blocks, to show the law inside ``PitchHold``.

c172p at 5000 ft and 90 KCAS: an Adder forms the error, a continuous AntiWindupPID and the pitch
rate form the command, an Amplifier reverses its sign (a nose-up elevator command is **negative**),
and a Clip limits it to the elevator's travel.

Expected: within 0.05 deg of 3 deg after 2.6 s, with an overshoot of 0.18 deg and an elevator that
jumps to -0.17 at the start; ``pitch_hold`` settles in 1.8 s, overshoots by 0.025 deg and moves the
elevator by at most 0.055. Here the reference steps instead of following a ramp, and has its full
weight in the proportional part. The gains are positive and the sign is reversed after the
controller, because PathSim's AntiWindupPID diverges in saturation with negative gains.

Source: the published JSBSim/PathSim notebook's wiring, with the right sign and gains.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, AntiWindupPID, Clip, Constant, Scope
from pathsim.solvers import RK4

from pathsim_jsbsim_blocks import Aircraft

DURATION = 30.0  # s

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
reference = Constant(3.0)
error = Adder("+-")
pid = AntiWindupPID(Kp=0.10, Ki=0.12, Kd=0.0, f_max=100.0, Ks=10.0, limits=[-1.0, 1.0])
rate = Amplifier(gain=0.004)
demand = Adder("+-")
sign = Amplifier(gain=-1.0)
clip = Clip(min_val=-1.0, max_val=1.0)
pitch = Scope(labels=["pitch angle [deg]", "reference [deg]"])
flight = Scope(labels=["altitude [ft]", "elevator increment [-]"])

sim = Simulation(
    [aircraft, reference, error, pid, rate, demand, sign, clip, pitch, flight],
    [
        Connection(reference, error[0], pitch[1]),
        Connection(aircraft["theta"], error[1], pitch[0]),
        Connection(error, pid),
        Connection(aircraft["q"], rate),
        Connection(pid, demand[0]),
        Connection(rate, demand[1]),
        Connection(demand, sign),
        Connection(sign, clip),
        Connection(clip, aircraft["elevator"], flight[1]),
        Connection(aircraft["h"], flight[0]),
    ],
    Solver=RK4,
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(pitch, flight, title="c172p: pitch hold from PathSim's own blocks")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show, signal

    sim.run(DURATION)
    time, theta = signal(pitch, "pitch angle")
    print(
        f"pitch angle {theta[-1]:.3f} deg after {sim.time:.4g} s, "
        f"{settling(time, theta, 3.0, 0.05, 'deg')}, at most {theta.max():.3f} deg"
    )
    show(figure(), "pitch_hold_primitives")
