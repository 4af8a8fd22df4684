# %% [markdown]
# # 1. Hello, JSBSim
#
# A Cessna 172, trimmed at 3000 ft and 80 knots. The first chapter looks at the aircraft: its trim, what it weighs, and
# the properties of a model in flight.

# %% tags=["versions"]
from importlib.metadata import version

for package in ("jsbsim", "pathsim", "pathsim-flight"):
    print(package, version(package))

# %% [markdown]
# A diagram of the catalogue is built, and not yet run:

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("hello_jsbsim")
plane = diagram.aircraft
print(f"a step is {plane.T:.6f} s")

# %% [markdown]
# JSBSim has searched for the controls with which nothing accelerates:

# %%
trim = plane.trim
print(f"throttle        {100 * trim.throttle[0]:8.3f} %")
print(f"pitch trim      {100 * trim.pitch_trim:8.4f} %")
print(f"angle of attack {trim.alpha:8.3f} deg")
print(f"roll angle      {trim.phi:8.3f} deg")
print(f"weight          {trim.weight:8.1f} lb, CG at x = {trim.cg_x:.2f} in")

# %% [markdown]
# ## One second of flight

# %%
diagram.sim.run(diagram.DURATION)
diagram.figure()

# %% [markdown]
# ## Properties in flight
#
# `plane.fdm` is the running JSBSim executive. Any property can be read from it.

# %%
for name in (
    "simulation/sim-time-sec",
    "position/h-sl-ft",
    "position/lat-geod-deg",
    "position/long-gc-deg",
    "velocities/vtrue-kts",
    "velocities/vc-kts",
    "velocities/mach",
    "attitude/theta-deg",
    "attitude/phi-deg",
    "attitude/psi-deg",
    "aero/alpha-deg",
    "aero/beta-deg",
    "fcs/elevator-pos-deg",
    "propulsion/engine/propeller-rpm",
    "inertia/weight-lbs",
):
    print(f"{name:34} {plane.fdm[name]:12.4f}")

# %% [markdown]
# A name is found by a part of it:

# %%
from pathsim_jsbsim_blocks.flight import Airframe

Airframe("c172p").property_names("elevator-pos")

# %% [markdown]
# [The property tree](../concepts/properties.md) explains the names. Next: [a minute of trimmed flight, and a
# turn](02_trimmed_flight.ipynb).
