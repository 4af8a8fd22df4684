"""Stall protection: a Cessna 172 commanded to 52 KCAS, with and without the port alpha.

Two Cessnas at 5000 ft and 90 KCAS under the same ``Autopilot``: altitude held, commanded airspeed
38 kt lower at 10 s. They differ only in the connection to the port ``alpha``. Without it the
autopilot measures only the airspeed: it pulls to hold the altitude behind the power curve, past the
angle of maximum lift, 16.1 deg. With it the angle of attack limits the pitch reference, and the
throttle opens in time.

Expected: with alpha, at least 50.6 kt, alpha at most 12.5 deg, altitude within 14.5 ft, and 51.9 kt
at the end. Without the connection 46.3 kt and 25.3 deg: the aircraft stalls, stays stalled, and has
lost 4351 ft at the end. With a step of -35 kt it just recovers.

Source: our own.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope, StepSource

from pathsim_jsbsim_blocks import Aircraft, Autopilot

DURATION = 200.0  # s

slower = StepSource(amplitude=-38.0, tau=10.0)
protected = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
watching = Autopilot(gains="c172p")
plain = Aircraft(aircraft="c172p", altitude=5000.0, speed=90.0)
blind = Autopilot(gains="c172p")
speeds = Scope(labels=["airspeed, alpha wired [kt]", "airspeed, alpha not wired [kt]"])
angles = Scope(
    labels=["angle of attack, alpha wired [deg]", "angle of attack, alpha not wired [deg]"]
)
heights = Scope(labels=["altitude, alpha wired [ft]", "altitude, alpha not wired [ft]"])

FLOWN = ["theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "elev_sat", "ail_sat", "thr_sat"]
COMMANDS = ["elevator", "aileron", "rudder", "throttle"]
SHOWN = ["vc", "alpha", "h"]


def loop(plane, autopilot, flown):
    """A plane with its autopilot, which measures what is listed."""
    ports = Interface()
    ports.register_port_map({"vc": 0, "alpha": 1, "h": 2}, {"vc_ref": 0})
    return Subsystem(
        [ports, plane, autopilot],
        [
            Connection(ports["vc_ref"], autopilot["vc_ref"]),
            Connection(plane[flown], autopilot[flown]),
            Connection(autopilot[COMMANDS], plane[COMMANDS]),
            Connection(plane[SHOWN], ports[SHOWN]),
        ],
    )


alpha_wired = loop(protected, watching, [*FLOWN, "alpha"])
not_wired = loop(plain, blind, FLOWN)

sim = Simulation(
    [slower, alpha_wired, not_wired, speeds, angles, heights],
    [
        Connection(slower, alpha_wired, not_wired),
        Connection(alpha_wired["vc"], speeds[0]),
        Connection(not_wired["vc"], speeds[1]),
        Connection(alpha_wired["alpha"], angles[0]),
        Connection(not_wired["alpha"], angles[1]),
        Connection(alpha_wired["h"], heights[0]),
        Connection(not_wired["h"], heights[1]),
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
        title="c172p: 52 KCAS commanded, with and without the port alpha",
        references={"airspeed, alpha wired": lambda time: 90.0 - 38.0 * (time >= 10.0)},
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
