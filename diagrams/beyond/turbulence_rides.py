"""Turbulence: a light aircraft with controls fixed, and on autopilot.

Two Cessna 172s at 5000 ft and 90 KCAS in moderate Dryden turbulence of MIL-F-8785C. One has its
controls fixed, the other holds its altitude, heading and airspeed. Both turbulence blocks have the
same seed, so that the aircraft meet the same air; each follows its own aircraft's height, airspeed
and heading.

Expected: with the controls fixed the aircraft wanders from 4730 to 5783 ft; on autopilot it stays
within 48 ft of 5000 ft. The ride is hardly smoother, 0.20 and 0.18 g rms: the autopilot damps the
short period near 1 Hz, but holding the altitude adds to nz from 0.1 to 0.5 Hz. Above 2 Hz both are
the same.

Source: our own; MIL-F-8785C, 3.7.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, Autopilot, DrydenTurbulence

DURATION = 120.0  # s

held = Aircraft("c172p", altitude=5000.0, speed=90.0)
air_of_held = DrydenTurbulence(severity="moderate", span=35.8, seed=4)
flown = Aircraft("c172p", altitude=5000.0, speed=90.0)
air_of_flown = DrydenTurbulence(severity="moderate", span=35.8, seed=4)
autopilot = Autopilot(gains="c172p")
altitude = Scope(labels=["controls fixed [ft]", "autopilot [ft]"])
load_factor = Scope(labels=["controls fixed [g]", "autopilot [g]"])
gust = Scope(labels=["downward velocity [ft/s]"])

WIND = ["wind_north", "wind_east", "wind_down"]
FLOWN = ["theta", "phi", "psi", "p", "q", "r", "h", "hdot", "vc", "elev_sat", "ail_sat", "thr_sat"]
FLOWN += ["alpha", "vt", "nx", "nz"]
COMMANDS = ["elevator", "aileron", "rudder", "throttle"]

ports_of_held = Interface()
ports_of_held.register_port_map({"h": 0, "nz": 1}, {})
controls_fixed = Subsystem(
    [ports_of_held, held, air_of_held],
    [
        Connection(held["h", "vt", "psi"], air_of_held["h", "vt", "psi"]),
        Connection(air_of_held["north", "east", "down"], held[WIND]),
        Connection(held["h", "nz"], ports_of_held["h", "nz"]),
    ],
)
ports_of_flown = Interface()
ports_of_flown.register_port_map({"h": 0, "nz": 1, "gust": 2}, {})
on_autopilot = Subsystem(
    [ports_of_flown, flown, air_of_flown, autopilot],
    [
        Connection(flown["h", "vt", "psi"], air_of_flown["h", "vt", "psi"]),
        Connection(air_of_flown["north", "east", "down"], flown[WIND]),
        Connection(flown[FLOWN], autopilot[FLOWN]),
        Connection(autopilot[COMMANDS], flown[COMMANDS]),
        Connection(flown["h", "nz"], ports_of_flown["h", "nz"]),
        Connection(air_of_flown["down"], ports_of_flown["gust"]),
    ],
)

sim = Simulation(
    [controls_fixed, on_autopilot, altitude, load_factor, gust],
    [
        Connection(controls_fixed["h"], altitude[0]),
        Connection(on_autopilot["h"], altitude[1]),
        Connection(controls_fixed["nz"], load_factor[0]),
        Connection(on_autopilot["nz"], load_factor[1]),
        Connection(on_autopilot["gust"], gust),
    ],
    dt=1 / 120,
    log=False,
)


def spectra():
    """Frequencies in Hz and the power spectral densities of nz in g2/Hz, of both aircraft."""
    from scipy.signal import welch

    time, nz = load_factor.read()
    # trimmed in still air, they meet the turbulence as a step
    settled = nz[:, time > min(5.0, time[-1] / 2)]
    return welch(settled, fs=1 / sim.dt, nperseg=min(2400, settled.shape[1]))


def figure():
    from pathsim_jsbsim_blocks.plots import subplots

    time, h = altitude.read()
    _, nz = load_factor.read()
    frequency, densities = spectra()
    drawing, (above, middle, below) = subplots(3, 1, layout="constrained", figsize=(9, 9))
    for label, color, x, n in zip(
        ("controls fixed", "autopilot"), ("C0", "C1"), h, nz, strict=True
    ):
        above.plot(time, x, color, label=label)
        middle.plot(time, n, color, linewidth=1.2, label=label)
    for label, color, density in zip(
        ("controls fixed", "autopilot"), ("C0", "C1"), densities, strict=True
    ):
        below.loglog(frequency, density, color, label=label)
    above.set_ylabel("altitude [ft]")
    above.set_xlabel("time [s]")
    above.set_xlim(0.0, DURATION)
    above.legend(loc="upper left", fontsize="small")
    middle.set_ylabel("load factor nz [g]")
    middle.set_xlabel("time [s]")
    middle.set_xlim(60.0, 68.0)
    middle.set_ylim(0.2, 1.8)
    below.set_xlim(0.05, 10.0)
    below.set_ylim(1e-5, 1.0)
    below.set_xlabel("frequency [Hz]")
    below.set_ylabel("PSD of nz [g²/Hz]")
    for ax in (above, middle, below):
        ax.grid(alpha=0.4)
    drawing.suptitle("Cessna 172 in moderate turbulence, 5000 ft, 90 KCAS")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show, signal

    sim.run(DURATION)
    time, nz = load_factor.read()
    _, h = altitude.read()
    start = min(5.0, time[-1] / 2)
    settled = time > start
    for label, x, n in zip(("controls fixed", "autopilot"), h, nz, strict=True):
        print(
            f"{label}: altitude from {x.min():.0f} to {x.max():.0f} ft, "
            f"nz after {start:.4g} s {n[settled].std():.3f} g rms, "
            f"from {n[settled].min():.2f} to {n[settled].max():.2f}"
        )
    _, w = signal(gust, "downward velocity")
    print(f"vertical velocity of the air: {(w**2).mean() ** 0.5:.1f} ft/s rms")
    show(figure(), "turbulence_rides")
