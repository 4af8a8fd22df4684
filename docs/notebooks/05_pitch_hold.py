# %% [markdown]
# # 5. A pitch hold
#
# A Cessna 172 raises its nose from the trimmed 1.3 deg to 3 deg and holds it there.
#
# *Aim:* to close a loop with the right sign, and to see what each gain does. *Assumed:* chapter 4, proportional and integral control. *Time:* 40 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# ## The loop
#
# $$
# \Delta\delta_e = -\left[ K_p (b\,\theta_{\mathrm{cmd}} - \theta) +
# K_i \int (\theta_{\mathrm{cmd}} - \theta)\,dt - K_r\,q \right]
# $$
#
# The minus sign is there because a positive elevator command moves the nose **down**. $K_p$ acts on the pitch error, $K_i$ on its
# integral, $K_r$ on the pitch rate $q$; $b$ is the weight of the reference in the proportional part, below 1 for less
# overshoot.
#
# ![PitchHold and Aircraft in a loop](figures/pitch_hold.svg)
#
# The trimmed aircraft; the throttle stays at its trim setting.

# %%
from pathsim_jsbsim_blocks import Aircraft

plane = Aircraft("c172p", altitude=5000.0, speed=90.0, solver="jsbsim")
print(f"trimmed at {plane.trim.theta:.4f} deg")

# %% [markdown]
# `PitchHold` is this law, sampled at 120 Hz, with gains for the c172p.

# %%
from pathsim_jsbsim_blocks import PitchHold

hold = PitchHold(gains="c172p", theta_ref=3.0)  # deg

# %% [markdown]
# The hold takes two measurements and returns one command. `elev_sat` signals that the elevator is at a stop, so that
# the integral does not wind up.

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Scope

pitch = Scope(labels=["pitch angle [deg]", "reference [deg]"])
flight = Scope(
    labels=[
        "altitude [ft]",
        "calibrated airspeed [kt]",
        "elevator increment [-]",
    ]
)
sim = Simulation(
    [plane, hold, pitch, flight],
    [
        Connection(plane["theta"], hold["theta"], pitch[0]),
        Connection(plane["q"], hold["q"]),
        Connection(plane["elev_sat"], hold["elev_sat"]),
        Connection(hold["elevator"], plane["elevator"], flight[2]),
        Connection(hold["theta_cmd"], pitch[1]),
        Connection(plane["h"], flight[0]),
        Connection(plane["vc"], flight[1]),
    ],
    dt=1 / 120,
    log=False,
)

# %%
from pathsim_jsbsim_blocks.plots import time_histories

sim.run(30.0)
time_histories(
    pitch, flight, title=f"c172p: pitch hold at {hold.theta_ref:g} deg"
)

# %% [markdown]
# The aircraft climbs and slows down, because the throttle does not move.
#
# A parameter changed in flight takes effect at the next sample:

# %%
hold.theta_ref = 0.0
sim.run(15.0)
print(f"{plane.outputs['theta']:.3f} deg, {plane.outputs['hdot']:.1f} ft/s")

# %% [markdown]
# ## The sign
#
# The same loop built from PathSim's own blocks, with proportional control only:
#
# **Predict.** A positive elevator command moves the nose down. Which sign must the gain from the pitch error to the elevator have? The figures
# below fly both.
#
# $$\Delta\delta_e = K\,(\theta_{\mathrm{ref}} - \theta)$$
#
# ![Constant, adder, gain and Aircraft in a loop](figures/pitch_loop.svg)
#
# A positive gain looks natural but has the wrong sign: it drives the pitch angle away from its reference.

# %%
from pathsim.blocks import Adder, Amplifier, Constant


def flight_with(gain):
    plane, reference, error = (
        Aircraft("c172p", altitude=5000, speed=90),
        Constant(3.0),
        Adder("+-"),
    )
    controller = Amplifier(gain)
    scope = Scope(labels=["pitch angle [deg]"])
    sim = Simulation(
        [plane, reference, error, controller, scope],
        [
            Connection(reference, error[0]),
            Connection(plane["theta"], error[1], scope),
            Connection(error, controller),
            Connection(controller, plane["elevator"]),
        ],
        dt=1 / 120,
        log=False,
    )
    sim.run(8.0)
    return scope.read()[1][0]


for gain in (0.01, -0.01):
    theta = flight_with(gain)
    print(f"gain {gain:+.2f}: {theta[-1]:5.2f} deg after 8 s")

# %% [markdown]
# The published flight has the wrong sign, and its panel "Elevator command" shows the pitch error in degrees.
#
# With the right sign the pitch angle moves towards 3 deg; reaching it requires the integral action of
# [`PitchHold`](../autopilots.md).
#
# ## Why 1/120 s
#
# The published flight takes steps of 1/60 s; JSBSim's own are 1/120 s. JSBSim integrates the rotation by Euler's method, whose
# error is proportional to the step. The angle of attack in a doublet, compared with that at 960 Hz:

# %%
from pathsim_jsbsim_blocks import DoubletSource


def alpha_at(rate):
    plane = Aircraft("c172p", altitude=5000, speed=90, T=1 / rate)
    doublet, scope = DoubletSource(amplitude=0.1, start=1.0), Scope()
    wires = [
        Connection(doublet, plane["elevator"]),
        Connection(plane["alpha"], scope),
    ]
    sim = Simulation([plane, doublet, scope], wires, dt=1 / rate, log=False)
    sim.run(6.0)
    return scope.read()[1][0][:: rate // 60]


fine = alpha_at(960)
for rate in (60, 120):
    error = abs(alpha_at(rate) - fine).max()
    print(f"{rate} Hz: off by at most {error:.3f} deg")

# %% [markdown]
# **Exercise.** With a step of 1 deg in place of the ramp, and with the whole reference in the proportional part ($b = 1$), the pitch angle
# overshoots by 11 % of the step. Which $b$ reduces this to less than 5 % without loss of speed, that is to more than 1 %?


# %%
def overshoot(b):
    """Of a step of 1 deg, in per cent."""
    plane = Aircraft("c172p", altitude=5000, speed=90)
    gains = {"Kp": 0.1, "Ki": 0.12, "Kr": 0.004, "b": b, "ramp": 90.0}
    hold, scope = PitchHold(gains, theta_ref=plane.trim.theta + 1), Scope()
    wires = [
        Connection(plane["theta"], hold["theta"], scope),
        Connection(plane["q"], hold["q"]),
        Connection(hold["elevator"], plane["elevator"]),
    ]
    Simulation([plane, hold, scope], wires, dt=1 / 120, log=False).run(6.0)
    return 100 * (scope.read()[1][0].max() - hold.theta_ref)


answer = 0.6
print(
    f"b = 1: {overshoot(1.0):.1f} %, b = {answer}: {overshoot(answer):.1f} %"
)
assert 1 < overshoot(answer) < 5

# %% [markdown]
# ## The shorter way
#
# `pitch_hold` and `pitch_hold_primitives` are in the catalogue.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("pitch_hold")
diagram.sim.run(diagram.DURATION)
print(
    f"{diagram.aircraft.outputs['theta']:.3f} deg after {diagram.sim.time:.0f} s"
)

# %% [markdown]
# ## In short
#
# - A positive elevator command is nose down, so the law of a pitch hold begins with a minus.
# - Proportional control alone stops short of the reference; integral action removes the error.
# - The throttle does not move: the aircraft climbs and slows down.
#
# Next: [air data](05b_air_data.ipynb).
