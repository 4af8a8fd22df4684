"""International Standard Atmosphere: a climb from sea level to 80 km.

The altitude rises at a constant rate. ``ISAtmosphere`` gives pressure, density, temperature, speed
of sound and viscosity.

Expected: 101325 Pa, 15 degC and 340.294 m/s at sea level; -56.5 degC from 11.0 to 20.1 km and
-2.5 degC from 47.4 to 51.4 km; 1.05 Pa and -74.5 degC at 80 km. These are heights: as geopotential
altitudes the layers end at 11, 20, 47 and 51 km.

Source: notebook 5 of the published JSBSim/PathSim notebooks (pathsim-flight's atmosphere), whose
figure shows the first 11 km.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Scope, Source

from pathsim_jsbsim_blocks import ISAtmosphere

DURATION = 800.0  # s

climb_rate = 100.0  # m/s

altitude = Source(lambda t: climb_rate * t)
isa = ISAtmosphere()
height = Scope(labels=["altitude [m]"])
air = Scope(
    labels=[
        "pressure [Pa]",
        "density [kg/m3]",
        "temperature [K]",
        "speed of sound [m/s]",
        "viscosity [Pa s]",
    ]
)

sim = Simulation(
    [altitude, isa, height, air],
    [
        Connection(altitude, isa["altitude"], height),
        Connection(isa["pressure"], air[0]),
        Connection(isa["density"], air[1]),
        Connection(isa["temperature"], air[2]),
        Connection(isa["speed_of_sound"], air[3]),
        Connection(isa["viscosity"], air[4]),
    ],
    dt=0.5,
    log=False,
)


def figure(top=80.0):
    from pathsim_jsbsim_blocks.plots import subplots

    _, (h,) = height.read()
    _, (pressure, density, temperature, speed_of_sound, _) = air.read()
    shown = h <= 1000 * top
    drawing, axes = subplots(2, 2, sharey=True, layout="constrained", figsize=(9, 7))
    panels = [
        ("pressure [hPa]", pressure / 100),
        ("density [kg/m³]", density),
        ("temperature [°C]", temperature - 273.15),
        ("speed of sound [m/s]", speed_of_sound),
    ]
    for ax, (label, values) in zip(axes.flat, panels, strict=True):
        ax.plot(values[shown], h[shown] / 1000, linewidth=1.5)
        ax.set_xlabel(label)
        ax.grid(alpha=0.4)
    if top > 20:
        axes[0, 0].set_xscale("log")
        axes[0, 1].set_xscale("log")
    axes[0, 0].set_ylabel("altitude [km]")
    axes[1, 0].set_ylabel("altitude [km]")
    drawing.suptitle(f"International Standard Atmosphere to {top:.0f} km")
    return drawing


def figure_troposphere():
    return figure(top=11.0)


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    _, (h,) = height.read()
    _, (pressure, density, temperature, speed_of_sound, _) = air.read()
    for i in sorted({abs(h - 1000.0 * km).argmin() for km in (0, 11, 20, 50, 80)}):
        print(
            f"{h[i] / 1000:5.2f} km: {pressure[i]:10.2f} Pa  {density[i]:9.3g} kg/m3  "
            f"{temperature[i] - 273.15:7.2f} degC  {speed_of_sound[i]:7.3f} m/s"
        )
    show(figure(), "isa_profile")
    show(figure_troposphere(), "isa_profile_troposphere")
