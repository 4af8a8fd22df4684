"""Discrete gusts of CS 25.341: load factors of an airliner in gusts of five lengths.

A Boeing 737 at 10,000 ft and 280 KCAS, gear up, controls fixed. Five of them meet an upward
1-cosine gust at 1 s, with gradient distances from 30 to 350 ft and the design gust velocity of each
length: 37 to 56 ft/s true.

Expected: nz rises to 1.82, 1.96, 1.99, 1.99 and 1.94: 150 to 200 ft are the critical lengths. In
short gusts the design velocity is lower, in long ones the aircraft rises with the air. After the
shortest gust nz falls to 0.94, after the longest to 0.19.

Source: our own; lengths and velocities of 14 CFR 25.341(a). The aircraft is rigid and its
aerodynamics are quasi-steady, which a certification would not accept.
"""

from pathsim import Connection, Interface, Simulation, Subsystem
from pathsim.blocks import Scope

from pathsim_jsbsim_blocks import Aircraft, OneMinusCosineGust

DURATION = 6.0  # s

altitude = 10000.0  # ft
speed = 280.0  # KCAS
airspeed = 544.7  # ft/s, true

gust_30 = OneMinusCosineGust(30.0, airspeed, altitude, polarity=-1)
gust_90 = OneMinusCosineGust(90.0, airspeed, altitude, polarity=-1)
gust_150 = OneMinusCosineGust(150.0, airspeed, altitude, polarity=-1)
gust_200 = OneMinusCosineGust(200.0, airspeed, altitude, polarity=-1)
gust_350 = OneMinusCosineGust(350.0, airspeed, altitude, polarity=-1)
plane_30 = Aircraft("737", altitude, speed, gear=0.0)
plane_90 = Aircraft("737", altitude, speed, gear=0.0)
plane_150 = Aircraft("737", altitude, speed, gear=0.0)
plane_200 = Aircraft("737", altitude, speed, gear=0.0)
plane_350 = Aircraft("737", altitude, speed, gear=0.0)
gusts = Scope(labels=["30 ft", "90 ft", "150 ft", "200 ft", "350 ft"])
load_factors = Scope(labels=["30 ft", "90 ft", "150 ft", "200 ft", "350 ft"])


def encounter(gust, plane):
    """A plane that meets a gust: its velocity and the load factor out."""
    ports = Interface()
    ports.register_port_map({"gust": 0, "nz": 1}, {})
    return Subsystem(
        [ports, gust, plane],
        [
            Connection(gust, plane["wind_down"], ports["gust"]),
            Connection(plane["nz"], ports["nz"]),
        ],
    )


gradient_30 = encounter(gust_30, plane_30)
gradient_90 = encounter(gust_90, plane_90)
gradient_150 = encounter(gust_150, plane_150)
gradient_200 = encounter(gust_200, plane_200)
gradient_350 = encounter(gust_350, plane_350)

sim = Simulation(
    [
        gradient_30,
        gradient_90,
        gradient_150,
        gradient_200,
        gradient_350,
        gusts,
        load_factors,
    ],
    [
        Connection(gradient_30["gust"], gusts[0]),
        Connection(gradient_30["nz"], load_factors[0]),
        Connection(gradient_90["gust"], gusts[1]),
        Connection(gradient_90["nz"], load_factors[1]),
        Connection(gradient_150["gust"], gusts[2]),
        Connection(gradient_150["nz"], load_factors[2]),
        Connection(gradient_200["gust"], gusts[3]),
        Connection(gradient_200["nz"], load_factors[3]),
        Connection(gradient_350["gust"], gusts[4]),
        Connection(gradient_350["nz"], load_factors[4]),
    ],
    dt=1 / 120,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import subplots

    time, down = gusts.read()
    _, nz = load_factors.read()
    gradients = [gust.gradient for gust in (gust_30, gust_90, gust_150, gust_200, gust_350)]
    drawing, ((top, upper), (bottom, lower)) = subplots(
        2, 2, width_ratios=(3, 2), layout="constrained", figsize=(10, 6)
    )
    bottom.sharex(top)
    upper.remove()
    lower.remove()
    envelope = drawing.add_subplot(top.get_gridspec()[:, 1])
    for label, w, n in zip(gusts.labels, down, nz, strict=True):
        top.plot(time, -w, label=label)
        bottom.plot(time, n)
    top.set_ylabel("upward gust [ft/s]")
    top.legend(title="gradient", fontsize="small")
    bottom.set_ylabel("load factor nz [g]")
    bottom.set_xlabel("time [s]")
    bottom.set_xlim(0.5, DURATION)
    envelope.plot(gradients, nz.max(axis=1), "o-", label="largest")
    envelope.plot(gradients, nz.min(axis=1), "o-", label="smallest")
    envelope.axhline(1.0, color="0.5", linewidth=0.8)
    envelope.set_xlabel("gust gradient distance [ft]")
    envelope.set_ylabel("load factor nz [g]")
    envelope.set_ylim(0.0, 2.5)
    envelope.legend(loc="upper right")
    for ax in (top, bottom, envelope):
        ax.grid(alpha=0.4)
    drawing.suptitle("737 in design gusts of CS 25.341, 10000 ft, 280 KCAS")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    _, nz = load_factors.read()
    for gust, n in zip((gust_30, gust_90, gust_150, gust_200, gust_350), nz, strict=True):
        print(
            f"{gust.gradient:3.0f} ft, {-gust.peak:.1f} ft/s: "
            f"nz from {n.min():.2f} to {n.max():.2f} in {sim.time:.4g} s"
        )
    show(figure(), "gust_response")
