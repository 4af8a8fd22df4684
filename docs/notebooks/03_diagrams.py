# %% [markdown]
# # 3. Block diagrams
#
# Three diagrams without an aircraft: how blocks and connections represent a differential equation.
#
# *Aim:* to turn a differential equation into a diagram, and to check its solution. *Assumed:* linear differential equations. *Time:* 40 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# ## A damped oscillator
#
# $$\ddot x + 2 \zeta \omega_n \dot x + \omega_n^2 x = 0, \qquad x(0) = 1, \quad \dot x(0) = 0$$
#
# The short period of an aircraft looks like this. A diagram solves for the highest derivative and integrates it:
# $\ddot x = -2 \zeta \omega_n \dot x - \omega_n^2 x$.
#
# ![Two integrators in series, two gains, an adder](figures/damped_oscillator.svg)
#
# An `Integrator` has an output $y = y_0 + \int u\,dt$. Two in series give velocity from acceleration and position
# from velocity; their arguments are the initial values.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Integrator, Scope

wn = 2.0  # rad/s
zeta = 0.25

velocity = Integrator(0.0)
position = Integrator(1.0)

# %% [markdown]
# An `Amplifier` multiplies by its gain. One gives the damping term from the velocity, one the stiffness term from the
# position.

# %%
damping = Amplifier(gain=-2.0 * zeta * wn)
stiffness = Amplifier(gain=-(wn**2))

# %% [markdown]
# An `Adder` sums its inputs, and a `Scope` records.

# %%
acceleration = Adder()
scope = Scope(labels=["position x [-]", "velocity v [1/s]"])

# %% [markdown]
# The connections close the two loops of the picture: each leads from an output to one or more inputs. RK4, the
# fourth-order Runge-Kutta method, integrates in steps of 0.01 s.

# %%
from pathsim.solvers import RK4

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

# %%
from pathsim_jsbsim_blocks.plots import time_histories

sim.run(20.0)
time_histories(
    scope, title=f"damped oscillator: wn = {wn:g} rad/s, zeta = {zeta:g}"
)

# %% [markdown]
# Half a period after the start, $x = -e^{-\pi \zeta / \sqrt{1 - \zeta^2}}$:

# %%
import math

_, (x, v) = scope.read()
exact = -math.exp(-math.pi * zeta / math.sqrt(1 - zeta**2))
print(f"first swing to the other side {x.min():.4f}")
print(f"exact                         {exact:.4f}")

# %% [markdown]
# **Predict.** With twice the damping ratio, is the first swing half as large? The next cell flies it: a changed gain takes effect at once, and
# `reset` returns the integrators to their initial values.

# %%
damping.gain = -2.0 * (2 * zeta) * wn
sim.reset()
sim.run(20.0)
_, (x, v) = scope.read()
print(f"first swing with zeta = {2 * zeta:g}: {x.min():.4f}")

# %% [markdown]
# **Answer.** Smaller than half: the damping ratio is in the exponent, and half a period also lasts longer.
#
# ## A step response
#
# $$\tau \dot y + y = u, \qquad y(t) = 1 - e^{-t/\tau}$$
#
# A first-order lag: the model of an actuator, or of a turbine that spools up.
#
# ![StepSource, adder, gain, integrator, with a feedback](figures/step_response.svg)
#
# `StepSource` is 1 from `tau` = 0 s on. `Adder("+-")` subtracts its second input from its first: it gives $u - y$. The gain
# $1/\tau$ gives $\dot y$, and the integrator $y$.

# %%
import numpy
from pathsim.blocks import StepSource

tau = 2.0  # s
step = StepSource(amplitude=1.0, tau=0.0)
error = Adder("+-")
rate = Amplifier(gain=1.0 / tau)
lag = Integrator(0.0)
scope = Scope(labels=["step u [-]", "response y [-]"])
sim = Simulation(
    [step, error, rate, lag, scope],
    [
        Connection(step, error[0], scope[0]),
        Connection(error, rate),
        Connection(rate, lag),
        Connection(lag, error[1], scope[1]),
    ],
    Solver=RK4,
    dt=0.01,
    log=False,
)
sim.run(15.0)
time, (u, y) = scope.read()
print(
    f"y = {y[abs(time - tau).argmin()]:.4f} after one time constant, "
    f"exact {1 - math.exp(-1):.4f}"
)
figure = time_histories(scope, title=f"first-order lag: tau = {tau:g} s")
figure.axes[0].plot(
    time, 1 - numpy.exp(-time / tau), "k:", label="exact 1 - exp(-t/tau)"
)
figure.axes[0].legend()
figure

# %% [markdown]
# ## Van der Pol's oscillator
#
# $$\ddot x - \mu (1 - x^2) \dot x + x = 0$$
#
# The damping is negative for small deflections and positive for large ones, so every start except the origin ends on the same
# limit cycle. Wing rock of slender wings is such an oscillation.
#
# ![A Function and two integrators](figures/van_der_pol.svg)
#
# A `Function` computes its output from its inputs with any Python function. Here it is the whole right-hand side:
# $\dot v = \mu (1 - x^2) v - x$.

# %%
from pathsim.blocks import Function

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

# %%
from pathsim_jsbsim_blocks.plots import phase_portrait

sim.run(40.0)
time, (x, v) = scope.read()
print(f"amplitude {abs(x[time > 15.0]).max():.3f}")
phase_portrait(
    x,
    v,
    ("position x [-]", "velocity v [1/s]"),
    title=f"Van der Pol's oscillator: mu = {mu:g}",
)

# %% [markdown]
# The time history is not a sine: slow at the turning points and fast between them.

# %%
time_histories(scope, title=f"Van der Pol's oscillator: mu = {mu:g}")

# %% [markdown]
# ## The shorter way, and the same in PathView
#
# The three are in the catalogue, each as a script and as a model for PathView:

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

for name in ("damped_oscillator", "step_response", "van_der_pol"):
    diagram = load_diagram(name)
    diagram.sim.run(diagram.DURATION)
    print(
        f"{name}: {len(diagram.sim.blocks)} blocks, {diagram.sim.time:.0f} s"
    )

# %% [markdown]
# `pathsim-jsbsim view van_der_pol` opens the diagram in the editor. The editor's own button converts a model
# to a script again, as does this line:

# %%
import tempfile
from pathlib import Path

from pathsim_jsbsim_blocks.catalogue import find_diagram
from pathsim_jsbsim_blocks.pathview import convert_model

with tempfile.TemporaryDirectory() as folder:
    script = convert_model(
        find_diagram("van_der_pol").with_suffix(".pvm"),
        Path(folder, "van_der_pol.py"),
    )
    lines = script.read_text(encoding="utf-8").splitlines()
start = next(i for i, line in enumerate(lines) if "Integrator(" in line)
print("\n".join(lines[start : start + 6]))

# %% [markdown]
# **Exercise.** For which damping ratio is the first swing of the oscillator beyond zero 5 % of its start? Peaks of
# $e^{-\zeta\omega_n t}\cos\omega_d t$ are half a period apart, so the swing is $e^{-\pi\zeta/\sqrt{1-\zeta^2}}$.

# %%
import math

answer = -math.log(0.05) / math.hypot(math.pi, math.log(0.05))
swing = math.exp(-math.pi * answer / math.sqrt(1 - answer**2))
print(f"damping ratio {answer:.2f}")
assert abs(swing - 0.05) < 0.005

# %% [markdown]
# [A diagram drawn in PathView](../drawing.md) does all of this with the mouse.
#
# ## In short
#
# - Integrators, gains and adders represent a differential equation; connections close its loops.
# - Each result is checked against an independent solution.
# - The same diagram is a script, a model of the editor, and a script again.
#
# Next: [an elevator doublet](04_elevator_doublet.ipynb).
