"""Autothrottle of a Cessna 172: 10 kt faster, at the same altitude.

c172p at 5000 ft and 90 KCAS. The reference of ``AirspeedHold`` is the initial airspeed plus its
port, which steps by 10 kt at 5 s; it moves at 2.7 kt/s. ``AltitudeHold`` lowers the nose as the
aircraft gets faster, ``RollHold`` keeps the wings level.

Expected: within 0.5 kt of 100 KCAS 11.9 s after the step, altitude within 2.4 ft.

Source: our own, on the aircraft and the condition of the published pitch hold.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, AltitudeHold, RollHold

DURATION = 45.0  # s

# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
faster = StepSource(amplitude=10.0, tau=5.0)
airspeed_hold = AirspeedHold(gains="c172p")
altitude_hold = AltitudeHold(gains="c172p")
leveller = RollHold(gains="c172p", phi_ref=0.0)
speed = Scope(labels=["calibrated airspeed [kt]", "reference [kt]"])
flight = Scope(labels=["throttle increment [-]", "altitude [ft]", "pitch angle [deg]"])

sim = Simulation(
    [aircraft, faster, airspeed_hold, altitude_hold, leveller, speed, flight],
    [
        Connection(aircraft["vc"], airspeed_hold["vc"], speed[0]),
        Connection(faster, airspeed_hold["vc_ref"]),
        Connection(aircraft["thr_sat"], airspeed_hold["thr_sat"]),
        Connection(aircraft[MOTION], airspeed_hold[MOTION]),
        Connection(altitude_hold["hdot_cmd"], airspeed_hold["hdot_cmd"]),
        Connection(airspeed_hold["throttle"], aircraft["throttle"], flight[0]),
        Connection(airspeed_hold["vc_cmd"], speed[1]),
        Connection(aircraft["h"], altitude_hold["h"], flight[1]),
        Connection(aircraft["hdot"], altitude_hold["hdot"], airspeed_hold["hdot"]),
        Connection(aircraft["theta"], altitude_hold["theta"], flight[2]),
        Connection(aircraft["q"], altitude_hold["q"]),
        Connection(altitude_hold["elevator"], aircraft["elevator"]),
        Connection(aircraft["phi"], leveller["phi"]),
        Connection(aircraft["p"], leveller["p"]),
        Connection(leveller["aileron"], aircraft["aileron"]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(speed, flight, title="c172p: autothrottle, 10 kt faster")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show, signal

    sim.run(DURATION)
    time, airspeed = signal(speed, "calibrated airspeed")
    _, h = signal(flight, "altitude")
    print(
        f"calibrated airspeed {settling(time, airspeed, 100.0, 0.5, 'kt', after=faster.tau[0])}; "
        f"altitude {h.min():.1f} to {h.max():.1f} ft"
    )
    show(figure(), "airspeed_hold")
