# %% [markdown]
# # 7. A rudder kick
#
# A 737 at 1000 ft and 200 knots. Rudder and aileron ramp up in 3 s, against each other, and are held.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("rudder_kick")
diagram.sim.run(20.0)  # as long as the published flight
diagram.figure()

# %%
from pathsim_jsbsim_blocks.plots import signal

for label in ("aileron command", "rudder command"):
    print(f"{label}: at most {signal(diagram.commands, label)[1].max():.4f}")
outputs = diagram.aircraft.outputs
print(
    f"bank {outputs['phi']:.1f} deg, heading {outputs['psi']:.1f} deg, sideslip {outputs['beta']:.1f} deg"
)

# %% [markdown]
# The published loop counts one step too many: its commands end at 1.0028 and 0.9226, its bank at 17.9 deg
# ([what the published examples got wrong](../published-examples.md#what-the-published-examples-got-wrong)).
#
# Next: [thrust vectoring](08_thrust_vectoring.ipynb).
