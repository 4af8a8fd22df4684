# %% [markdown]
# # 5. A pitch hold
#
# A Cessna 172 raises its nose from the trimmed 1.3 deg to 3 deg and holds it there.

# %%
from pathsim_jsbsim_blocks.catalogue import load_diagram

diagram = load_diagram("pitch_hold")
diagram.sim.run(diagram.DURATION)
diagram.figure()

# %% [markdown]
# The dotted lines are the trim. The aircraft climbs, and slows down: the throttle does not move.
#
# A parameter changed in flight takes effect at the next sample:

# %%
diagram.hold.theta_ref = 0.0
diagram.sim.run(15.0)
print(f"{diagram.aircraft.outputs['theta']:.3f} deg, {diagram.aircraft.outputs['hdot']:.1f} ft/s")

# %% [markdown]
# ## The sign
#
# A positive elevator command moves the nose **down**. A proportional controller with the wrong sign drives the pitch
# angle away from its reference:

# %%
from pathsim import Connection, Simulation
from pathsim.blocks import Adder, Amplifier, Constant, Scope

from pathsim_jsbsim_blocks import Aircraft


def flight(gain):
    plane, reference, error = Aircraft("c172p", altitude=5000, speed=90), Constant(3.0), Adder("+-")
    controller = Amplifier(gain)
    scope = Scope(labels=["pitch angle [deg]"])
    sim = Simulation(
        [plane, reference, error, controller, scope],
        [
            Connection(reference, error[0]),
            Connection(plane["theta"], error[1], scope),
            Connection(error, controller),
            Connection(controller, plane["elevator"]),
        ],
        dt=1 / 120,
        log=False,
    )
    sim.run(8.0)
    return scope.read()[1][0]


for gain in (0.01, -0.01):
    theta = flight(gain)
    print(f"gain {gain:+.2f}: {theta[-1]:5.2f} deg after 8 s")

# %% [markdown]
# With the right sign it comes nearer, and with so small a gain never there: that takes the integral action of
# [`PitchHold`](../autopilots.md). Next: [angle of attack against airspeed](06_alpha.ipynb).
