"""Pitch hold of a Cessna 172: from its trim to the reference ``theta_ref``, where it stays.

c172p at 5000 ft and 90 KCAS. ``PitchHold`` moves its reference from the trimmed pitch angle to
``theta_ref`` and holds it with the elevator; the throttle stays at its trim setting.

Expected: with ``theta_ref=3`` the pitch angle is within 0.05 deg of it from 1.8 s on, overshoot
0.025 deg; in 30 s the aircraft climbs 93 ft and slows down to 83 KCAS. A nose-up elevator command
is negative.

Source: notebook 5 of the published JSBSim/PathSim notebooks. Its hold has the wrong sign (positive
elevator is nose **down**) and too small a gain: it never holds 3 deg. The scope of its commands is
mislabelled: "elevator_cmd" is the pitch error in degrees, "pitch_error" the constant reference of
3.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, PitchHold

DURATION = 30.0  # s

aircraft = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0, solver="jsbsim")
hold = PitchHold(gains="c172p", theta_ref=3.0)
pitch = Scope(labels=["pitch angle [deg]", "reference [deg]", "angle of attack [deg]"])
flight = Scope(labels=["altitude [ft]", "calibrated airspeed [kt]", "elevator increment [-]"])

sim = Simulation(
    [aircraft, hold, pitch, flight],
    [
        Connection(aircraft["theta"], hold["theta"], pitch[0]),
        Connection(aircraft["q"], hold["q"]),
        Connection(aircraft["elev_sat"], hold["elev_sat"]),
        Connection(hold["elevator"], aircraft["elevator"], flight[2]),
        Connection(hold["theta_cmd"], pitch[1]),
        Connection(aircraft["alpha"], pitch[2]),
        Connection(aircraft["h"], flight[0]),
        Connection(aircraft["vc"], flight[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import signal, time_histories

    _, reference = signal(pitch, "reference")
    drawing = time_histories(
        pitch, flight, title=f"{aircraft.aircraft}: pitch hold at {reference[-1]:g} deg"
    )
    # the trimmed state, from which the hold departs
    for ax, value, place in zip(
        drawing.axes[:3],
        (aircraft.trim.theta, aircraft.trim.altitude, aircraft.trim.speed),
        ((0.3, 0.58), "upper left", "center right"),
        strict=True,
    ):
        ax.axhline(value, color="0.4", linestyle=":", linewidth=1.2, label="trim")
        ax.legend(loc=place, ncols=4, fontsize="small")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import settling, show, signal

    sim.run(DURATION)
    time, theta = signal(pitch, "pitch angle")
    target = theta[0] if hold.theta_ref is None else hold.theta_ref
    _, h = signal(flight, "altitude")
    _, airspeed = signal(flight, "calibrated airspeed")
    print(
        f"pitch angle {theta[-1]:.3f} deg after {sim.time:.4g} s, "
        f"{settling(time, theta, target, 0.05, 'deg')}, at most {theta.max():.3f} deg; "
        f"climbed {h[-1] - h[0]:.0f} ft, {airspeed[-1]:.1f} KCAS"
    )
    show(figure(), "pitch_hold")
