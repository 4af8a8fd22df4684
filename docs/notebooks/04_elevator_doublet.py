# %% [markdown]
# # 4. An elevator doublet
#
# A business jet at 15,000 ft and 250 knots. The elevator is deflected up for 1 s, then down for 1 s; this excites the
# short period, which decays.
#
# *Aim:* to excite the short period and to describe its response. *Assumed:* chapters 2 and 3. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# ![DoubletSource, Aircraft, Scope](figures/elevator_doublet.svg)
#
# ## The aircraft, loaded and trimmed
#
# `setup` writes properties before the trim: half the payload, and the fuel in three tanks, in lb. A lighter aircraft trims
# at a smaller angle of attack, with less thrust.

# %%
import math

from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft(
    "global5000",
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
trim, fdm = plane.trim, plane.fdm
print(f"empty weight {fdm['inertia/empty-weight-lbs']:10,.1f} lb")
print(f"weight       {trim.weight:10,.1f} lb, CG at x = {trim.cg_x:.1f} in")
print(f"alpha        {trim.alpha:10.4f} deg")
print(f"elevator     {math.degrees(trim.elevator_rad):10.4f} deg")
print(f"throttle     {trim.throttle[0]:10.4f}")

# %% [markdown]
# The elevator deflection is -3 deg, and its command is 0:

# %%
print(fdm["fcs/elevator-cmd-norm"], fdm["fcs/pitch-trim-cmd-norm"])

# %% [markdown]
# JSBSim trims with the trim wheel, not with the stick
# ([why](../concepts/trimmed-flight.md#why-is-the-elevator-command-0-at-trim)). The inputs of `Aircraft` are increments on
# the trimmed commands:
#
# $$\delta_e(t) = \delta_{e,\mathrm{trim}} + \Delta\delta_e(t)$$
#
# ## The doublet
#
# $$
# \Delta\delta_e(t) =
# \begin{cases}
# -A & 10 \le t < 11\ \mathrm{s} \\
# +A & 12 \le t < 13\ \mathrm{s} \\
# 0 & \text{otherwise}
# \end{cases}
# \qquad A = 0.1
# $$
#
# A negative command raises the nose, so `polarity=-1` begins nose up. The published diagram uses three blocks:
# a `Source` for the command at trim, a `StepSource` for the four edges, and an `Adder` for their sum. `DoubletSource`
# replaces all three: the aircraft block already adds the trimmed command, and the edges are exact at any step size.

# %%
from pathsim_jsbsim_blocks import DoubletSource

doublet = DoubletSource(
    amplitude=0.1, start=10.0, width=1.0, gap=1.0, polarity=-1
)

# %% [markdown]
# An `Amplifier` converts the command to per cent for the scope.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Scope

percent = Amplifier(gain=100.0)
scope = Scope(labels=["elevator command [%]", "angle of attack [deg]"])
sim = Simulation(
    [doublet, plane, percent, scope],
    [
        Connection(doublet, plane["elevator"], percent),
        Connection(percent, scope[0]),
        Connection(plane["alpha"], scope[1]),
    ],
    dt=1 / 120,
    log=False,
)

# %%
from pathsim_jsbsim_blocks.plots import time_histories

sim.run(40.0)
time_histories(
    scope, title="Global 5000: elevator doublet at 15000 ft, 250 KCAS"
)

# %%
time, (command, alpha) = scope.read()
print(
    f"alpha from {alpha.min():.2f} to {alpha.max():.2f} deg, "
    f"{alpha[-1]:.2f} deg at the end"
)

# %% [markdown]
# ## The shorter way
#
# The diagram is in the catalogue. Its values can be changed on loading: here half the amplitude.
#
# **Predict.** Alpha swung by 2.08 deg above its trim of 4.32 deg, and by 2.50 deg below. What is its range now? The next cell has the answer.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("elevator_doublet", {"doublet.amplitude": 0.05})
diagram.sim.run(diagram.DURATION)
_, (_, half) = diagram.scope.read()
print(f"alpha from {half.min():.2f} to {half.max():.2f} deg")

# %% [markdown]
# **Answer.** Half of both swings, to 0.01 deg: the aircraft is almost linear here. [Linear models](../linear-models.md) build on this, and the
# diagram `doublet_linear_nonlinear` plots both.
#
# **Exercise.** Read the natural frequency of the short period off the figure: the time from a maximum of alpha to the next is a damped
# period $2\pi / (\omega_n\sqrt{1 - \zeta^2})$. The aircraft's linear model has the answer.

# %%
modes = {m.name: m for m in plane.linear_model(inputs=["elevator"]).modes()}
short = modes["short period"]
damping, period = 0.45, 4.0  # your readings: -, s
answer = 2 * math.pi / (period * math.sqrt(1 - damping**2))
print(f"{answer:.2f} rad/s read, {short.frequency:.2f} rad/s in the model")
assert abs(answer / short.frequency - 1) < 0.2

# %% [markdown]
# ## In short
#
# - `setup` sets payload and fuel before the trim; JSBSim trims with the trim wheel, so the elevator command is 0.
# - A doublet excites the short period: alpha swings from 1.82 to 6.40 deg and the motion decays.
# - Half the command gives half the response: the aircraft is almost linear here.
#
# Next: [a pitch hold](05_pitch_hold.ipynb).
