# %% [markdown]
# # 5b. Air data
#
# The standard atmosphere, and what an airspeed indicator shows in it.
#
# *Aim:* to convert between the airspeeds, and to know when they differ. *Assumed:* the gas law. *Time:* 25 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# ## The standard atmosphere
#
# `ISAtmosphere` is the International Standard Atmosphere. Up to 11 km the temperature falls by 6.5 K per km of geopotential
# altitude $H$, and the pressure follows from hydrostatic equilibrium:
#
# $$
# T = T_0 - L H, \qquad p = p_0 \left(\frac{T}{T_0}\right)^{g_0 / (R L)}, \qquad \rho = \frac{p}{R\,T}, \qquad
# a = \sqrt{\gamma R\,T}
# $$
#
# ![Source, ISAtmosphere, Scope](figures/isa_profile.svg)
#
# A `Source` is a function of time: here an altitude that rises by 100 m/s.
#
# **Predict.** At 11 km, is the density nearer to a half or to a third of that at sea level? The next cell has the answer.

# %%
import matplotlib.pyplot as plt
from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import ISAtmosphere

altitude = Source(lambda t: 100.0 * t)  # m
air = ISAtmosphere()
scope = Scope(
    labels=[
        "altitude",
        "pressure",
        "density",
        "temperature",
        "speed of sound",
    ]
)
sim = Simulation(
    [altitude, air, scope],
    [
        Connection(altitude, air["altitude"], scope[0]),
        Connection(air["pressure"], scope[1]),
        Connection(air["density"], scope[2]),
        Connection(air["temperature"], scope[3]),
        Connection(air["speed_of_sound"], scope[4]),
    ],
    dt=0.5,
    log=False,
)
sim.run(110.0)
_, (height, pressure, density, temperature, sound) = scope.read()
print(
    f"sea level: {pressure[0]:.0f} Pa, {density[0]:.4f} kg/m3, "
    f"{temperature[0]:.2f} K, {sound[0]:.2f} m/s"
)
figure, axes = plt.subplots(
    2, 2, sharey=True, layout="constrained", figsize=(8, 6)
)
panels = {
    "pressure [hPa]": pressure / 100,
    "density [kg/m³]": density,
    "temperature [°C]": temperature - 273.15,
    "speed of sound [m/s]": sound,
}
for ax, (label, values) in zip(axes.flat, panels.items()):
    ax.plot(values, height / 1000)
    ax.set(xlabel=label, ylabel="altitude [km]")
    ax.grid(alpha=0.4)
figure.suptitle("International Standard Atmosphere to 11 km")
plt.show()
print(f"density at 11 km: {density[-1] / density[0]:.3f} of sea level's")

# %% [markdown]
# **Answer.** Nearer to a third: the pressure falls to 0.22, and the air that remains is colder, hence denser.
#
# ## Calibrated and true airspeed
#
# An airspeed indicator shows the speed that would cause the measured impact pressure $q_c$ at sea level (CAS). The true
# airspeed (TAS) causes the same $q_c$ at a pressure $p$ and a speed of sound $a$:
#
# $$
# q_c = p_0 \left[ \left( 1 + \frac{\mathrm{CAS}^2}{5\,a_0^2} \right)^{7/2} - 1 \right], \qquad
# \mathrm{TAS} = a \sqrt{5 \left[ \left( \frac{q_c}{p} + 1 \right)^{2/7} - 1 \right]}
# $$
#
# The air that stops at the pitot tube is compressed without losses, which gives the first formula in three lines. Its kinetic energy
# heats it ($c_p = 3.5\,R$, $a^2 = 1.4\,R\,T$); its pressure follows the temperature by the isentropic law; the indicator assumes $p_0$ and $a_0$:
#
# $$
# \frac{T_t}{T} = 1 + \frac{V^2}{2\,c_p T} = 1 + \frac{V^2}{5\,a^2}, \qquad \frac{p_t}{p} = \left(\frac{T_t}{T}\right)^{7/2}, \qquad
# q_c = p_t - p
# $$
#
# Both hold below Mach 1; the blocks use Rayleigh's formula above. With $\mathrm{TAS} = \mathrm{CAS} / \sqrt{\rho / \rho_0}$, as in the published
# table, the result is the true airspeed for 120 kt of *equivalent* airspeed.

# %%
from pathsim_jsbsim_blocks.air import cas_to_tas, eas_to_tas, isa

knot, foot = 1852 / 3600, 0.3048  # m/s, m
print("altitude [ft]  CAS [kt]  TAS [kt]  TAS/CAS  by the formula of EAS")
for level in (0, 5_000, 10_000, 20_000, 30_000, 40_000):
    here = isa(level * foot)
    true = cas_to_tas(120 * knot, here) / knot
    wrong = eas_to_tas(120 * knot, here) / knot
    print(
        f"{level:13,d}  {120:8.1f}  {true:8.1f}  {true / 120:7.3f}  "
        f"{wrong:22.1f}"
    )

# %% [markdown]
# **Exercise.** At 20,000 ft the pitot tube measures an impact pressure of 5 kPa. Compute CAS and TAS in knots from the formulas, the first
# solved for CAS.

# %%
p0, a0, impact = 101325.0, 340.294, 5000.0  # Pa, m/s, Pa
level = isa(20000 * foot)
cas = a0 * (5 * ((impact / p0 + 1) ** (2 / 7) - 1)) ** 0.5
ratio = impact / level.pressure + 1
tas = level.speed_of_sound * (5 * (ratio ** (2 / 7) - 1)) ** 0.5
print(f"{cas / knot:.1f} KCAS, {tas / knot:.1f} KTAS")
assert abs(tas - cas_to_tas(cas, level)) < 0.01

# %% [markdown]
# ## The shorter way
#
# `isa_profile`, to 80 km, and `constant_cas_climb` of [chapter 10](10_climbs.ipynb) are in the catalogue.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("isa_profile")
diagram.sim.run(diagram.DURATION)
print(f"{len(diagram.sim.blocks)} blocks, {diagram.sim.time:.0f} s")

# %% [markdown]
# ## In short
#
# - Temperature falls by 6.5 K per km up to 11 km; pressure follows from the weight of the air above.
# - An ideal indicator shows CAS; at 40,000 ft the TAS is twice as much.
# - The formula with the square root of the density ratio applies to EAS, which is below CAS because of compressibility.
#
# Next: [angle of attack against airspeed](06_alpha.ipynb).
