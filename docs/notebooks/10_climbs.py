# %% [markdown]
# # 10. Climbs
#
# An A-4 is trimmed at 1000 ft for a climb at 300 knots and 5 deg. What becomes of it in thinner air?

# %%
from pathsim_jsbsim_blocks import fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.plots import against

held = load_diagram("fixed_trim_climb")
fly(held.sim, held.DURATION, progress=False)
scheduled = load_diagram("scheduled_climb")
fly(scheduled.sim, scheduled.DURATION, progress=False)
against("altitude", {"first trim held": held.flight, "by schedule": scheduled.flight})

# %% [markdown]
# `fly` runs a diagram as `sim.run` does, in less time per step. With the first trim held the path flattens. The schedule
# moves throttle and pitch trim with the altitude, by the trims
# of a study:

# %%
from pathsim_jsbsim_blocks import studies

table = studies.climb_schedule(jobs=1, progress=False)
studies.climb_chart(table)

# %%
for flight in (held, scheduled):
    _, (h, speed, gamma) = flight.flight.read()
    print(
        f"{h[-1]:9.1f} ft after {flight.sim.time:5.1f} s at {speed[-1]:.1f} KCAS and {gamma[-1]:.2f} deg"
    )

# %% [markdown]
# ## As airliners climb
#
# 250 knots of calibrated airspeed up to the crossover altitude, then Mach 0.70:

# %%
airliner = load_diagram("constant_cas_climb")
airliner.sim.run(airliner.DURATION)
airliner.figure()

# %% [markdown]
# [Forces in a climb](../concepts/forces-in-a-climb.md) has the equations. This is the end of the course; from here on
# [a controller](../own-controller.md) and [a study](../own-study.md) of your own.
