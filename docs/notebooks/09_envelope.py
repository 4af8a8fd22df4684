# %% [markdown]
# # 9. The trim envelope
#
# Where can a 737 fly steadily at 15,000 ft? Airspeed against flight path angle, with every second speed of the study.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.trim_envelope(speeds=range(120, 460, 20), jobs=1, progress=False)
studies.envelope_map(table)

# %% [markdown]
# Points without a trim say why:

# %%
table[~table.trimmed].reason.value_counts()

# %% [markdown]
# Next: [climbs](10_climbs.ipynb).
