"""Altitude hold of a Cessna 172: a climb of 500 ft and level-off.

c172p at 5000 ft and 90 KCAS. The reference of ``AltitudeHold`` is the initial altitude plus its
port, which steps by 500 ft at 5 s; ``AirspeedHold`` holds the airspeed in the climb with the
throttle, and ``RollHold`` keeps the wings level.

Expected: a climb at 10 ft/s, within 10 ft of 5500 ft 51.4 s after the step, overshoot 2.1 ft;
airspeed 86.7 to 90.9 KCAS.

Source: our own, on the aircraft and the condition of the published pitch hold.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, AltitudeHold, RollHold

DURATION = 120.0  # s

# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
higher = StepSource(amplitude=500.0, tau=5.0)
altitude_hold = AltitudeHold(gains="c172p")
airspeed_hold = AirspeedHold(gains="c172p")
leveller = RollHold(gains="c172p", phi_ref=0.0)
climb = Scope(
    labels=["altitude [ft]", "rate of climb [ft/s]", "demanded [ft/s]", "calibrated airspeed [kt]"]
)
controls = Scope(labels=["elevator increment [-]", "throttle increment [-]"])

sim = Simulation(
    [aircraft, higher, altitude_hold, airspeed_hold, leveller, climb, controls],
    [
        Connection(aircraft["h"], altitude_hold["h"], climb[0]),
        Connection(aircraft["hdot"], altitude_hold["hdot"], airspeed_hold["hdot"], climb[1]),
        Connection(aircraft["theta"], altitude_hold["theta"]),
        Connection(aircraft["q"], altitude_hold["q"]),
        Connection(higher, altitude_hold["h_ref"]),
        Connection(aircraft["elev_sat"], altitude_hold["elev_sat"]),
        Connection(aircraft["vc"], airspeed_hold["vc"], climb[3]),
        Connection(aircraft["thr_sat"], airspeed_hold["thr_sat"]),
        Connection(aircraft["phi"], leveller["phi"]),
        Connection(aircraft["p"], leveller["p"]),
        Connection(altitude_hold["elevator"], aircraft["elevator"], controls[0]),
        Connection(altitude_hold["hdot_cmd"], airspeed_hold["hdot_cmd"], climb[2]),
        Connection(aircraft[MOTION], airspeed_hold[MOTION]),
        Connection(airspeed_hold["throttle"], aircraft["throttle"], controls[1]),
        Connection(leveller["aileron"], aircraft["aileron"]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        climb,
        controls,
        title="c172p: altitude hold, 500 ft up",
        references={
            "altitude": lambda time: 5000.0 + 500.0 * (time >= 5.0),
            "calibrated airspeed": 90.0,
        },
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show, signal

    sim.run(DURATION)
    time, h = signal(climb, "altitude")
    _, airspeed = signal(climb, "calibrated airspeed")
    print(
        f"altitude {settling(time, h, 5500.0, 10.0, 'ft', after=higher.tau[0])}, "
        f"at most {h.max():.1f} ft; airspeed {airspeed.min():.1f} to {airspeed.max():.1f} KCAS"
    )
    show(figure(), "altitude_hold")
