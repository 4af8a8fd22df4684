"""Van der Pol oscillator: any start but the origin ends on one limit cycle.

.. math::
    \\ddot x - \\mu (1 - x^2) \\dot x + x = 0

with mu = 1.5, x(0) = 2, v(0) = 0.5. Wing rock of slender wings is of this kind.

Expected: a limit cycle with an amplitude of 2.015 and a period of 7.09 s.

Source: the published JSBSim/PathSim notebooks.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Function, Integrator, Scope
from pathsim.solvers import RK4

DURATION = 30.0  # s

mu = 1.5

position = Integrator(2.0)
velocity = Integrator(0.5)
acceleration = Function(lambda x, v: mu * (1.0 - x**2) * v - x)
scope = Scope(labels=["position x [-]", "velocity v [1/s]"])

sim = Simulation(
    [position, velocity, acceleration, scope],
    [
        Connection(velocity, position, acceleration[1], scope[1]),
        Connection(position, acceleration[0], scope[0]),
        Connection(acceleration, velocity),
    ],
    Solver=RK4,
    dt=0.01,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(scope, title="Van der Pol oscillator: mu = 1.5")


def figure_phase():
    from pathsim_jsbsim_blocks.plots import phase_portrait

    _, (x, v) = scope.read()
    return phase_portrait(x, v, ("position x [-]", "velocity v [1/s]"),
                          title="Van der Pol oscillator: limit cycle")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, x = signal(scope, "position x")
    upward = time[1:][(x[:-1] < 0.0) & (x[1:] >= 0.0)]
    print(f"amplitude {abs(x[time > 15.0]).max():.3f}, period {upward[-1] - upward[-2]:.2f} s")
    show(figure(), "van_der_pol")
    show(figure_phase(), "van_der_pol_phase")
