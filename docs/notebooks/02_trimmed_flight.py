# %% [markdown]
# # 2. Trimmed flight and a turn
#
# "Trimmed" means that the aircraft keeps its flight condition with the controls fixed. Then one control moves.
#
# *Aim:* to fly a trimmed aircraft, to move one control, and to read the response. *Assumed:* chapter 1. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# ## A minute of trimmed flight
#
# A trim is a search for the angle of attack, the throttle and the other controls $u$ at which the accelerations vanish:
#
# $$\dot u = \dot v = \dot w = 0, \qquad \dot p = \dot q = \dot r = 0, \qquad \theta = \alpha + \gamma$$
#
# ![Aircraft and Scope](figures/aircraft.svg)
#
# The aircraft, at 5000 ft and 90 knots of calibrated airspeed, heading east:

# %%
from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft(
    "c172p", altitude=5000.0, speed=90.0, heading=90.0, solver="jsbsim"
)
trim = plane.trim
print(f"angle of attack {trim.alpha:7.4f} deg")
print(f"throttle        {trim.throttle[0]:7.4f}")
print(f"roll angle      {trim.phi:7.4f} deg")
knots = 3600 * 0.3048 / 1852  # of 1 ft/s
true_airspeed = knots * plane.outputs["vt"]
print(f"{trim.speed:.1f} KCAS are {true_airspeed:.1f} KTAS here")

# %% [markdown]
# The aircraft advances at 120 Hz; its motion is slow, so the scopes record at 10 Hz: `sampling_period=0.1`.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

flight = Scope(
    sampling_period=0.1,
    labels=["altitude [ft]", "calibrated airspeed [kt]"],
)
attitude = Scope(
    sampling_period=0.1,
    labels=[
        "angle of attack [deg]",
        "pitch angle [deg]",
        "roll angle [deg]",
    ],
)
loads = Scope(
    sampling_period=0.1, labels=["load factor nx [g]", "load factor nz [g]"]
)
track = Scope(
    sampling_period=0.1, labels=["latitude [deg]", "longitude [deg]"]
)
sim = Simulation(
    [plane, flight, attitude, loads, track],
    [
        Connection(plane["h"], flight[0]),
        Connection(plane["vc"], flight[1]),
        Connection(plane["alpha"], attitude[0]),
        Connection(plane["theta"], attitude[1]),
        Connection(plane["phi"], attitude[2]),
        Connection(plane["nx"], loads[0]),
        Connection(plane["nz"], loads[1]),
        Connection(plane["lat"], track[0]),
        Connection(plane["lon"], track[1]),
    ],
    dt=1 / 120,
    log=False,
)
sim.run(60.0)
time, (altitude, speed) = flight.read()
print(f"{len(time)} samples in {sim.time:.0f} s")
print(f"altitude {altitude.min():.1f} to {altitude.max():.1f} ft")
print(f"airspeed {speed.min():.2f} to {speed.max():.2f} KCAS")
_, (nx, nz) = loads.read()
print(f"load factors: nx {nx[-1]:.4f} g, nz {nz[-1]:.4f} g")

# %%
from pathsim_jsbsim_blocks.plots import ground_track, time_histories

time_histories(flight, attitude, title="c172p: trimmed flight")

# %%
time, (latitude, longitude) = track.read()
ground_track(
    time, latitude, longitude, title="c172p: trimmed flight, ground track"
)

# %% [markdown]
# The ailerons balance the propeller's torque (176 ft lbf); the bank of 0.05 deg balances the rudder's side force
# (1.5 lbf). [Trimmed flight](../concepts/trimmed-flight.md) lists which
# quantities are zero.
#
# The same block again, at another airspeed: a parameter changed in flight takes effect at the next reset, as the warning states. The
# reset trims the aircraft again, at a lower airspeed and a larger angle of attack.

# %%
plane.speed = 80.0
sim.reset()
print(f"{plane.trim.speed:.0f} KCAS: {plane.trim.alpha:.4f} deg")
sim.run(10.0)
print(f"altitude after {sim.time:.0f} s: {plane.outputs['h']:.1f} ft")

# %% [markdown]
# ## The turn
#
# Now the ailerons move: 15 % to the left for 5 s.
#
# ![StepSource, JSBSimFDM, Scope](figures/aileron_turn.svg)
#
# `StepSource` is -0.15 from 0 s, and 0 from 5 s on.

# %%
from pathsim.blocks import StepSource

aileron = StepSource(amplitude=[-0.15, 0.0], tau=[0.0, 5.0])

# %% [markdown]
# `JSBSimFDM` makes any JSBSim property a port. Unlike `Aircraft` it writes its inputs unchanged: here it sets the command
# itself, not an increment.

# %%
from pathsim_jsbsim_blocks import JSBSimFDM

fdm = JSBSimFDM(
    input_properties=["fcs/aileron-cmd-norm"],
    output_properties=[
        "attitude/phi-deg",
        "position/h-sl-ft",
        "attitude/psi-deg",
        "position/lat-geod-deg",
        "position/long-gc-deg",
    ],
    aircraft_model="c172p",
    trim_airspeed=90.0,
    trim_altitude=5000.0,
    trim_heading=90.0,
)
response = Scope(
    sampling_period=0.1,
    labels=[
        "aileron command [-]",
        "roll angle [deg]",
        "altitude [ft]",
        "heading [deg]",
    ],
)
track = Scope(
    sampling_period=0.1, labels=["latitude [deg]", "longitude [deg]"]
)
sim = Simulation(
    [aileron, fdm, response, track],
    [
        Connection(aileron, fdm["fcs/aileron-cmd-norm"], response[0]),
        Connection(fdm["attitude/phi-deg"], response[1]),
        Connection(fdm["position/h-sl-ft"], response[2]),
        Connection(fdm["attitude/psi-deg"], response[3]),
        Connection(fdm["position/lat-geod-deg"], track[0]),
        Connection(fdm["position/long-gc-deg"], track[1]),
    ],
    dt=1 / 120,
    log=False,
)

# %% [markdown]
# **Predict.** After 5 s the ailerons return to neutral. At 30 s, is the bank back at zero, as it was at 5 s, or twice as large? The next cell has
# the answer.

# %%
sim.run(30.0)
time, (command, bank, altitude, heading) = response.read()
for t in (5.0, 30.0):
    print(f"{t:2.0f} s: bank {bank[abs(time - t).argmin()]:.1f} deg")

# %% [markdown]
# **Answer.** As it was at 5 s, and a little steeper: the ailerons set a roll rate, not a bank angle, and no control levels the wings.
#
# `time_histories` has drawn the figures so far. This is the code of one, for figures of your own: a panel for each unit above a shared
# time axis, a second axis for the command, and a heading that continues below 0.

# %%
import matplotlib.pyplot as plt
import numpy as np

# PathSim sets 1, which draws curves as polygons
plt.rcParams["path.simplify_threshold"] = 1 / 9
figure, axes = plt.subplots(
    3, 1, sharex=True, layout="constrained", figsize=(8, 6.3)
)
panels = {
    "roll angle [deg]": bank,
    "altitude [ft]": altitude,
    "heading [deg]": np.unwrap(heading, period=360),
}
for ax, (label, values) in zip(axes, panels.items()):
    ax.plot(time, values)
    ax.set_ylabel(label)
    ax.grid(alpha=0.4)
right = axes[0].twinx()
right.step(time, 100 * command, "C1--", where="post")
right.set_ylabel("aileron command [%]", color="C1")
axes[-1].set_xlabel("time [s]")
figure.suptitle("c172p: aileron -0.15 for 5 s")
plt.show()

# %%
time, (latitude, longitude) = track.read()
ground_track(
    time, latitude, longitude, title="c172p: aileron turn, ground track"
)

# %% [markdown]
# The aircraft rolls to -57 deg and keeps turning and descending after the aileron returns to neutral.
#
# In a level turn the vertical part of the lift carries the weight, $L\cos\phi = mg$, and its horizontal part bends the path,
# $L\sin\phi = mV\dot\psi$. Divided:
#
# $$\dot\psi = \frac{g \tan\phi}{V}$$
#
# so a turn needs a controller that holds the bank: `heading_hold` in the [gallery](../gallery.md).
#
# ## The shorter way
#
# Both diagrams are in the catalogue, with more signals:

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

for name in ("trimmed_flight", "aileron_turn"):
    diagram = load_diagram(name)
    diagram.sim.run(diagram.DURATION)
    print(name, f"{diagram.sim.time:.0f} s")

# %% [markdown]
# **Exercise.** A standard-rate turn is 3 deg/s. Which bank does it require at 90 KCAS and 5000 ft, where the true airspeed is 163.6 ft/s? The
# next cell flies your answer.

# %%
import math

from pathsim_jsbsim_blocks import TrimCondition

answer = math.degrees(math.atan(math.radians(3.0) * 163.6 / 32.17))  # deg
turn = TrimCondition(altitude=5000, speed=90, mode="turn", bank=answer)
turning = Aircraft("c172p", condition=turn)
print(
    f"{answer:.1f} deg of bank turns at {turning.trim.turn_rate:.2f} deg/s"
)
assert abs(turning.trim.turn_rate - 3.0) < 0.05

# %% [markdown]
# ## In short
#
# - In a trim all accelerations are zero: with fixed controls altitude, airspeed and load factors are constant.
# - A changed parameter of an aircraft takes effect at the next reset, with a new trim.
# - An aileron sets a roll rate, so a steady turn needs a controller.
#
# Next: [block diagrams](03_diagrams.ipynb).
