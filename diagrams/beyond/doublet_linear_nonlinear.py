"""Elevator doublet of a business jet, flown by the aircraft and by its linear model.

A Global 5000 at 15,000 ft and 250 KCAS, half payload and three tanks of 4048.815 lb, as in
elevator_doublet: the elevator command moves by -10 % (nose up) from 1 s to 2 s and by +10 % from
3 s to 4 s. ``LinearAircraft`` has the commands and outputs of ``Aircraft`` and is identified from
it.

Expected: alpha swings between 1.8 and 6.4 deg, and the two differ by less than 0.09 deg. With a
doublet of 2 % the difference is 0.003 deg: the aircraft is close to linear here.

Source: the doublet of the published JSBSim/PathSim notebook.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Scope
from pathsim.solvers import RK4

from pathsim_jsbsim_blocks import Aircraft, DoubletSource, LinearAircraft

DURATION = 15.0  # s
SETUP = {
    "inertia/pointmass-weight-lbs[0]": 7586.0,
    "propulsion/tank[0]/contents-lbs": 4048.815,
    "propulsion/tank[1]/contents-lbs": 4048.815,
    "propulsion/tank[2]/contents-lbs": 4048.815,
}

doublet = DoubletSource(amplitude=0.1, start=1.0, width=1.0, gap=1.0, polarity=-1)
aircraft = Aircraft(aircraft="global5000", altitude=15000.0, speed=250.0, gear=1.0, setup=SETUP)
linear = LinearAircraft(aircraft="global5000", altitude=15000.0, speed=250.0, gear=1.0, setup=SETUP)
difference = Adder(operations="+-")
attack = Scope(labels=["angle of attack, nonlinear [deg]", "angle of attack, linear [deg]"])
rate = Scope(labels=["pitch rate, nonlinear [deg/s]", "pitch rate, linear [deg/s]"])
missed = Scope(labels=["difference in angle of attack [deg]"])

sim = Simulation(
    [doublet, aircraft, linear, difference, attack, rate, missed],
    [
        Connection(doublet, aircraft["elevator"], linear["elevator"]),
        Connection(aircraft["alpha"], attack[0], difference[0]),
        Connection(linear["alpha"], attack[1], difference[1]),
        Connection(aircraft["q"], rate[0]),
        Connection(linear["q"], rate[1]),
        Connection(difference, missed),
    ],
    Solver=RK4,
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        attack, rate, missed, title="global5000: elevator doublet, nonlinear and linear"
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    _, alpha = signal(attack, "angle of attack, nonlinear")
    _, apart = signal(missed, "difference in angle of attack")
    print(
        f"angle of attack from {alpha.min():.2f} to {alpha.max():.2f} deg; the linear model is at "
        f"most {abs(apart).max():.3f} deg from it"
    )
    show(figure(), "doublet_linear_nonlinear")
