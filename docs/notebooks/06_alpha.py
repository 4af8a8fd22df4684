# %% [markdown]
# # 6. Angle of attack against airspeed
#
# A business jet in level flight at 15,000 ft, trimmed at each airspeed. A study returns a table and draws its figure.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.aoa_vs_cas(speeds=range(130, 550, 20), jobs=1, progress=False)
table[["speed_kcas", "trimmed", "alpha_deg", "elevator_norm"]].head().round(3)

# %%
studies.alpha_elevator_chart(table)

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
    aircraft="c172p", altitude=3000, speeds=range(60, 130, 10), jobs=1, progress=False
)
cessna[["speed_kcas", "alpha_deg", "weight_lb", "cg_x_in"]].round(2)

# %% [markdown]
# Next: [a rudder kick](07_rudder_kick.ipynb).
