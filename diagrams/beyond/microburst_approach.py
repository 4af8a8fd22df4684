"""Microburst on the approach: headwind, downdraft and tailwind in 40 s.

A Boeing 737 on a glide path of 3 deg from 1500 ft at 150 KCAS, gear down, half flaps, holds its
pitch angle and its airspeed. A downburst of Oseguera and Bowles, 30 ft/s at its strongest, lies
12,000 ft ahead. The second aircraft flies the same approach in still air.

Expected: a headwind of 9 ft/s at 36 s, a downdraft of 17 ft/s at 46 s, a tailwind of 26 ft/s at
64 s. The airspeed stays between 142 and 153 KCAS, and still the aircraft ends 469 ft below the
approach in still air, 80 ft above the ground. The F-factor reaches 0.13.

Source: our own; Oseguera, Bowles, NASA TM-100632, 1988. The F-factor is that of Bowles, *Reducing
Windshear Risk Through Airborne Systems Technology*, ICAS 1990: the climb angle in rad that the wind
costs at constant airspeed and thrust.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, Microburst, PitchHold

DURATION = 75.0  # s

# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]

in_burst = Aircraft("737", altitude=1500.0, speed=150.0, gamma=-3.0, gear=1.0, flaps=0.5)
in_calm = Aircraft("737", altitude=1500.0, speed=150.0, gamma=-3.0, gear=1.0, flaps=0.5)
burst = Microburst(lat0=0.0331, lon0=0.0, radius=3000.0, outflow=30.0, height=150.0)
pitch = PitchHold(gains="737")
airspeed = AirspeedHold(gains="737")
flight = Scope(labels=["altitude [ft]", "calibrated airspeed [kt]", "throttle increment [-]"])
wind = Scope(labels=["tailwind [ft/s]", "downdraft [ft/s]", "true airspeed [ft/s]"])
still = Scope(labels=["altitude in still air [ft]"])

ports = Interface()
ports.register_port_map(
    {"h": 0, "vc": 1, "throttle": 2, "north": 3, "down": 4, "vt": 5},
    {},
)
approach = Subsystem(
    [ports, in_burst, burst, pitch, airspeed],
    [
        Connection(in_burst["lat", "lon", "h"], burst["lat", "lon", "h"]),
        Connection(
            burst["north", "east", "down"], in_burst["wind_north", "wind_east", "wind_down"]
        ),
        Connection(in_burst["theta", "q", "elev_sat"], pitch["theta", "q", "elev_sat"]),
        Connection(in_burst["vc", "hdot", "thr_sat"], airspeed["vc", "hdot", "thr_sat"]),
        Connection(in_burst[MOTION], airspeed[MOTION]),
        Connection(pitch["elevator"], in_burst["elevator"]),
        Connection(airspeed["throttle"], in_burst["throttle"], ports["throttle"]),
        Connection(in_burst["h", "vc", "vt"], ports["h", "vc", "vt"]),
        Connection(burst["north", "down"], ports["north", "down"]),
    ],
)

sim = Simulation(
    [approach, in_calm, flight, wind, still],
    [
        Connection(approach["h", "vc", "throttle"], flight[0:3]),
        Connection(approach["north", "down", "vt"], wind[0:3]),
        Connection(in_calm["h"], still),
    ],
    dt=1 / 120,
    log=False,
)


def f_factor():
    """Climb angle in rad that the wind costs: tailwind growing, air sinking."""
    import numpy as np

    time, (tailwind, downdraft, speed) = wind.read()
    return np.gradient(tailwind, time) / 32.174 + downdraft / speed


def figure():
    from pathsim_jsbsim_blocks.plots import subplots

    time, (h, vc, throttle) = flight.read()
    _, (tailwind, downdraft, _) = wind.read()
    _, (h_still,) = still.read()
    drawing, axes = subplots(5, 1, sharex=True, layout="constrained", figsize=(9, 11))
    axes[0].plot(time, h, label="in the microburst")
    axes[0].plot(time, h_still, "k--", linewidth=0.9, label="in still air")
    axes[1].plot(time, tailwind, label="tailwind")
    axes[1].plot(time, downdraft, label="downdraft")
    axes[2].plot(time, f_factor(), "C3")
    axes[3].plot(time, vc)
    axes[4].plot(time, throttle)
    axes[0].set_ylabel("altitude [ft]")
    axes[1].set_ylabel("wind [ft/s]")
    axes[2].set_ylabel("F-factor [-]")
    axes[3].set_ylabel("airspeed [KCAS]")
    axes[4].set_ylabel("throttle increment [-]")
    axes[0].legend(loc="upper right", fontsize="small")
    axes[1].legend(loc="upper left", fontsize="small")
    axes[4].set_xlabel("time [s]")
    axes[4].set_xlim(0.0, DURATION)
    for ax in axes:
        ax.grid(alpha=0.4)
    drawing.suptitle("737: a microburst on the approach")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    time, (h, vc, throttle) = flight.read()
    _, (tailwind, downdraft, _) = wind.read()
    _, (h_still,) = still.read()
    lost, f = h_still - h, f_factor()
    print(f"headwind up to {-tailwind.min():.1f} ft/s, at {time[tailwind.argmin()]:.1f} s")
    print(f"downdraft up to {downdraft.max():.1f} ft/s, at {time[downdraft.argmax()]:.1f} s")
    print(f"tailwind up to {tailwind.max():.1f} ft/s, at {time[tailwind.argmax()]:.1f} s")
    print(f"F-factor up to {f.max():.3f}, at {time[f.argmax()]:.1f} s")
    print(
        f"airspeed {vc.min():.1f} to {vc.max():.1f} KCAS, throttle up to +{throttle.max():.2f}; "
        f"{lost[-1]:.0f} ft below the approach in still air, {h[-1]:.0f} ft above the ground"
    )
    show(figure(), "microburst_approach")
