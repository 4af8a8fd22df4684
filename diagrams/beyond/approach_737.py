"""Instrument approach of a 737: localizer, glideslope, speed reduction, decision height.

A Boeing 737 at 2500 ft and 170 KCAS, gear down and half flaps, flies north east. ``CourseHold``
captures the line from the final fix to the threshold at 30 deg, ``GlideslopeHold`` holds the
altitude until it meets the glide path of 3 deg, and ``AirspeedHold`` slows down to 150 KCAS from
150 s on. A wind of 25 ft/s blows from the north, across the runway, which is 500 ft above the sea.
The run ends at the decision height, 200 ft above the threshold.

Expected: the aircraft turns onto the line without overshoot and tracks it with a wind correction
angle of 5 deg. From 5 nmi before the threshold on it is within 5 ft of the line and 10 ft of the
glide path. It reaches the decision height after 290 s, 2850 ft before the threshold, at 151 KCAS.

Source: our own. Path and decision height are those of an instrument landing system of category I
(ICAO Annex 10, volume I, 3.1; Doc 8168).
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, StepSource
from pathsim.events import Condition

from pathsim_jsbsim_blocks import Aircraft, AirspeedHold, CourseHold, GlideslopeHold, TrimCondition

DURATION = 330.0  # s, more than it takes

FIX = (0.03, 0.03)  # deg
THRESHOLD = (0.03, 0.22)
ELEVATION = 500.0  # ft
DECISION_HEIGHT = 200.0  # ft above the threshold
# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]

aircraft = Aircraft(
    aircraft="737",
    condition=TrimCondition(
        altitude=2500.0, speed=170.0, heading=60.0, gear=1.0, flaps=0.5, wind_north=-25.0
    ),
)
course = CourseHold(gains="737", waypoints=[FIX, THRESHOLD], leg=1, intercept=30.0)
glide = GlideslopeHold(gains="737", threshold=THRESHOLD, elevation=ELEVATION, angle=3.0)
airspeed = AirspeedHold(gains="737")
slower = StepSource(amplitude=-20.0, tau=150.0)
position = Scope(labels=["distance to the threshold [ft]", "altitude [ft]"])
deviation = Scope(labels=["cross-track error [ft]", "above the glide path [ft]"])
flight = Scope(labels=["calibrated airspeed [kt]", "heading [deg]", "course over the ground [deg]"])
decision = Condition(
    func_evt=lambda t: aircraft.outputs["h"] <= ELEVATION + DECISION_HEIGHT,
    func_act=lambda t: sim.stop(),
)

sim = Simulation(
    [aircraft, course, glide, airspeed, slower, position, deviation, flight],
    [
        Connection(aircraft["lat"], course["lat"], glide["lat"]),
        Connection(aircraft["lon"], course["lon"], glide["lon"]),
        Connection(aircraft["psi"], course["psi"], flight[1]),
        Connection(aircraft["phi"], course["phi"]),
        Connection(aircraft["p"], course["p"]),
        Connection(aircraft["ail_sat"], course["ail_sat"]),
        Connection(aircraft["h"], glide["h"], position[1]),
        Connection(aircraft["hdot"], glide["hdot"], airspeed["hdot"]),
        Connection(aircraft["theta"], glide["theta"]),
        Connection(aircraft["q"], glide["q"]),
        Connection(aircraft["elev_sat"], glide["elev_sat"]),
        Connection(aircraft["vc"], airspeed["vc"], flight[0]),
        Connection(aircraft["thr_sat"], airspeed["thr_sat"]),
        Connection(aircraft[MOTION], airspeed[MOTION]),
        Connection(glide["hdot_cmd"], airspeed["hdot_cmd"]),
        Connection(slower, airspeed["vc_ref"]),
        Connection(course["aileron"], aircraft["aileron"]),
        Connection(glide["elevator"], aircraft["elevator"]),
        Connection(airspeed["throttle"], aircraft["throttle"]),
        Connection(course["across"], deviation[0]),
        Connection(glide["gs_ft"], deviation[1]),
        Connection(glide["dist"], position[0]),
        Connection(course["chi"], flight[2]),
    ],
    [decision],
    dt=1 / 120,
    log=False,
)


def figure():
    import numpy as np

    from pathsim_jsbsim_blocks.plots import subplots

    _, (distance, altitude) = position.read()
    _, (across, above) = deviation.read()
    _, (vc, psi, chi) = flight.read()
    nmi = distance / 6076.12
    path = np.array([0.0, nmi.max()])
    drawing, axes = subplots(4, 1, sharex=True, layout="constrained", figsize=(9, 10))
    axes[0].plot(nmi, altitude, label="aircraft")
    axes[1].plot(nmi, across, label="right of the centre line")
    axes[1].plot(nmi, above, "--", label="above the glide path")
    axes[2].plot(nmi, psi, label="heading")
    axes[2].plot(nmi, chi, "--", label="course over the ground")
    axes[3].plot(nmi, vc)
    foot = ELEVATION + 50.0 + path * 6076.12 * np.tan(np.deg2rad(3.0))
    axes[0].plot(path, foot, "k:", linewidth=1.0, label="glide path")
    axes[0].axhline(ELEVATION + DECISION_HEIGHT, color="C3", linewidth=1.0, label="decision height")
    axes[0].set(ylabel="altitude [ft]", ylim=(400.0, 2900.0))
    axes[1].set(ylabel="deviation [ft]", ylim=(-700.0, 700.0))
    axes[2].set(ylabel="direction [deg]")
    axes[3].set(ylabel="airspeed [KCAS]", xlabel="distance to the threshold [nmi]")
    axes[3].set_xlim(path[::-1])
    for ax in axes:
        ax.grid(alpha=0.4)
    for ax in axes[:3]:
        ax.legend(loc="best", fontsize="small")
    drawing.suptitle("737: instrument approach with a crosswind of 15 kt")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    _, (distance, altitude) = position.read()
    time, (across, above) = deviation.read()
    _, (vc, psi, chi) = flight.read()
    final = distance < 5 * 6076.12
    print(f"passed the line by {max(-across.min(), 0.0):.0f} ft")
    if final.any():
        print(
            f"from 5 nmi on within {abs(across[final]).max():.1f} ft of it and "
            f"{abs(above[final]).max():.1f} ft of the path"
        )
    reached = altitude[-1] <= ELEVATION + DECISION_HEIGHT
    print(
        f"{'at' if reached else 'above'} the decision height after {time[-1]:.4g} s, "
        f"{distance[-1]:.0f} ft before the threshold: "
        f"{across[-1]:.0f} ft beside the line, {above[-1]:.1f} ft above the glide path, "
        f"{vc[-1]:.1f} KCAS, heading {psi[-1]:.1f} deg, course {chi[-1]:.1f} deg"
    )
    show(figure(), "approach_737")
