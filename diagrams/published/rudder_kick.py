"""Rudder kick of an airliner: aileron against rudder, towards a steady sideslip.

A 737 at 1000 ft and 200 KCAS. The aileron command goes to 1 (right) and the rudder command to 0.92
in 3 s, both on top of their trimmed values, and stay there: crossed controls, as a pilot flies a
steady-heading sideslip.

Expected: the sideslip angle overshoots to 14.8 deg at 4.2 s and stays near 13.5 deg. The bank
settles more slowly: 18.7 deg after 20 s, the end of the published flight, with a heading of 339.5
deg, and 23.3 deg after 40 s. The heading falls to 338.7 deg, then turns back. (The figure draws it
from 0 downwards, without the jump to 360.)

Source: notebook 7 of the published JSBSim/PathSim notebooks, and RudderKick.py of JSBSim. Alpha is
limited to -4 to 12 deg, as published.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, RampSource

DURATION = 40.0  # s

aileron = RampSource(final=1.0, start=0.0, rise_time=3.0)
rudder = RampSource(final=0.92, start=0.0, rise_time=3.0)
aircraft = Aircraft(
    aircraft="737",
    altitude=1000.0,
    speed=200.0,
    setup={
        "aero/alpha-min-rad": -0.06981317007977318,
        "aero/alpha-max-rad": 0.20943951023931953,
    },
    solver="jsbsim",
)
commands = Scope(labels=["aileron command [-]", "rudder command [-]"])
response = Scope(labels=["sideslip angle [deg]", "roll angle [deg]"])
heading = Scope(labels=["heading [deg]"])

sim = Simulation(
    [aileron, rudder, aircraft, commands, response, heading],
    [
        Connection(aileron, aircraft["aileron"], commands[0]),
        Connection(rudder, aircraft["rudder"], commands[1]),
        Connection(aircraft["beta"], response[0]),
        Connection(aircraft["phi"], response[1]),
        Connection(aircraft["psi"], heading[0]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(commands, response, heading, title="737: rudder kick at 200 KCAS")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, beta = signal(response, "sideslip angle")
    print(
        f"sideslip angle at most {beta.max():.2f} deg, at {time[beta.argmax()]:.2f} s; "
        f"{beta[-1]:.2f} deg after {sim.time:.4g} s"
    )
    print(
        f"roll angle {aircraft.outputs['phi']:.1f} deg, heading {aircraft.outputs['psi']:.1f} deg"
    )
    show(figure(), "rudder_kick")
