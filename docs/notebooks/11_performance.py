# %% [markdown]
# # 11. Performance charts
#
# What can the Cessna 172P do, and is it what its handbook says? One function trims it at full throttle, with the throttle
# closed and in level flight, over all airspeeds, and flies a sample of what it finds.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# At constant airspeed $V$ the power left over after level flight raises the weight $W$; with the throttle closed the glide
# ratio is $L/D$:
#
# $$\dot h = V \sin\gamma = \frac{(T - D)\,V}{W}, \qquad -\frac{1}{\tan\gamma} = \frac{L}{D}$$

# %%
from pathsim_jsbsim_blocks import studies

table = studies.performance_table(
    "c172p", altitudes=[0, 10000], flaps=[0, 1], progress=False
)
studies.performance_chart(table)

# %% [markdown]
# Each row of the table is a value with its condition. Of the best values, `flown` is what 60 s of flight with controls fixed
# find, and `reason` says what limits a value:

# %%
best = table[table.flown.notna() & (table.quantity != "specific range")]
best[
    ["quantity", "altitude_ft", "value", "unit", "difference_percent"]
].round(2)

# %% [markdown]
# ## Against the handbook
#
# The specifications of the Pilot's Operating Handbook of 1982 (section 1) at 2400 lb, as a table. From a file,
# `pathsim-jsbsim chart c172p --handbook FILE.csv` does the same.

# %%
import pandas as pd

handbook = pd.DataFrame(
    [
        ("stall speed", 0, 2400, 0, 51, "KCAS"),
        ("stall speed", 0, 2400, 1, 46, "KCAS"),
        ("highest level speed", 0, 2400, 0, 123, "KTAS"),
        ("best rate of climb", 0, 2400, 0, 700, "ft/min"),
    ],
    columns=[
        "quantity",
        "altitude_ft",
        "weight_lb",
        "flaps_norm",
        "value",
        "unit",
    ],
).assign(source="section 1, specifications")
compared, at_2400 = studies.against_handbook(
    "c172p", handbook, progress=False
)
compared[
    ["quantity", "flaps_norm", "value", "model", "difference_percent"]
].round(1)

# %% [markdown]
# ## Where the differences come from
#
# The terms of lift, drag and thrust stand in the same table. A rate of climb is excess power over weight:

# %%
for source, rate in (("handbook", 700), ("model", compared.model[3])):
    print(f"{source}: {2400 * rate / 33000:.0f} hp of excess power")
compared.loc[
    3, ["lift slope", "drag at zero lift", "full thrust at Vy"]
].astype(float).round(3)

# %% [markdown]
# The aircraft has 160 hp. The model's engine at sea level:

# %%
from pathsim_jsbsim_blocks.flight import Airframe, TrimCondition, trim

plane = Airframe("c172p")
condition = TrimCondition(altitude=100, speed=76, throttle=1.0)
trim(plane, condition, hint=False)
print(f"{plane.fdm['propulsion/engine/power-hp']:.0f} hp")

# %% [markdown]
# That explains climb and level speed. The stall is faster because the model's wing, trimmed, has a smaller largest lift
# coefficient $C_L = 2W / (\rho_0 V^2 S)$ than the handbook's speeds ask for; `reason` says what limits its glides:

# %%
stalls = compared[compared.quantity == "stall speed"]
for row in stalls.itertuples():
    for source, knots in (("handbook", row.value), ("model", row.model)):
        pressure = 0.5 * 0.0023769 * (1.68781 * knots) ** 2
        lift = 2400 / (pressure * 174)
        print(f"flaps {row.flaps_norm:.0f}, {source}: CL {lift:.2f}")
print(
    f"the model's glides are limited by: {', '.join(sorted(set(stalls.reason)))}"
)

# %% [markdown]
# [Performance charts](../performance.md) defines each value. This is the end of the course; from here on
# [a controller](../tutorial.md#a-controller-of-your-own) and [a study](../studies.md#a-study-of-your-own-aircraft) of your own.
