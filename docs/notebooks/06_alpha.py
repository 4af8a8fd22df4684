# %% [markdown]
# # 6. Angle of attack against airspeed
#
# A business jet in level flight at 15,000 ft, trimmed at each airspeed. The published notebook is by Sean McLeod, Guilherme Araujo
# Lima da Silva and Agostino De Marco, for a study of icing: the location of ice on a wing depends on the angle of attack.
#
# *Aim:* to read alpha and the elevator in trim over airspeed, weight and centre of gravity. *Assumed:* chapter 2. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# In level flight lift equals weight:
#
# $$W = L = \tfrac12 \rho V^2 S\, C_L(\alpha)$$
#
# Halving the speed requires four times the lift coefficient, and so a larger angle of attack, until the wing stalls.
#
# **Predict.** From 300 to 150 KCAS, does alpha grow to four times its value? The next cell has the answer (`hint=False` omits the search for
# the nearest speed that trims).

# %%
import pandas as pd

from pathsim_jsbsim_blocks import TrimCondition, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, trim

plane = Airframe("global5000")
half = {"payload": [7586.0], "fuel": [4048.8] * 3}  # lb: half of both
rows = []
for speed in range(90, 550, 10):
    condition = TrimCondition(
        altitude=15000, speed=speed, solver="jsbsim", **half
    )
    try:
        state = trim(plane, condition, hint=False)
        rows.append((speed, state.alpha, state.elevator_norm, ""))
    except TrimError as error:
        rows.append((speed, None, None, error.reason))
table = pd.DataFrame(rows, columns=["KCAS", "alpha", "elevator", "reason"])
table.iloc[::6].round(3)

# %% [markdown]
# **Answer.** Almost. The lift coefficient grows to four times, and $C_L = C_{L\alpha}(\alpha - \alpha_0)$ with the lift zero near
# $\alpha_0 = 0$:

# %%
alpha = table.set_index("KCAS").alpha
fast, slow = alpha[300], alpha[150]
print(
    f"alpha: {slow / fast:.1f} times; alpha_0 is {(4 * fast - slow) / 3:.1f} deg"
)

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(2, 1, sharex=True, layout="constrained")
labels = {"alpha": "angle of attack [deg]", "elevator": "elevator [-]"}
for ax, (column, label) in zip(axes, labels.items()):
    ax.plot(table.KCAS, table[column], ".-")
    ax.set_ylabel(label)
    ax.grid(alpha=0.4)
axes[1].set_xlabel("calibrated airspeed [kt]")
figure.suptitle("global5000: level flight at 15,000 ft")
plt.show()

# %% [markdown]
# ## Speeds without a trim
#
# A speed without a trim has NaN in its row, and the reason: "alpha limit" if the wing would need a larger angle of attack
# than the model's limit, "thrust" if the available thrust is insufficient.

# %%
trims, fails = table[table.reason == ""], table[table.reason != ""]
print(f"{len(fails)} of {len(table)} speeds have no trim")
fails.groupby("reason").KCAS.agg(["count", "min", "max"])

# %% [markdown]
# The ends of the table are the limits of level flight: below $V_{min}$ the lift is less than the weight, above $V_{max}$ the
# thrust is less than the drag. Within the 10 knots of the table:

# %%
print(
    f"V_min {trims.KCAS.min():.0f} KCAS, V_max {trims.KCAS.max():.0f} KCAS"
)

# %% [markdown]
# ## Weight and CG
#
# The study `aoa_vs_cas` is this loop with a table of more columns, on all cores. `aoa_vs_cas_loading` does it for three
# weights, with the CG of the empty aircraft 39.5 in forward at 8000 ft and 39.5 in aft at 30,000 ft. Only the CG moves: the
# moments of inertia stay as they are, since a trim does not depend on them.

# %%
from pathsim_jsbsim_blocks import studies

loading = studies.aoa_vs_cas_loading(jobs=1, progress=False)
studies.alpha_elevator_chart(loading)

# %% [markdown]
# In a stable aircraft the trimmed elevator moves down as the speed increases. With the CG aft it moves up: the light and
# the mid weight are statically unstable.
#
# **Exercise.** With the CG at the *neutral point* the trimmed elevator does not move with the airspeed. Find how far aft the CG of the
# empty aircraft must be, from the slopes at two positions; the last line trims your answer.


# %%
def slope(aft):
    """Elevator per knot, 200 to 220 KCAS, with the CG moved aft by so many inches."""
    jet = Airframe("global5000", empty_cg_x=790.82 + aft)
    low, high = (
        trim(
            jet,
            TrimCondition(
                altitude=15000,
                speed=speed,
                gear=1.0,
                solver="jsbsim",
                **half,
            ),
        ).elevator_norm
        for speed in (200, 220)
    )
    return (high - low) / 20


forward, aft = slope(0.0), slope(39.5)
answer = 39.5 * forward / (forward - aft)  # in
print(f"{answer:.1f} in aft")
assert abs(slope(answer)) < 0.01 * abs(forward)

# %% [markdown]
# ## Another aircraft

# %%
cessna = studies.aoa_vs_cas(
    aircraft="c172p",
    altitude=3000,
    speeds=range(60, 130, 10),
    jobs=1,
    progress=False,
)
cessna[["speed_kcas", "alpha_deg", "weight_lb", "cg_x_in"]].round(2)

# %% [markdown]
# ## In short
#
# - Each speed is a trim; alpha decreases with increasing airspeed, as the lift coefficient does.
# - A speed without a trim has a reason: below V_min the angle of attack, above V_max the thrust.
# - With the CG far enough aft the trimmed elevator moves the other way: the aircraft is statically unstable.
#
# Next: [a rudder kick](07_rudder_kick.ipynb).
