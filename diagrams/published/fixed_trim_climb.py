"""Climb with the first trim held: airspeed and rate of climb decay.

An A-4 trimmed at 1000 ft for a climb at 300 KCAS and 5 deg; throttle and pitch trim then stay fixed
while the air grows thinner.

Expected: after 1 min the path has flattened to 3.9 deg; after 15 min the aircraft is at 14,215 ft,
288 KCAS and 0.4 deg. A one-hour run would stop at 20,000 ft, after 59 minutes and at 267 KCAS.

Source: notebook 10 of the published JSBSim/PathSim notebooks; the cure is the diagram
``scheduled_climb``. Alpha is limited to -4 to 12 deg, as published.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope
from pathsim.events import Condition

from pathsim_jsbsim_blocks import Aircraft

DURATION = 900.0  # s

aircraft = Aircraft(
    aircraft="A4",
    altitude=1000.0,
    speed=300.0,
    gamma=5.0,
    gear=1.0,
    setup={
        "aero/alpha-min-rad": -0.06981317007977318,
        "aero/alpha-max-rad": 0.20943951023931953,
    },
    solver="jsbsim",
)
flight = Scope(
    sampling_period=1.0,
    labels=["altitude [ft]", "calibrated airspeed [kt]", "flight path angle [deg]"],
)
top = Condition(
    func_evt=lambda t: aircraft.outputs["h"] >= 20000.0,
    func_act=lambda t: sim.stop(),
)

sim = Simulation(
    [aircraft, flight],
    [
        Connection(aircraft["h"], flight[0]),
        Connection(aircraft["vc"], flight[1]),
        Connection(aircraft["gamma"], flight[2]),
    ],
    [top],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(flight, title="A-4: climb with the first trim held")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    print(
        f"{aircraft.outputs['h']:.1f} ft after {sim.time:.4g} s, "
        f"at {aircraft.outputs['vc']:.1f} KCAS, "
        f"flight path angle {aircraft.outputs['gamma']:.2f} deg"
    )
    show(figure(), "fixed_trim_climb")
