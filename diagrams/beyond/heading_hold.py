"""Heading hold of a Cessna 172: from 350 to 10 deg, the short way across north.

c172p at 5000 ft and 90 KCAS, heading 350 deg. The reference of ``HeadingHold`` is 10 deg;
``YawDamper``, ``AltitudeHold`` and ``AirspeedHold`` keep the turn coordinated and level. The
heading is plotted from -180 to 180 deg.

Expected: a right turn of 20 deg with a bank of at most 24 deg, heading within 0.5 deg of 10 deg in
12.6 s, altitude within 4.5 ft. The published "10-degree turn" is not such a turn (see
``aileron_turn``).

Source: our own, on the aircraft and the condition of the published pitch hold.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Function, Scope

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, AltitudeHold, HeadingHold, YawDamper

DURATION = 40.0  # s

# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0, heading=350.0)
heading_hold = HeadingHold(gains="c172p", psi_ref=10.0, bank_max=25.0)
yaw_damper = YawDamper(gains="c172p")
altitude_hold = AltitudeHold(gains="c172p")
airspeed_hold = AirspeedHold(gains="c172p")
east_positive = Function(lambda psi: (psi + 180.0) % 360.0 - 180.0)
heading = Scope(labels=["heading [deg]"])
bank = Scope(labels=["roll angle [deg]", "reference [deg]"])
flight = Scope(labels=["altitude [ft]", "calibrated airspeed [kt]", "aileron increment [-]"])

sim = Simulation(
    [
        aircraft,
        heading_hold,
        yaw_damper,
        altitude_hold,
        airspeed_hold,
        east_positive,
        heading,
        bank,
        flight,
    ],
    [
        Connection(aircraft["psi"], heading_hold["psi"], east_positive),
        Connection(east_positive, heading[0]),
        Connection(aircraft["phi"], heading_hold["phi"], bank[0]),
        Connection(aircraft["p"], heading_hold["p"]),
        Connection(aircraft["ail_sat"], heading_hold["ail_sat"]),
        Connection(heading_hold["aileron"], aircraft["aileron"], flight[2]),
        Connection(heading_hold["phi_cmd"], bank[1]),
        Connection(aircraft["r"], yaw_damper["r"]),
        Connection(yaw_damper["rudder"], aircraft["rudder"]),
        Connection(aircraft["h"], altitude_hold["h"], flight[0]),
        Connection(aircraft["hdot"], altitude_hold["hdot"], airspeed_hold["hdot"]),
        Connection(aircraft["theta"], altitude_hold["theta"]),
        Connection(aircraft["q"], altitude_hold["q"]),
        Connection(altitude_hold["elevator"], aircraft["elevator"]),
        Connection(aircraft["vc"], airspeed_hold["vc"], flight[1]),
        Connection(aircraft[MOTION], airspeed_hold[MOTION]),
        Connection(altitude_hold["hdot_cmd"], airspeed_hold["hdot_cmd"]),
        Connection(airspeed_hold["throttle"], aircraft["throttle"]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        heading,
        bank,
        flight,
        title="c172p: heading hold, 350 to 10 deg",
        references={"heading": 10.0},
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show, signal

    sim.run(DURATION)
    time, psi = signal(heading, "heading")
    _, h = signal(flight, "altitude")
    print(
        f"heading {psi[-1]:.2f} deg, {settling(time, psi, 10.0, 0.5, 'deg')}, "
        f"at most {psi.max():.2f} deg; "
        f"altitude {h.min():.1f} to {h.max():.1f} ft"
    )
    show(figure(), "heading_hold")
