"""A minute of trimmed flight: what "trimmed" means in a nonlinear model.

A Cessna 172 at 5000 ft and 90 KCAS, heading 90 deg, with the controls fixed at trim for 60 s.

Expected: altitude within 1 ft, airspeed within 0.05 kt, a straight track to the east. The ailerons
balance the propeller's torque, and a bank of 0.05 deg the side force that comes with the rudder.

Source: notebook 2 of the published JSBSim/PathSim notebooks; the numbers are those of a plain
JSBSim loop.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft

DURATION = 60.0  # s

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0, heading=90.0, solver="jsbsim")
flight = Scope(labels=["altitude [ft]", "calibrated airspeed [kt]"])
attitude = Scope(labels=["angle of attack [deg]", "pitch angle [deg]", "roll angle [deg]"])
heading = Scope(labels=["heading [deg]"])
load = Scope(labels=["load factor nx [g]", "load factor nz [g]"])
track = Scope(labels=["latitude [deg]", "longitude [deg]"])

sim = Simulation(
    [aircraft, flight, attitude, heading, load, track],
    [
        Connection(aircraft["h"], flight[0]),
        Connection(aircraft["vc"], flight[1]),
        Connection(aircraft["alpha"], attitude[0]),
        Connection(aircraft["theta"], attitude[1]),
        Connection(aircraft["phi"], attitude[2]),
        Connection(aircraft["psi"], heading[0]),
        Connection(aircraft["nx"], load[0]),
        Connection(aircraft["nz"], load[1]),
        Connection(aircraft["lat"], track[0]),
        Connection(aircraft["lon"], track[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(flight, attitude, heading, load, title="c172p: trimmed flight")


def figure_track():
    from pathsim_jsbsim_blocks.plots import ground_track

    time, (latitude, longitude) = track.read()
    return ground_track(time, latitude, longitude, title="c172p: trimmed flight, ground track")


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    _, altitude = signal(flight, "altitude")
    _, airspeed = signal(flight, "calibrated airspeed")
    print(
        f"altitude {altitude.min():.2f} to {altitude.max():.2f} ft, "
        f"airspeed {airspeed.min():.3f} to {airspeed.max():.3f} KCAS, "
        f"heading {aircraft.outputs['psi']:.3f} deg after {sim.time:.4g} s"
    )
    show(figure(), "trimmed_flight")
    show(figure_track(), "trimmed_flight_track")
