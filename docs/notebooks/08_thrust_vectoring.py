# %% [markdown]
# # 8. Thrust vectoring
#
# In which direction should the engines of a 737 point for minimum thrust? There are two conditions: "cruise" is level flight at
# 30,000 ft and Mach 0.8, "climb" is 3 deg at 15,000 ft and 300 knots.
#
# *Aim:* to find the thrust angle of minimum thrust, and to check it by the balance of forces. *Assumed:* chapter 6. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# **Predict.** Should the engines point up or down from the body axis, and by how much? The next cells have the answer.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.thrust_vectoring(jobs=1, progress=False)
studies.thrust_chart(table)

# %%
for case, rows in table.groupby("case", sort=False):
    least = rows.loc[rows.thrust_lb.idxmin()]
    saved = 100 * (1 - least.thrust_lb / rows.thrust_lb.iloc[0])
    print(
        f"{case}: {least.thrust_lb:,.0f} lbf at about "
        f"{least.thrust_angle_deg:.0f} deg, {saved:.2f} % saved"
    )

# %% [markdown]
# **Answer.** Up, by about 4 deg.
#
# ## The balance of forces
#
# The thrust $F$ makes an angle $\varepsilon$ with the flight path. Along and across the path
#
# $$F \cos\varepsilon = D(L) + W \sin\gamma, \qquad L = W \cos\gamma - F \sin\varepsilon$$
#
# The lift component of the thrust unloads the wing, which reduces the lift-dependent drag. At constant airspeed both equations are
# differentiated with respect to $\varepsilon$, where $F$ has its minimum, $dF/d\varepsilon = 0$:
#
# $$
# -F \sin\varepsilon = \frac{dD}{dL}\,\frac{dL}{d\varepsilon}, \qquad \frac{dL}{d\varepsilon} = -F \cos\varepsilon, \qquad\text{so}\qquad
# \tan\varepsilon = \frac{dD}{dL}
# $$
#
# Lift and drag of the trimmed aircraft at five weights give that slope:

# %%
import math

import numpy as np

conditions = {
    "cruise": {"altitude": 30000.0, "mach": 0.8},
    "climb": {"altitude": 15000.0, "speed": 300.0, "gamma": 3.0},
}
for case, condition in conditions.items():
    engines = {
        f"propulsion/engine[{i}]/pitch-angle-rad": math.radians(4.0)
        for i in (0, 1)
    }
    grid = [
        {**condition, **engines, "fuel": [fuel] * 3}
        for fuel in range(6000, 11000, 1000)
    ]
    trims = studies.trim_sweep(
        "737",
        grid,
        outputs=["forces/fwx-aero-lbs", "forces/fwz-aero-lbs"],
        jobs=1,
        progress=False,
    )
    drag, lift = (abs(trims[f"forces/fw{axis}-aero-lbs"]) for axis in "xz")
    weight = table[table.case == case].weight_lb.iloc[0]
    slope = np.polyval(
        np.polyder(np.polyfit(lift, drag, 2)),
        np.interp(weight, trims.weight_lb, lift),
    )
    alpha = np.interp(weight, trims.weight_lb, trims.alpha_deg)
    angle = math.degrees(math.atan(slope))
    print(
        f"{case}: dD/dL {slope:.3f}, {angle:.1f} deg to the path, "
        f"{angle - alpha:.1f} deg to the body axis"
    )

# %% [markdown]
# The study finds about 1 deg less: the formula neglects the moment of the tilted thrust. The question comes from G. B. Gilyard and
# A. Bolonkin, [NASA/TM-2000-209021](https://ntrs.nasa.gov/citations/20000034897).
#
# **Exercise.** Why is the saving so small? Replace $D(L)$ by its tangent, of slope $\tan\varepsilon^*$ at the best angle $\varepsilon^*$. Then
# $F(\cos\varepsilon + \tan\varepsilon^* \sin\varepsilon)$ is constant, so that $F$ is proportional to $1 / \cos(\varepsilon - \varepsilon^*)$. How much does a
# tilt of 4 deg from the body axis to the best angle save?

# %%
answer = 100 * (1 - math.cos(math.radians(4.0)))
print(f"{answer:.2f} %")
for _, rows in table.groupby("case"):
    saved = 100 * (1 - rows.thrust_lb.min() / rows.thrust_lb.iloc[0])
    assert abs(answer - saved) < 0.03

# %% [markdown]
# ## In short
#
# - Tilted thrust reduces drag, until the thrust lost along the path exceeds the saving.
# - The minimum thrust is at about 4 deg in both conditions, and the saving is small.
# - The balance of forces gives the same angle within 1 deg, the effect of the thrust's moment.
#
# Next: [the trim envelope](09_envelope.ipynb).
