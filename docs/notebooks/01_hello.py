# %% [markdown]
# # 1. Hello, JSBSim
#
# A Cessna 172, trimmed at 3000 ft and 80 knots. This chapter flies it for a second, first with JSBSim alone, then
# as a block in a diagram, and looks at the properties of the model.
#
# *Aim:* to load, trim and step a JSBSim aircraft, alone and as a block. *Assumed:* [chapter 0](00_inside_one_step.ipynb). *Time:* 20 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`. It copies the chapters to
# a folder of yours and opens them in JupyterLab. Run a cell with Shift+Enter; change a number and run it again.

# %% tags=["versions"]
from importlib.metadata import version

for package in ("jsbsim", "pathsim", "pathsim-flight"):
    print(package, version(package))

# %% [markdown]
# ## JSBSim alone
#
# `FGFDMExec` is JSBSim's executive: it holds one aircraft. All data are read and written through named properties. The
# initial conditions are those under `ic/`; `run_ic` applies them. Then the engine is started (-1 means all engines), and
# the last line trims the aircraft: 1 selects the full trim, which drives all six accelerations to zero.

# %%
import jsbsim

jsbsim.FGJSBBase().debug_lvl = 0  # no messages
fdm = jsbsim.FGFDMExec(None)  # the aircraft of the package
fdm.load_model("c172p")
fdm["ic/h-sl-ft"] = 3000.0
fdm["ic/vc-kts"] = 80.0
fdm["ic/gamma-deg"] = 0.0
fdm["ic/psi-true-deg"] = 45.0
fdm.run_ic()
fdm["propulsion/set-running"] = -1
fdm["simulation/do_simple_trim"] = 1

print(f"a step is {fdm.get_delta_t():.6f} s")
trimmed = {
    "throttle [%]": 100 * fdm["fcs/throttle-cmd-norm"],
    "pitch trim [%]": 100 * fdm["fcs/pitch-trim-cmd-norm"],
    "angle of attack [deg]": fdm["aero/alpha-deg"],
}
for name, value in trimmed.items():
    print(f"{name:22} {value:9.4f}")

# %% [markdown]
# A flight is a loop: each `run` is one step of 1/120 s.

# %%
for _ in range(120):
    fdm.run()

names = {
    "altitude [ft]": "position/h-sl-ft",
    "true airspeed [ft/s]": "velocities/vt-fps",
    "pitch angle [deg]": "attitude/theta-deg",
    "roll angle [deg]": "attitude/phi-deg",
    "heading [deg]": "attitude/psi-deg",
}
alone = {name: fdm[path] for name, path in names.items()}
for name, value in alone.items():
    print(f"{name:22} {value:9.4f}")

# %% [markdown]
# ## The same as a block
#
# In a block diagram the aircraft is one block among others. In each sample period $T$ it advances the state of the
# aircraft by one step,
#
# $$x_{k+1} = f(x_k, u_k), \qquad t_k = k\,T, \qquad T = 1/120\ \mathrm{s}$$
#
# and it begins at the trim, at which $\dot u = \dot v = \dot w = \dot p = \dot q = \dot r = 0$.
#
# ![Aircraft and Scope](figures/aircraft.svg)
#
# `Aircraft` loads and trims the model when it is built; `solver="jsbsim"` selects JSBSim's own trim. Its inputs are *increments* on
# the trimmed commands. They are unconnected, so the controls stay at their trim settings.

# %%
from pathsim_jsbsim_blocks import Aircraft

# ft, KCAS, deg
plane = Aircraft(
    "c172p", altitude=3000.0, speed=80.0, heading=45.0, solver="jsbsim"
)
plane.trim

# %% [markdown]
# `Scope` records the signals connected to it, and a `Connection` leads from an output to one or more inputs. Ports have
# names: `plane["h"]` is the altitude.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

flight = Scope(
    labels=[
        "altitude [ft]",
        "true airspeed [ft/s]",
        "pitch angle [deg]",
        "roll angle [deg]",
    ]
)
heading = Scope(labels=["heading [deg]"])
sim = Simulation(
    [plane, flight, heading],
    [
        Connection(plane["h"], flight[0]),
        Connection(plane["vt"], flight[1]),
        Connection(plane["theta"], flight[2]),
        Connection(plane["phi"], flight[3]),
        Connection(plane["psi"], heading),
    ],
    dt=1 / 120,
    log=False,
)

# %% [markdown]
# **Predict.** JSBSim alone has flown 120 steps. After 1 s of the diagram, by how many feet do the two altitudes differ? The next cell
# flies this second (`log=False` leaves out PathSim's progress lines).

# %%
sim.run(1.0)
time, recorded = flight.read()
print(f"{'':22} {'JSBSim':>9} {'Aircraft':>9}")
ours = [
    100 * plane.trim.throttle[0],
    100 * plane.trim.pitch_trim,
    plane.trim.alpha,
]
for (name, value), block in zip(trimmed.items(), ours):
    print(f"{name:22} {value:9.4f} {block:9.4f}")
for (name, value), block in zip(
    alone.items(), [*recorded[:, -1], plane.outputs["psi"]]
):
    print(f"{name:22} {value:9.4f} {block:9.4f}")
    assert value == block

# %% [markdown]
# **Answer.** By nothing: the numbers are equal, bit for bit.
#
# The block also keeps time with the diagram under any solver, refuses names that do not exist, and prevents models from
# opening sockets, writing files and printing.

# %%
from pathsim_jsbsim_blocks.plots import time_histories

time_histories(flight, heading, title="c172p: 1 s of trimmed flight")

# %% [markdown]
# ## Properties
#
# A model has hundreds of properties, this one 678. JSBSim searches for part of a name, and shows whether each property
# can be read (R) and written (W):

# %%
for line in fdm.query_property_catalog("velocities/").split("\n")[:5]:
    print(line)

# %% [markdown]
# `plane.fdm` is the running executive inside the block. These are the 40 under `velocities/` with their values after the
# second of flight: `-fps` is ft/s, `u`, `v`, `w` are the velocity in body axes, `p`, `q`, `r` the rates, `eci` and `ned`
# name [frames](../concepts/frames.md).

# %%
found = plane.airframe.property_names("velocities/")
print(len(found), "properties")
for name in found:
    readable = "r" in plane.airframe.access(name)
    print(f"{name:40} {plane.fdm[name]:12.4f}" if readable else name)

# %% [markdown]
# [The property tree](../concepts/properties.md) explains the names, and JSBSim's
# [reference of properties](https://jsbsim-team.github.io/jsbsim-reference-manual/user/concepts/properties/) explains how models use them.
# `pathsim-jsbsim properties c172p elevator` searches from the command line, and `pathsim-jsbsim help Aircraft` prints the manual page of the block.
#
# ## The shorter way
#
# This diagram is in the catalogue, as a script that can be imported and as a model for
# [PathView](../pathview.md):

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("hello_jsbsim")
diagram.sim.run(diagram.DURATION)
print(
    f"{diagram.aircraft.outputs['h']:.4f} ft after {diagram.sim.time:.0f} s"
)

# %% [markdown]
# **Exercise.** The velocity in body axes is $u$ forward and $w$ down. Compute the true airspeed and the angle of attack from `u-fps` and
# `w-fps`; JSBSim's own are `vt-fps` and `aero/alpha-deg`. The next cell has a solution.

# %%
import math

u, w = fdm["velocities/u-fps"], fdm["velocities/w-fps"]
speed = math.hypot(u, w)  # ft/s
alpha = math.degrees(math.atan2(w, u))
print(f"{speed:.2f} ft/s, {alpha:.3f} deg")
assert abs(speed - fdm["velocities/vt-fps"]) < 0.01
assert abs(alpha - fdm["aero/alpha-deg"]) < 0.001

# %% [markdown]
# ## In short
#
# - JSBSim alone is an executive with properties: load, set `ic/`, `run_ic`, trim, `run`.
# - `Aircraft` flies the same as a block: named ports, inputs as increments on the trim, the clock of the diagram.
# - A model lists its properties by name; 40 of this one's are velocities.
#
# Next: [a minute of trimmed flight, and a turn](02_trimmed_flight.ipynb).
