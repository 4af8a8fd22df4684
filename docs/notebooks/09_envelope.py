# %% [markdown]
# # 9. The trim envelope
#
# At which airspeeds and flight path angles can a 737 fly steadily at 15,000 ft? The map has every second speed of the study.
#
# *Aim:* to map where an aircraft can fly steadily, and to name what limits it. *Assumed:* chapter 6. *Time:* 25 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# Each point is a trim at an airspeed $V$ and a path angle $\gamma$:
#
# $$T = D + W \sin\gamma, \qquad 0 \le T \le T_{max}$$
#
# Maximum thrust limits the climb angle, drag at idle limits the descent angle, and the angle-of-attack limit sets the
# low-speed boundary.
#
# **Predict.** Is the steepest climb near the lowest or near the highest airspeed? The next cells have the answer.

# %%
import pandas as pd

from pathsim_jsbsim_blocks import TrimCondition, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, trim

plane = Airframe("737")
# deg, and the search: as published
published = {"alpha_min": -4.0, "alpha_max": 12.0, "solver": "jsbsim"}
rows = []
for speed in range(120, 460, 20):
    for gamma in range(-10, 10):
        there = TrimCondition(
            altitude=15000, speed=speed, gamma=gamma, **published
        )
        try:
            throttle, reason = (
                trim(plane, there, hint=False).throttle[0],
                "",
            )
        except TrimError as error:
            throttle, reason = None, error.reason
        rows.append((speed, gamma, throttle, reason))
table = pd.DataFrame(rows, columns=["KCAS", "gamma", "throttle", "reason"])

# %%
import matplotlib.pyplot as plt

trims = table[table.reason == ""]
figure, ax = plt.subplots(layout="constrained")
points = ax.scatter(trims.KCAS, trims.gamma, c=trims.throttle)
fails = table[table.reason != ""]
ax.scatter(fails.KCAS, fails.gamma, marker="x", color="0.7", s=15)
ax.set(xlabel="calibrated airspeed [kt]", ylabel="flight path angle [deg]")
ax.set_title("737 at 15,000 ft: steady flight; crosses have no trim")
figure.colorbar(points, label="throttle [-]")
plt.show()

# %% [markdown]
# **Answer.** Near the lowest, where the drag has its minimum: faster, drag grows, and the thrust of these engines hardly changes.
#
# Points without a trim have a reason:

# %%
fails.reason.value_counts()

# %% [markdown]
# The study `trim_envelope` does the same with twice as many speeds, on all cores: `pathsim-jsbsim study trim_envelope`.
#
# **Exercise.** How steeply does the aircraft climb at 280 KCAS and full throttle? In level flight the thrust equals the drag; use it, the
# thrust at full throttle and the weight. The trim with the throttle open and the path angle free checks your answer.

# %%
import math

level = trim(plane, TrimCondition(altitude=15000, speed=280, gear=1.0))
full = trim(
    plane, TrimCondition(altitude=15000, speed=280, gear=1.0, throttle=1.0)
)
excess = full.thrust - level.thrust  # lbf
answer = math.degrees(math.asin(excess / level.weight))
print(f"{answer:.2f} deg; the trim climbs at {full.gamma:.2f} deg")
assert abs(answer - full.gamma) < 0.1

# %% [markdown]
# ## In short
#
# - The envelope of steady flight is a map of trims: 364 of 680 in the study.
# - Maximum thrust limits it above, idle drag below, and the angle of attack at low speed.
# - Every point outside has a reason: the limit that it exceeds.
#
# Next: [climbs](10_climbs.ipynb).
