"""Damped oscillator: a second-order system rings down from an initial deflection.

.. math::
    \\ddot x + 2 \\zeta \\omega_n \\dot x + \\omega_n^2 x = 0

with wn = 2 rad/s, zeta = 0.25, x(0) = 1, at rest. A short-period response has this form.

Expected: a period of 3.245 s; each swing is 44 % of the one before it, half a period earlier.

Source: notebook 3 of the published JSBSim/PathSim notebooks; there the labels of the scope are
swapped: the curve named position is the velocity.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope
from pathsim.solvers import RK4

DURATION = 20.0  # s

wn = 2.0  # rad/s
zeta = 0.25

velocity = Integrator(0.0)
position = Integrator(1.0)
damping = Amplifier(gain=-2.0 * zeta * wn)
stiffness = Amplifier(gain=-(wn**2))
acceleration = Adder()
scope = Scope(labels=["position x [-]", "velocity v [1/s]"])

sim = Simulation(
    [velocity, position, damping, stiffness, acceleration, scope],
    [
        Connection(acceleration, velocity),
        Connection(velocity, position, damping, scope[1]),
        Connection(position, stiffness, scope[0]),
        Connection(damping, acceleration[0]),
        Connection(stiffness, acceleration[1]),
    ],
    Solver=RK4,
    dt=0.01,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, title="damped oscillator: wn = 2 rad/s, zeta = 0.25")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, x = signal(scope, "position x")
    _, v = signal(scope, "velocity v")
    back = time[1:][(v[:-1] < 0.0) & (v[1:] >= 0.0)]
    if back.size:
        swing = x[time <= back[0]].min()
        print(f"first swing to {swing:.4f} (analytic -0.4443 from x = 1 with zeta = 0.25)")
    else:
        print("the first swing is not over by the end")
    print(f"x = {x[-1]:.5f} after {sim.time:.4g} s")
    show(figure(), "damped_oscillator")
