"""Elevator doublet of a business jet: the short period is excited and decays.

A Global 5000, 15,000 ft, 250 KCAS, half payload and three tanks of 4048.815 lb. The elevator
command moves by -10 % (nose up) from 10 s to 11 s and by +10 % from 12 s to 13 s.

Expected: the aircraft stays trimmed at alpha = 4.32 deg for 10 s; alpha then rises to 6.4 deg,
drops to 1.8 deg, and is back within 0.1 deg 4 s after the doublet.

Source: notebook 4 of the published JSBSim/PathSim notebooks. There the aircraft runs ahead of the
clock, because its model sits in a function that PathSim evaluates more than once a step; here it is
exact.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Scope

from pathsim_jsbsim_blocks import Aircraft, DoubletSource

DURATION = 40.0  # s

doublet = DoubletSource(amplitude=0.1, start=10.0, width=1.0, gap=1.0, polarity=-1)
aircraft = Aircraft(
    aircraft="global5000",
    altitude=15000.0,
    speed=250.0,
    gear=1.0,
    setup={
        "inertia/pointmass-weight-lbs[0]": 7586.0,
        "propulsion/tank[0]/contents-lbs": 4048.815,
        "propulsion/tank[1]/contents-lbs": 4048.815,
        "propulsion/tank[2]/contents-lbs": 4048.815,
    },
    solver="jsbsim",
)
percent = Amplifier(gain=100.0)
scope = Scope(labels=["elevator command [%]", "angle of attack [deg]"])

sim = Simulation(
    [doublet, aircraft, percent, scope],
    [
        Connection(doublet, aircraft["elevator"], percent),
        Connection(percent, scope[0]),
        Connection(aircraft["alpha"], scope[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, title="Global 5000: elevator doublet at 15000 ft, 250 KCAS")


if __name__ == "__main__":
    import math

    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    _, alpha = signal(scope, "angle of attack")
    print(
        f"weight {aircraft.trim.weight:,.0f} lb, empty "
        f"{aircraft.fdm['inertia/empty-weight-lbs']:,.0f} lb, CG at x = {aircraft.trim.cg_x:.1f} in"
    )
    print(
        f"trimmed: alpha {aircraft.trim.alpha:.4f} deg, "
        f"elevator {aircraft.trim.elevator_rad * 180 / math.pi:.4f} deg "
        f"({aircraft.trim.elevator_norm:.6f} of its travel), "
        f"throttle {aircraft.trim.throttle[0]:.6f}"
    )
    print(
        f"alpha from {alpha.min():.2f} to {alpha.max():.2f} deg, "
        f"{alpha[-1]:.2f} deg after {sim.time:.4g} s"
    )
    show(figure(), "elevator_doublet")
