"""Automatic landing of a Cessna 172: approach, flare, touchdown and roll-out in a crosswind.

A Cessna 172 at 900 ft and 70 KCAS, flaps half down, flies towards the course from 800 ft beside it.
The runway is 500 ft above the sea. A ``Localizer`` and a ``Glideslope`` receiver give the
deviations from the approach; ``LocalizerHold`` captures the course from the side,
``GlideslopeHold`` the path from below, and ``AirspeedHold`` keeps 70 KCAS. ``FlareHold`` passes
their commands on until the flare. Then it closes the throttle, aligns the nose with the runway,
lowers the nose wheel and brakes. A crosswind of 10 kt blows from the left, with turbulence of
JSBSim's MIL-spec model for a wind of 20 kt at 20 ft.

Expected: touchdown after 92 s, 120 ft past the aiming point and within 1 ft of the centre line,
sinking at 5.0 ft/s with 2.1 deg of bank into the wind: air that rises at 9 ft/s until 4 ft above
the runway keeps the nose low, and then ends. With the seeds 1, 2, 4, 5 and 6 of the turbulence it
sinks at 1.4 to 2.5 ft/s. The aircraft is down to 10 KCAS 1230 ft past the aiming point, on the
centre line.

Source: our own. The landing is judged by the limits of docs/landing.md.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Constant, Scope

from pathsim_jsbsim_blocks import (
    Aircraft,
    AirspeedHold,
    FlareHold,
    Glideslope,
    GlideslopeHold,
    Localizer,
    LocalizerHold,
    TrimCondition,
    YawDamper,
)

DURATION = 140.0  # s

AIM = (47.0, 11.0)  # deg, where the glide path meets the runway
ANTENNA = (47.0, 11.0321)  # deg, of the localizer, 8000 ft beyond
ELEVATION = 500.0  # ft
COURSE = 90.0  # deg
# higher than those of the table: the airspeed of an approach in turbulence must not fall
SPEED = {
    "Kp": 0.04,
    "Ki": 0.002,
    "Kd": -0.02,
    "Tf": 0.5,
    "b": 1.0,
    "ramp": 1.0,
    "Kc": 0.008,
    "band": 20.0,
}
TURBULENCE = {
    "atmosphere/randomseed": 3.0,
    "atmosphere/turb-type": 3.0,
    "atmosphere/turbulence/milspec/severity": 3.0,
    "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 34.0,
}

MEASURED = ["theta", "phi", "psi", "p", "q", "r", "alpha", "beta", "h", "hdot", "vc", "lat", "lon"]
MEASURED += ["nx", "nz", "vt", "elev_sat", "ail_sat", "thr_sat", "h_agl", "gear/wow"]
# what makes an airspeed without gusts
MOTION = ["nx", "nz", "alpha", "beta", "theta", "phi", "vt"]
COMMANDS = ["elevator", "aileron", "rudder", "throttle", "brakes", "steering"]

aircraft = Aircraft(
    aircraft="c172p",
    condition=TrimCondition(
        altitude=900.0,
        speed=70.0,
        heading=70.0,
        latitude=46.9978,
        longitude=10.9574,
        flaps=0.5,
        wind_north=-17.0,
    ),
    setup={"ic/terrain-elevation-ft": ELEVATION},
    properties=TURBULENCE,
    input_properties=["brakes", "steering"],
    output_properties=["h_agl", "gear/wow"],
)
localizer = Localizer(station=ANTENNA, course=COURSE)
glideslope = Glideslope(station=AIM, elevation=ELEVATION, angle=3.0)
lateral = LocalizerHold(gains="c172p-designed", course=COURSE)
vertical = GlideslopeHold(gains="c172p-designed", angle=3.0, sink_max=20.0)
airspeed = AirspeedHold(gains=SPEED)
damper = YawDamper(gains="c172p-designed")
flare = FlareHold(
    gains="c172p-designed",
    course=COURSE,
    gear_height=4.4,
    tau=2.0,
    align=0.1,
    bank_max=3.5,
    sink_max=20.0,
    float_max=1400.0,
    climb=8.0,
    theta_max=8.0,  # the tail strikes at 10 deg
)
go_around = Constant(0.0)  # 1 begins one
height = Scope(labels=["height above the runway [ft]", "height above the glide path [ft]"])
rates = Scope(labels=["rate of climb [ft/s]", "calibrated airspeed [kt]"])
attitude = Scope(labels=["pitch angle [deg]", "bank [deg]", "heading [deg]"])
ground = Scope(labels=["right of the centre line [ft]", "distance to the antenna [ft]"])
landing = Scope(labels=["phase [-]", "wheels on the ground [-]"])

# what the receivers and holds measure, and what they command and show
ports = Interface()
ports.register_port_map(
    {name: i for i, name in enumerate([*COMMANDS, "phase", "loc_ft", "loc_dist", "gs_ft"])},
    {name: i for i, name in enumerate([*MEASURED, "go_around"])},
)
autoland = Subsystem(
    [ports, localizer, glideslope, lateral, vertical, airspeed, damper, flare],
    [
        Connection(ports["lat", "lon"], localizer["lat", "lon"], glideslope["lat", "lon"]),
        Connection(ports["h"], glideslope["h"], vertical["h"]),
        Connection(localizer["ft", "dist"], lateral["loc_ft", "loc_dist"]),
        Connection(localizer["ft", "dist"], flare["loc_ft", "loc_dist"]),
        Connection(glideslope["deg", "ft", "dist"], vertical["gs_deg", "gs_ft", "gs_dist"]),
        Connection(ports["psi", "phi", "p"], lateral["psi", "phi", "p"], flare["psi", "phi", "p"]),
        Connection(ports["p", "r", "phi", "beta"], damper["p", "r", "phi", "beta"]),
        Connection(ports["r", "h_agl", "gear/wow"], flare["r", "h_agl", "wow"]),
        Connection(ports["hdot", "theta", "q"], vertical["hdot", "theta", "q"]),
        Connection(ports["hdot", "theta", "q"], flare["hdot", "theta", "q"]),
        Connection(ports["alpha"], vertical["alpha"], flare["alpha"]),
        Connection(ports["vc"], airspeed["vc"], flare["vc"]),
        Connection(ports["hdot"], airspeed["hdot"]),
        Connection(vertical["hdot_cmd"], airspeed["hdot_cmd"]),
        Connection(ports[MOTION], airspeed[MOTION]),
        Connection(ports["elev_sat"], vertical["elev_sat"]),
        Connection(ports["ail_sat"], lateral["ail_sat"]),
        Connection(ports["thr_sat"], airspeed["thr_sat"]),
        Connection(ports["go_around"], flare["go_around"]),
        Connection(vertical["elevator"], flare["elevator"]),
        Connection(lateral["aileron"], flare["aileron"]),
        Connection(damper["rudder"], flare["rudder"]),
        Connection(airspeed["throttle"], flare["throttle"]),
        Connection(flare[[*COMMANDS, "phase"]], ports[[*COMMANDS, "phase"]]),
        Connection(localizer["ft", "dist"], ports["loc_ft", "loc_dist"]),
        Connection(glideslope["ft"], ports["gs_ft"]),
    ],
)

sim = Simulation(
    [aircraft, autoland, go_around, height, rates, attitude, ground, landing],
    [
        Connection(aircraft[MEASURED], autoland[MEASURED]),
        Connection(autoland[COMMANDS], aircraft[COMMANDS]),
        Connection(go_around, autoland["go_around"]),
        Connection(aircraft["h_agl"], height[0]),
        Connection(autoland["gs_ft"], height[1]),
        Connection(aircraft["hdot", "vc"], rates[0, 1]),
        Connection(aircraft["theta", "phi", "psi"], attitude[0:3]),
        Connection(autoland["loc_ft", "loc_dist"], ground[0, 1]),
        Connection(autoland["phase"], landing[0]),
        Connection(aircraft["gear/wow"], landing[1]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    import numpy as np

    from pathsim_jsbsim_blocks.plots import subplots

    time, (above, _) = height.read()
    _, (climb, vc) = rates.read()
    _, (across, distance) = ground.read()
    _, (_, wheels) = landing.read()
    past = 8000.0 - distance
    drawing, axes = subplots(4, 1, layout="constrained", figsize=(9, 11))
    axes[0].plot(past, above, label="height above the runway")
    axes[1].plot(past, across, label="right of the centre line")
    axes[2].plot(time, climb, label="rate of climb")
    axes[3].plot(time, vc, label="calibrated airspeed")
    path = np.array([past.min(), 0.0])
    axes[0].plot(path, -path * np.tan(np.deg2rad(3.0)), "k:", linewidth=1.0, label="glide path")
    if wheels.any():
        touch = int(wheels.argmax())
        axes[0].plot(past[touch], above[touch], "o", label="touchdown")
        axes[1].plot(past[touch], across[touch], "o", label="touchdown")
        axes[2].plot(time[touch], climb[touch], "o", label="touchdown")
        axes[3].plot(time[touch], vc[touch], "o", label="touchdown")
    axes[0].set(ylabel="height [ft]")
    axes[1].set(ylabel="distance [ft]", xlabel="distance past the aiming point [ft]")
    axes[2].set(ylabel="rate of climb [ft/s]")
    axes[3].set(ylabel="calibrated airspeed [kt]", xlabel="time [s]")
    for ax in axes:
        ax.grid(alpha=0.4)
        ax.legend(loc="best", fontsize="small")
    drawing.suptitle("c172p: automatic landing in a crosswind of 10 kt")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    time, (_, wheels) = landing.read()
    _, (climb, vc) = rates.read()
    _, (theta, phi, psi) = attitude.read()
    _, (across, distance) = ground.read()
    if wheels.any():
        touch = int(wheels.argmax())
        print(
            f"touchdown after {time[touch]:.1f} s, {8000.0 - distance[touch]:.0f} ft past the "
            f"aiming point and {across[touch]:.1f} ft right of the centre line, sinking at "
            f"{-climb[touch - 1]:.1f} ft/s, at {vc[touch]:.0f} KCAS; pitch {theta[touch]:.1f} deg, "
            f"bank {phi[touch]:.1f} deg, heading {psi[touch]:.1f} deg"
        )
    else:
        print("no touchdown by the end")
    print(
        f"at the end {8000.0 - distance[-1]:.0f} ft past the aiming point and "
        f"{across[-1]:.1f} ft right, at {vc[-1]:.0f} KCAS"
    )
    show(figure(), "autoland_c172p")
