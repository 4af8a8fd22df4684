"""Van der Pol oscillator: any start but the origin ends on one limit cycle.

.. math::
    \\ddot x - \\mu (1 - x^2) \\dot x + x = 0

with mu = 1.5, x(0) = 2, v(0) = 0.5. Wing rock of slender wings is such an oscillation.

Expected: a limit cycle with an amplitude of 2.015 and a period of 7.10 s.

Source: notebook 3 of the published JSBSim/PathSim notebooks.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Function, Integrator, Scope
from pathsim.solvers import RK4

DURATION = 40.0  # s

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
    from pathsim_jsbsim_blocks.plots import subplots

    time, (x, v) = scope.read()
    drawing, (left, right) = subplots(1, 2, layout="constrained", figsize=(10, 4.2))
    left.plot(time, x, label="position x [-]")
    left.plot(time, v, "--", label="velocity v [1/s]")
    right.plot(x, v)
    right.plot(x[0], v[0], "ko", label="start")
    left.set_xlabel("time [s]")
    right.set_xlabel("position x [-]")
    right.set_ylabel("velocity v [1/s]")
    left.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
    right.legend(loc="upper right")
    left.grid(alpha=0.4)
    right.grid(alpha=0.4)
    drawing.suptitle("Van der Pol oscillator: mu = 1.5")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, x = signal(scope, "position x")
    upward = time[1:][(x[:-1] < 0.0) & (x[1:] >= 0.0)]
    if len(upward) > 3:
        cycles = x[time > upward[-4]]
        period = (upward[-1] - upward[-4]) / 3
        print(f"amplitude {abs(cycles).max():.3f}, period {period:.2f} s")
    else:
        print(f"too few cycles for a period: {len(upward)} in {sim.time:.4g} s")
    show(figure(), "van_der_pol")
