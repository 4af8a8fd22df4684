"""Step response of a first-order lag, with the analytic curve beside it.

.. math::
    \\tau \\dot y + y = u, \\qquad y(t) = 1 - e^{-t / \\tau}

with tau = 2 s and a unit step at t = 0: the model of an actuator or a turbine spooling up.

Expected: 63.2 % after one time constant, 95.0 % after three; the two curves coincide.

Source: notebook 3 of the published JSBSim/PathSim notebooks.
"""

import math

from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope, Source, StepSource
from pathsim.solvers import RK4

DURATION = 15.0  # s

tau = 2.0  # s

step = StepSource(amplitude=1.0, tau=0.0)
error = Adder("+-")
rate = Amplifier(gain=1.0 / tau)
lag = Integrator(0.0)
analytic = Source(lambda t: 1.0 - math.exp(-t / tau))
scope = Scope(labels=["step u [-]", "response y [-]", "analytic [-]"])

sim = Simulation(
    [step, error, rate, lag, analytic, scope],
    [
        Connection(step, error[0], scope[0]),
        Connection(error, rate),
        Connection(rate, lag),
        Connection(lag, error[1], scope[1]),
        Connection(analytic, scope[2]),
    ],
    Solver=RK4,
    dt=0.01,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    drawing = time_histories(scope, title="first-order lag: tau = 2 s")
    _, response, analytic = drawing.axes[0].lines
    response.set(linestyle="-", color="C0")
    analytic.set(linestyle="none", marker="o", markersize=5, markevery=40, color="C1")
    drawing.axes[0].lines[0].set(linestyle="--", color="0.5")
    drawing.axes[0].legend(loc="lower right")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, y = signal(scope, "response y")
    _, exact = signal(scope, "analytic")
    i = abs(time - tau).argmin()
    print(
        f"y = {y[i]:.4f} after {time[i]:.4g} s; "
        f"largest difference to the analytic curve {abs(y - exact).max():.1e}"
    )
    show(figure(), "step_response")
