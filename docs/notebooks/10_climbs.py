# %% [markdown]
# # 10. Climbs
#
# An A-4 is trimmed at 1000 ft for a climb at 300 knots and 5 deg. How does the climb change in thinner air?
#
# *Aim:* to fly a climb by fixed trim and by a schedule, and to explain the difference. *Assumed:* chapters 5b and 9. *Time:* 40 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# Excess thrust sets the path angle, excess power the rate of climb:
#
# $$\sin\gamma = \frac{T - D}{W}, \qquad \dot h = V \sin\gamma = \frac{(T - D)\,V}{W}$$
#
# Along the path $m\dot V = T - D - W\sin\gamma$; the first equation is that of $\dot V = 0$. At constant calibrated airspeed the true
# airspeed grows with altitude, $\dot V = \frac{dV}{dh} V\sin\gamma$, so the same excess thrust climbs less steeply by the *acceleration
# factor*:
#
# $$\frac{T - D}{W} = \sin\gamma \left(1 + \frac{V}{g}\frac{dV}{dh}\right)$$
#
# ## The first trim held
#
# ![Aircraft and Scope](figures/aircraft.svg)
#
# The diagram has only an aircraft and a scope: throttle and pitch trim stay at their settings. A `Condition` is an event: it stops the
# run at 20,000 ft if the aircraft reaches it.
#
# **Predict.** Does the aircraft reach 20,000 ft? The next cell has the answer.

# %%
import math

from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from pathsim.events import Condition

from pathsim_jsbsim_blocks import Aircraft, fly

setup = {
    "aero/alpha-min-rad": math.radians(-4.0),
    "aero/alpha-max-rad": math.radians(12.0),
}
labels = [
    "altitude [ft]",
    "calibrated airspeed [kt]",
    "flight path angle [deg]",
]

plane = Aircraft(
    "A4",
    altitude=1000.0,
    speed=300.0,
    gamma=5.0,
    gear=1.0,
    setup=setup,
    solver="jsbsim",
)
held = Scope(sampling_period=1.0, labels=labels)
top = Condition(
    func_evt=lambda t: plane.outputs["h"] >= 20000.0,
    func_act=lambda t: sim.stop(),
)
sim = Simulation(
    [plane, held],
    [
        Connection(plane["h"], held[0]),
        Connection(plane["vc"], held[1]),
        Connection(plane["gamma"], held[2]),
    ],
    [top],
    dt=1 / 120,
    log=False,
)
fly(sim, 900.0, progress=False)
_, (h, speed, gamma) = held.read()
print(
    f"{h[-1]:.1f} ft after {sim.time:.1f} s at {speed[-1]:.1f} KCAS "
    f"and {gamma[-1]:.2f} deg"
)

# %% [markdown]
# **Answer.** No, not in 15 minutes: the path flattens, because the engine gives less thrust in thinner air. (`fly` runs a diagram as
# `sim.run` does, in less time per step.)
#
# ## Throttle and pitch trim by a schedule
#
# A study trims the aircraft at each 1000 ft. Its table is the schedule:

# %%
from pathsim_jsbsim_blocks import studies

table = studies.climb_schedule(jobs=1, progress=False)
table[["altitude_ft", "throttle_norm", "pitch_trim_norm"]].iloc[::4].round(
    4
)

# %%
studies.climb_chart(table)

# %% [markdown]
# ![Two lookup tables move throttle and pitch trim with the altitude](figures/scheduled_climb.svg)
#
# `LUT1D` is a lookup table: it interpolates between the points. Only the altitude is fed back. `JSBSimFDM` writes
# the commands themselves, as the tables contain them.

# %%
from pathsim.blocks import LUT1D

from pathsim_jsbsim_blocks import JSBSimFDM

throttle = LUT1D(
    points=table.altitude_ft.to_numpy(),
    values=table.throttle_norm.to_numpy(),
)
pitch_trim = LUT1D(
    points=table.altitude_ft.to_numpy(),
    values=table.pitch_trim_norm.to_numpy(),
)
fdm = JSBSimFDM(
    input_properties=["fcs/throttle-cmd-norm", "fcs/pitch-trim-cmd-norm"],
    output_properties=[
        "position/h-sl-ft",
        "velocities/vc-kts",
        "flight-path/gamma-deg",
    ],
    aircraft_model="A4",
    trim_airspeed=300.0,
    trim_altitude=1000.0,
    trim_gamma=5.0,
    gear=1.0,
    setup=setup,
)
scheduled = Scope(sampling_period=1.0, labels=labels)
top = Condition(
    func_evt=lambda t: fdm.outputs["position/h-sl-ft"] >= 20000.0,
    func_act=lambda t: climb.stop(),
)
climb = Simulation(
    [fdm, throttle, pitch_trim, scheduled],
    [
        Connection(
            fdm["position/h-sl-ft"], throttle, pitch_trim, scheduled[0]
        ),
        Connection(fdm["velocities/vc-kts"], scheduled[1]),
        Connection(fdm["flight-path/gamma-deg"], scheduled[2]),
        Connection(throttle, fdm["fcs/throttle-cmd-norm"]),
        Connection(pitch_trim, fdm["fcs/pitch-trim-cmd-norm"]),
    ],
    [top],
    dt=1 / 120,
    log=False,
)
fly(climb, 450.0, progress=False)
_, (h, speed, gamma) = scheduled.read()
h_end = fdm.outputs["position/h-sl-ft"]
print(
    f"{h_end:.1f} ft after {climb.time:.1f} s at {speed[-1]:.1f} KCAS "
    f"and {gamma[-1]:.2f} deg"
)

# %%
import matplotlib.pyplot as plt

figure, (left, right) = plt.subplots(
    1, 2, layout="constrained", figsize=(8, 3.8)
)
for name, scope in (("first trim held", held), ("by schedule", scheduled)):
    _, (h, speed, gamma) = scope.read()
    left.plot(h, speed, label=name)
    right.plot(h, gamma)
left.set(xlabel="altitude [ft]", ylabel="airspeed [kt]")
right.set(xlabel="altitude [ft]", ylabel="flight path angle [deg]")
left.legend()
figure.suptitle("A-4: climb from a trim at 300 KCAS and 5 deg")
plt.show()

# %% [markdown]
# The schedule is for 5 deg and the aircraft flies 4.6: at constant calibrated airspeed the true airspeed increases with
# altitude; the tables come from steady-climb trims and do not include the thrust needed for that acceleration. At 10,000 ft V is
# 583 ft/s and grows by 0.0083 ft/s per ft, so the acceleration factor is 1.15 and alone gives 4.3 deg. The aircraft also slows by 4 knots,
# which leaves it less drag, and burns 431 lb of fuel.
#
# **Exercise.** Compute the 4.6 deg at the end of the climb. A trim at the airspeed, the throttle and the fuel of that instant gives
# $(T - D)/W$, as the sine of its path angle; the acceleration factor follows from the last points of the flight.

# %%
import numpy as np

from pathsim_jsbsim_blocks import TrimCondition
from pathsim_jsbsim_blocks.air import cas_to_tas, isa
from pathsim_jsbsim_blocks.flight import Airframe, trim

knot, foot = 1852 / 3600, 0.3048  # m/s, m
_, (h, speed, gamma) = scheduled.read()
tas = [
    float(cas_to_tas(v * knot, isa(x * foot))) / foot
    for x, v in zip(h, speed)
]
factor = 1 + tas[-1] / 32.17 * np.polyfit(h[-20:], tas[-20:], 1)[0]
steady = TrimCondition(
    altitude=h[-1],
    speed=speed[-1],
    throttle=np.interp(h[-1], table.altitude_ft, table.throttle_norm),
    fuel=[fdm.fdm["propulsion/tank[0]/contents-lbs"]],
    gear=1.0,
)
excess = math.sin(math.radians(trim(Airframe("A4"), steady).gamma))
answer = math.degrees(math.asin(excess / factor))
print(f"factor {factor:.3f}: {answer:.2f} deg, flown {gamma[-1]:.2f} deg")
assert abs(answer - gamma[-1]) < 0.1

# %% [markdown]
# ## As airliners climb
#
# 250 knots of calibrated airspeed up to the crossover altitude, then Mach 0.70. At any altitude the lower of the two true
# airspeeds is flown:
#
# $$V = \min\left(\mathrm{TAS}(250\ \mathrm{KCAS},\, h),\ 0.70\,a(h)\right)$$
#
# ![Two conversions of airspeed, and the lower of them](figures/constant_cas_climb.svg)
#
# The blocks of the air data are in SI units. The altitude rises by 2000 ft/min.

# %%
from pathsim.blocks import Amplifier, Constant, Function, Source

from pathsim_jsbsim_blocks import CAStoTAS, MachtoTAS
from pathsim_jsbsim_blocks.air import crossover_altitude
from pathsim_jsbsim_blocks.plots import phase_portrait

knot, foot = 1852 / 3600, 0.3048  # m/s, m
altitude = Source(lambda t: 2000 * foot / 60 * t)
cas, mach = Constant(250 * knot), Constant(0.70)
at_cas, at_mach = CAStoTAS(), MachtoTAS()
tas = Function(lambda a, b: min(a, b))
feet, knots = Amplifier(1 / foot), Amplifier(1 / knot)
speeds = Scope(labels=["altitude [ft]", "true airspeed [kt]"])
sim = Simulation(
    [altitude, cas, mach, at_cas, at_mach, tas, feet, knots, speeds],
    [
        Connection(altitude, at_cas["altitude"], at_mach["altitude"], feet),
        Connection(cas, at_cas["cas"]),
        Connection(mach, at_mach["mach"]),
        Connection(at_cas["tas"], tas[0]),
        Connection(at_mach["tas"], tas[1]),
        Connection(tas, knots),
        Connection(feet, speeds[0]),
        Connection(knots, speeds[1]),
    ],
    dt=1.0,
    log=False,
)
sim.run(1350.0)
print(
    f"crossover altitude {crossover_altitude(250 * knot, 0.70) / foot:,.0f} ft"
)
_, (h, tas) = speeds.read()
phase_portrait(
    tas,
    h,
    ("true airspeed [kt]", "altitude [ft]"),
    title="climb at 250 KCAS / Mach 0.70",
)

# %% [markdown]
# ## The shorter way
#
# `fixed_trim_climb`, `scheduled_climb` and `constant_cas_climb` are in the catalogue. The last has the other airspeeds as well:

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.plots import show

airliner = load_diagram("constant_cas_climb")
airliner.sim.run(airliner.DURATION)
show(airliner.figure(), "climb")

# %% [markdown]
# [Forces in a climb](../concepts/forces-in-a-climb.md) has the equations.
#
# ## In short
#
# - With the first trim held the rate of climb decays, because thrust falls with air density.
# - A schedule of trims keeps the climb angle, less the thrust that accelerates the aircraft.
# - Airliners change from constant CAS to constant Mach at the altitude at which both give the same TAS.
#
# Next: [performance charts](11_performance.ipynb).
