# %% [markdown]
# # 11. Performance charts
#
# One function trims the Cessna 172P at full throttle, with the throttle closed and in level
# flight, over all airspeeds, and flies a sample of the results.
#
# *Aim:* to read performance charts, and to judge the model behind them. *Assumed:* chapters 6, 9 and 10. *Time:* 30 minutes.
#
# *Run this chapter:* in a checkout, `pip install ".[course]"`, then `pathsim-jsbsim course`.
#
# At constant true airspeed $V$ the excess power raises the weight $W$; with the throttle closed the glide
# ratio is $L/D$:
#
# $$\dot h = V \sin\gamma = \frac{(T - D)\,V}{W}, \qquad -\frac{1}{\tan\gamma} = \frac{L}{D}$$
#
# **Predict.** At 10,000 ft, is the best rate of climb more or less than half of that at sea level? The next cell has the answer.

# %%
from pathsim_jsbsim_blocks import studies

table = studies.performance_table(
    "c172p", altitudes=[0, 10000], flaps=[0, 1], progress=False
)
studies.performance_chart(
    table, charts=["speeds", "climb", "glide", "turn"]
)

# %% [markdown]
# **Answer.** More than half: 941 of 1651 ft/min.
#
# These are four of ten panels; without `charts` all are drawn. Each row of the table is a value with its condition.
# For the best values, `flown` is the value measured in a 60 s flight with fixed controls; `reason` names what limits a value:

# %%
best = table[table.flown.notna() & (table.quantity != "specific range")]
best[
    ["quantity", "altitude_ft", "value", "unit", "difference_percent"]
].round(2)

# %% [markdown]
# ## Origin of the values
#
# A rate of climb is excess power over weight. For the model at sea level:

# %%
sea = table[(table.altitude_ft == 0) & (table.flaps_norm == 0)]
climb = sea[sea.quantity == "best rate of climb"].iloc[0]
power = climb.weight_lb * climb.value / 33000
print(f"{climb.value:.0f} ft/min take {power:.0f} hp of excess power")

# %% [markdown]
# The aircraft has 160 hp; the model's engine gives more, so the model climbs better than the aircraft:

# %%
from pathsim_jsbsim_blocks.flight import Airframe, TrimCondition, trim

plane = Airframe("c172p")
condition = TrimCondition(altitude=100, speed=76, throttle=1.0)
trim(plane, condition, hint=False)
print(f"{plane.fdm['propulsion/engine/power-hp']:.0f} hp")

# %% [markdown]
# A stall speed gives the maximum lift coefficient in trim, $C_L = 2W / (\rho_0 V^2 S)$; `reason` names its limit:

# %%
stalls = table[(table.quantity == "stall speed") & (table.altitude_ft == 0)]
for row in stalls.itertuples():
    pressure = 0.5 * 0.0023769 * (1.68781 * row.value) ** 2
    lift = row.weight_lb / (pressure * 174)
    case = f"{row.weight_lb:.0f} lb, flaps {row.flaps_norm:.0f}"
    print(f"{case}: CL {lift:.2f}, {row.reason}")

# %% [markdown]
# **Exercise.** Estimate the service ceiling, at which the best rate of climb is 100 ft/min, from the rates at sea level and 10,000 ft. The
# table has the value that trims find.

# %%
rates = table[table.quantity == "best rate of climb"].value
answer = 10000 * (rates.iloc[0] - 100) / (rates.iloc[0] - rates.iloc[1])
ceiling = table[table.quantity == "service ceiling"].value.iloc[0]
print(f"{answer:,.0f} ft by the straight line, {ceiling:,.0f} ft by trims")
assert abs(answer / ceiling - 1) < 0.1

# %% [markdown]
# ## In short
#
# - All charts are trims: at full throttle, with the throttle closed, in level flight.
# - The best values are flown, and each has the reason for its limit.
# - The charts show the model, not the aircraft: this engine is too strong.
#
# [Performance charts](../performance.md) defines each value. This is the end of the course. Next, write
# [a controller](../tutorial.md#6-a-controller-of-your-own) or [a study](../studies.md#a-study-of-your-own-aircraft) of your own.
