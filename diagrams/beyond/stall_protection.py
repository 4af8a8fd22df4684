"""Stall protection: a Cessna 172 is asked for 55 KCAS, with and without the port alpha.

Two Cessnas at 5000 ft and 90 KCAS under the same ``Autopilot``: altitude held, airspeed asked for
35 kt less at 10 s. The wire to the port ``alpha`` is all that differs. Without it the autopilot
sees only the airspeed: it pulls to hold the altitude behind the power curve, the wing stalls, and
in the stall the airspeed is above the reference again, so it goes on pulling. With it the pitch
reference is bounded by the angle of attack, and the power comes up in time.

Expected: with alpha, at least 52.9 kt, alpha at most 10.5 deg, altitude within 12 ft; the speed
creeps up to the 55 kt. Without it, 46.5 kt and 24.2 deg, and 4078 ft are lost in 200 s.

Source: our own.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, Autopilot

DURATION = 200.0  # s

slower = StepSource(amplitude=-35.0, tau=10.0)
protected = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
watching = Autopilot(gains="c172p")
plain = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
blind = Autopilot(gains="c172p")
speeds = Scope(labels=["airspeed, alpha wired [kt]", "airspeed, alpha not wired [kt]"])
angles = Scope(
    labels=["angle of attack, alpha wired [deg]", "angle of attack, alpha not wired [deg]"]
)
heights = Scope(labels=["altitude, alpha wired [ft]", "altitude, alpha not wired [ft]"])

sim = Simulation(
    [slower, protected, watching, plain, blind, speeds, angles, heights],
    [
        Connection(slower, watching["vc_ref"], blind["vc_ref"]),
        Connection(protected["theta"], watching["theta"]),
        Connection(protected["phi"], watching["phi"]),
        Connection(protected["psi"], watching["psi"]),
        Connection(protected["p"], watching["p"]),
        Connection(protected["q"], watching["q"]),
        Connection(protected["r"], watching["r"]),
        Connection(protected["h"], watching["h"], heights[0]),
        Connection(protected["hdot"], watching["hdot"]),
        Connection(protected["vc"], watching["vc"], speeds[0]),
        Connection(protected["alpha"], watching["alpha"], angles[0]),
        Connection(protected["elev_sat"], watching["elev_sat"]),
        Connection(protected["ail_sat"], watching["ail_sat"]),
        Connection(protected["thr_sat"], watching["thr_sat"]),
        Connection(watching["elevator"], protected["elevator"]),
        Connection(watching["aileron"], protected["aileron"]),
        Connection(watching["rudder"], protected["rudder"]),
        Connection(watching["throttle"], protected["throttle"]),
        Connection(plain["theta"], blind["theta"]),
        Connection(plain["phi"], blind["phi"]),
        Connection(plain["psi"], blind["psi"]),
        Connection(plain["p"], blind["p"]),
        Connection(plain["q"], blind["q"]),
        Connection(plain["r"], blind["r"]),
        Connection(plain["h"], blind["h"], heights[1]),
        Connection(plain["hdot"], blind["hdot"]),
        Connection(plain["vc"], blind["vc"], speeds[1]),
        Connection(plain["alpha"], angles[1]),
        Connection(plain["elev_sat"], blind["elev_sat"]),
        Connection(plain["ail_sat"], blind["ail_sat"]),
        Connection(plain["thr_sat"], blind["thr_sat"]),
        Connection(blind["elevator"], plain["elevator"]),
        Connection(blind["aileron"], plain["aileron"]),
        Connection(blind["rudder"], plain["rudder"]),
        Connection(blind["throttle"], plain["throttle"]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import time_histories

    return time_histories(
        speeds,
        angles,
        heights,
        title="c172p: 55 KCAS asked for, with and without the port alpha",
        references={"airspeed, alpha wired": lambda time: 90.0 - 35.0 * (time >= 10.0)},
    )


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    for name in ("alpha wired", "alpha not wired"):
        _, vc = signal(speeds, f"airspeed, {name}")
        _, alpha = signal(angles, f"angle of attack, {name}")
        _, h = signal(heights, f"altitude, {name}")
        print(
            f"{name}: {vc.min():.1f} kt at the least, {vc[-1]:.1f} kt at the end; alpha at most "
            f"{alpha.max():.1f} deg; altitude {h.min():.0f} to {h.max():.0f} ft"
        )
    show(figure(), "stall_protection")
