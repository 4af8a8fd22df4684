# %% [markdown]
# # 2. Trimmed flight and a turn
#
# What "trimmed" means: with the controls fixed, an aircraft stays where it is. And what happens when one of them moves.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

straight = load_diagram("trimmed_flight")
outputs = straight.aircraft.outputs
true_airspeed = outputs["vt"] * 3600 * 0.3048 / 1852  # from ft/s to knots
print(f"{outputs['vc']:.1f} KCAS are {true_airspeed:.1f} KTAS at {outputs['h']:.0f} ft")
straight.sim.run(straight.DURATION)
straight.figure()

# %%
straight.figure_track()

# %% [markdown]
# The ailerons balance the propeller's torque (176 ft lbf); the bank of 0.05 deg balances the side force that comes with
# the rudder (1.5 lbf). [Trimmed flight](../concepts/trimmed-flight.md) lists which
# quantities are zero.
#
# ## The turn
#
# 15 % of left aileron for 5 s. It sets a roll rate, not a bank angle: the aircraft rolls to 57 deg, and goes on turning
# and descending when the aileron is back in the middle.

# %%
turn = load_diagram("aileron_turn")
turn.sim.run(turn.DURATION)
turn.figure()

# %%
turn.figure_track()

# %% [markdown]
# A turn needs a controller: `heading_hold` in the [gallery](../gallery.md). Next: [block diagrams](03_diagrams.ipynb).
