"""Yaw damper of a Cessna 172: a rudder pulse, with and without the damper.

Two Cessnas at 5000 ft and 90 KCAS get the same rudder pulse, 0.3 from 1 s to 1.5 s. In one of them
``YawDamper`` feeds the yaw rate back to the rudder, through a wash-out filter, so that it does not
oppose steady turns.

Expected: the Dutch roll of the unaugmented aircraft has a period of 2.9 s and a damping ratio of
0.18; with the damper the ratio is 0.40.

Source: our own, on the aircraft and the condition of the published pitch hold.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Adder, Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, YawDamper

DURATION = 15.0  # s

pulse = StepSource(amplitude=[0.3, 0.0], tau=[1.0, 1.5])
bare = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
damped = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
damper = YawDamper(gains="c172p")
rudder = Adder("++")
yaw = Scope(labels=["yaw rate, bare [deg/s]", "yaw rate, damped [deg/s]"])
slip = Scope(labels=["sideslip angle, bare [deg]", "sideslip angle, damped [deg]"])
command = Scope(labels=["rudder, bare [-]", "rudder, damped [-]"])

ports = Interface()
ports.register_port_map({"r": 0, "beta": 1, "rudder": 2}, {"pulse": 0})
with_damper = Subsystem(
    [ports, damped, damper, rudder],
    [
        Connection(ports["pulse"], rudder[0]),
        Connection(damped["r"], damper["r"]),
        Connection(damper["rudder"], rudder[1]),
        Connection(rudder, damped["rudder"], ports["rudder"]),
        Connection(damped["r", "beta"], ports["r", "beta"]),
    ],
)

sim = Simulation(
    [pulse, bare, with_damper, yaw, slip, command],
    [
        Connection(pulse, bare["rudder"], with_damper["pulse"], command[0]),
        Connection(bare["r"], yaw[0]),
        Connection(bare["beta"], slip[0]),
        Connection(with_damper["r"], yaw[1]),
        Connection(with_damper["beta"], slip[1]),
        Connection(with_damper["rudder"], command[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(yaw, slip, command, title="c172p: rudder pulse, with yaw damper and bare")


def damping_ratio(name):
    """Of the Dutch roll, from the first three extremes of the sideslip after the pulse, or nan."""
    import numpy as np

    from pathsim_jsbsim_blocks.plots import signal

    time, beta = signal(slip, f"sideslip angle, {name}")
    beta = beta[time > np.max(pulse.tau)]
    extremes = beta[1:-1][np.diff(beta[1:]) * np.diff(beta[:-1]) < 0.0]
    if len(extremes) < 3:
        return np.nan
    first, second, third = extremes[:3]
    decrement = np.log(abs((first - second) / (second - third)))  # of half a period
    return decrement / np.hypot(np.pi, decrement)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, without = signal(yaw, "yaw rate, bare")
    _, with_damper = signal(yaw, "yaw rate, damped")
    start = min(4.0, time[-1] / 2)
    late = time > start
    print(
        f"yaw rate after {start:.4g} s: at most {abs(without[late]).max():.2f} deg/s bare, "
        f"{abs(with_damper[late]).max():.2f} deg/s damped"
    )
    ratios = damping_ratio("bare"), damping_ratio("damped")
    if min(ratios) > 0.0:
        print(f"damping ratio of the Dutch roll {ratios[0]:.2f} and {ratios[1]:.2f}")
    else:
        print("no Dutch roll to measure by the end")
    show(figure(), "yaw_damper")
