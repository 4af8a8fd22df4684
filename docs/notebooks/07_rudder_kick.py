# %% [markdown]
# # 7. A rudder kick
#
# A 737 at 1000 ft and 200 knots. Rudder and aileron ramp up in 3 s, in opposite senses, and are held.
#
# *Aim:* to balance forces and moments in a sideslip. *Assumed:* chapters 2 and 3. *Time:* 25 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# In a steady sideslip the rudder balances the yawing moment of the fin, the ailerons balance the rolling moment of the
# dihedral, and the bank balances the side force $Y$:
#
# $$W \sin\phi \cos\theta = -Y(\beta, \delta_r)$$
#
# ![Two RampSources, Aircraft, Scope](figures/rudder_kick.svg)
#
# Two ramps: $u(t) = u_1\, t / t_r$ up to the rise time $t_r$ = 3 s, and $u_1$ from then on. JSBSim's own script of this manoeuvre
# also flies here, as it is: `pathsim-jsbsim run scripts/rudder_kick.xml` ([JSBSim's scripts](../jsbsim-scripts.md)).

# %%
from pathsim_jsbsim_blocks import RampSource

aileron = RampSource(final=1.0, start=0.0, rise_time=3.0)
rudder = RampSource(final=0.92, start=0.0, rise_time=3.0)

# %% [markdown]
# The aircraft. Alpha is limited to -4 to 12 deg for the trim, as published; `setup` writes the limits, in radians.

# %%
import math

from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft(
    "737",
    altitude=1000.0,
    speed=200.0,
    setup={
        "aero/alpha-min-rad": math.radians(-4.0),
        "aero/alpha-max-rad": math.radians(12.0),
    },
    solver="jsbsim",
)

# %% [markdown]
# The ramps are increments on the trimmed commands of aileron and rudder.
#
# **Predict.** Right aileron and left rudder: from which side does the air come, and which wing is low? The next cells have the answer.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

commands = Scope(labels=["aileron command [-]", "rudder command [-]"])
response = Scope(labels=["sideslip angle [deg]", "roll angle [deg]"])
heading = Scope(labels=["heading [deg]"])
sim = Simulation(
    [aileron, rudder, plane, commands, response, heading],
    [
        Connection(aileron, plane["aileron"], commands[0]),
        Connection(rudder, plane["rudder"], commands[1]),
        Connection(plane["beta"], response[0]),
        Connection(plane["phi"], response[1]),
        Connection(plane["psi"], heading[0]),
    ],
    dt=1 / 120,
    log=False,
)

# %%
from pathsim_jsbsim_blocks.plots import signal, time_histories

sim.run(20.0)  # as long as the published flight
time_histories(
    commands, response, heading, title="737: rudder kick at 200 KCAS"
)

# %%
for label in ("aileron command", "rudder command"):
    print(f"{label}: at most {signal(commands, label)[1].max():.4f}")
outputs = plane.outputs
print(
    f"bank {outputs['phi']:.1f} deg, heading {outputs['psi']:.1f} deg, "
    f"sideslip {outputs['beta']:.1f} deg"
)

# %% [markdown]
# **Answer.** The nose goes left, so that the air comes from the right ($\beta > 0$); the right wing is low.
#
# The published loop adds 1/360 of each command per step. Rounding leaves the sum of 360 such increments just below its limit,
# so one more is added: the commands end at 361/360, 1.0028 and 0.9226, the bank at 17.9 deg
# ([errors of the published examples](../published-examples.md#what-the-published-examples-got-wrong)).
#
# ## The shorter way
#
# The diagram `rudder_kick` continues to 40 s, when the bank is almost steady:

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("rudder_kick")
diagram.sim.run(diagram.DURATION)
print(
    f"bank {diagram.aircraft.outputs['phi']:.1f} deg after {diagram.sim.time:.0f} s"
)

# %% [markdown]
# **Exercise.** Which bank balances the side force at 40 s? Solve the equation at the head of the chapter for $\phi$, with the forces of the
# model: `forces/fby-aero-lbs`, `forces/fby-prop-lbs`, `inertia/weight-lbs`.

# %%
fdm, outputs = diagram.aircraft.fdm, diagram.aircraft.outputs
side = fdm["forces/fby-aero-lbs"] + fdm["forces/fby-prop-lbs"]
weight = fdm["inertia/weight-lbs"] * math.cos(
    math.radians(outputs["theta"])
)
answer = math.degrees(math.asin(-side / weight))
print(f"{answer:.1f} deg balance {side:,.0f} lbf")
assert abs(answer - outputs["phi"]) < 1.5

# %% [markdown]
# The aircraft banks 1 deg more: the heading still changes, and this part of the weight bends the path.
#
# ## In short
#
# - Two ramps lead towards a steady sideslip, in which rudder, ailerons and bank are in balance.
# - `RampSource` ends exactly at its value; a sum of rounded increments does not.
# - At 20 s the bank still changes; at 40 s it is almost steady.
#
# Next: [thrust vectoring](08_thrust_vectoring.ipynb).
