# %% [markdown]
# # 9. The trim envelope
#
# Where can a 737 fly steadily at 15,000 ft? Airspeed against flight path angle, with every second speed of the study.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# Each point is a trim at an airspeed $V$ and a path angle $\gamma$:
#
# $$T = D + W \sin\gamma, \qquad 0 \le T \le T_{max}$$
#
# The largest thrust bounds the climb, the drag with the throttle closed bounds the descent, and to the left the angle of
# attack reaches its limit.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.trim_envelope(
    speeds=range(120, 460, 20), jobs=1, progress=False
)
studies.envelope_map(table)

# %% [markdown]
# Points without a trim say why:

# %%
table[~table.trimmed].reason.value_counts()

# %% [markdown]
# Next: [climbs](10_climbs.ipynb).
