# %% [markdown]
# # 4. An elevator doublet
#
# A business jet at 15,000 ft and 250 knots. Its elevator moves up for a second, and down for a second: the short period
# answers and dies out.

# %%
import math

from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("elevator_doublet")
trim, fdm = diagram.aircraft.trim, diagram.aircraft.fdm
print(f"empty weight {fdm['inertia/empty-weight-lbs']:10,.1f} lb")
print(f"weight       {trim.weight:10,.1f} lb, CG at x = {trim.cg_x:.1f} in")
print(f"alpha        {trim.alpha:10.4f} deg")
print(f"elevator     {math.degrees(trim.elevator_rad):10.4f} deg")
print(f"throttle     {trim.throttle[0]:10.4f}")

# %% [markdown]
# The elevator stands at -3 deg, and its command is 0:

# %%
print(fdm["fcs/elevator-cmd-norm"], fdm["fcs/pitch-trim-cmd-norm"])

# %% [markdown]
# JSBSim trims with the trim wheel, not with the stick
# ([why](../concepts/trimmed-flight.md#why-is-the-elevator-command-0-at-trim)). The inputs of `Aircraft` are increments on the
# trimmed commands.

# %%
diagram.sim.run(diagram.DURATION)
diagram.figure()

# %%
from pathsim_jsbsim_blocks.plots import signal

_, alpha = signal(diagram.scope, "angle of attack")
print(f"alpha from {alpha.min():.2f} to {alpha.max():.2f} deg, {alpha[-1]:.2f} deg at the end")

# %% [markdown]
# Next: [a pitch hold](05_pitch_hold.ipynb).
