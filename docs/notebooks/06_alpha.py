# %% [markdown]
# # 6. Angle of attack against airspeed
#
# A business jet in level flight at 15,000 ft, trimmed at each airspeed. A study returns a table and draws its figure.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# In level flight the lift carries the weight:
#
# $$W = L = \tfrac12 \rho V^2 S\, C_L(\alpha)$$
#
# Half the speed asks for four times the lift coefficient, and so for a larger angle of attack, until the wing stalls.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.aoa_vs_cas(jobs=1, progress=False)
columns = ["requested_speed_kcas", "alpha_deg", "elevator_norm", "reason"]
table[columns].iloc[::6].round(3)

# %%
studies.alpha_elevator_chart(table)

# %% [markdown]
# ## Where there is no trim
#
# A speed without a trim has NaN in its row, and the reason: "alpha limit" where the wing would need a larger angle of attack
# than the model's limit, "thrust" where the engines have not enough of it.

# %%
trims, fails = table[table.trimmed], table[~table.trimmed]
print(f"{len(fails)} of {len(table)} speeds have no trim")
fails.groupby("reason").requested_speed_kcas.agg(["count", "min", "max"])

# %% [markdown]
# The ends of the table are the limits of level flight: below $V_{min}$ the wing cannot carry the weight, above $V_{max}$ the
# engines cannot balance the drag. To the 10 knots of the table:

# %%
print(
    f"V_min {trims.speed_kcas.min():.0f} KCAS, "
    f"V_max {trims.speed_kcas.max():.0f} KCAS"
)

# %% [markdown]
# ## Weight and CG
#
# Three weights, with the CG of the empty aircraft 39.5 in forward at 8000 ft and 39.5 in aft at 30,000 ft:

# %%
loading = studies.aoa_vs_cas_loading(jobs=1, progress=False)
studies.alpha_elevator_chart(loading)

# %% [markdown]
# In a stable aircraft the elevator in trim moves down as the speed grows. With the CG aft it moves up: light and mid
# are statically unstable there.
#
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
# Next: [a rudder kick](07_rudder_kick.ipynb).
