"""Climb at 250 KCAS to the crossover altitude, then at Mach 0.70.

Below the crossover altitude the speed is 250 KCAS: TAS and Mach grow with altitude. Above it Mach
0.70 is the lower speed and is held: TAS falls with the temperature until the tropopause, CAS and
EAS fall with the pressure. The lower of the two speeds is flown at any altitude.

Expected: 288.7 KTAS and Mach 0.452 at 10,000 ft; crossover at 32,310 ft; 401.5 KTAS from the
tropopause up. The table of 120 KCAS reads 237.3 KTAS at 40,000 ft.

Source: notebook 5 of the published JSBSim/PathSim notebooks for the table; there it says 241.4
KTAS, since it divides CAS by the root of the density ratio: that is the conversion of EAS.
"""

from pathsim import Connection, Simulation
from pathsim.blocks import Amplifier, Constant, Function, Scope, Source

from pathsim_jsbsim_blocks import CAStoTAS, MachtoTAS, TAStoCAS, TAStoEAS, TAStoMach

DURATION = 1350.0  # s

knot = 1852 / 3600  # m/s
foot = 0.3048  # m
climb_rate = 2000 * foot / 60  # m/s
climb_cas = 250 * knot  # m/s
climb_mach = 0.70

altitude = Source(lambda t: climb_rate * t)
cas = Constant(climb_cas)
mach = Constant(climb_mach)
tas_at_cas = CAStoTAS()
tas_at_mach = MachtoTAS()
tas = Function(lambda a, b: min(a, b))
cas_now = TAStoCAS()
eas_now = TAStoEAS()
mach_now = TAStoMach()
feet = Amplifier(gain=1 / foot)
ktas = Amplifier(gain=1 / knot)
kcas = Amplifier(gain=1 / knot)
keas = Amplifier(gain=1 / knot)
height = Scope(labels=["altitude [ft]"])
airspeeds = Scope(labels=["TAS [kt]", "CAS [kt]", "EAS [kt]"])
machs = Scope(labels=["Mach number [-]"])

sim = Simulation(
    [
        altitude,
        cas,
        mach,
        tas_at_cas,
        tas_at_mach,
        tas,
        cas_now,
        eas_now,
        mach_now,
        feet,
        ktas,
        kcas,
        keas,
        height,
        airspeeds,
        machs,
    ],
    [
        Connection(
            altitude,
            tas_at_cas["altitude"],
            tas_at_mach["altitude"],
            cas_now["altitude"],
            eas_now["altitude"],
            mach_now["altitude"],
            feet,
        ),
        Connection(cas, tas_at_cas["cas"]),
        Connection(mach, tas_at_mach["mach"]),
        Connection(tas_at_cas["tas"], tas[0]),
        Connection(tas_at_mach["tas"], tas[1]),
        Connection(tas, cas_now["tas"], eas_now["tas"], mach_now["tas"], ktas),
        Connection(cas_now["cas"], kcas),
        Connection(eas_now["eas"], keas),
        Connection(mach_now["mach"], machs),
        Connection(feet, height),
        Connection(ktas, airspeeds[0]),
        Connection(kcas, airspeeds[1]),
        Connection(keas, airspeeds[2]),
    ],
    dt=1.0,
    log=False,
)


def figure():
    from pathsim_jsbsim_blocks.plots import subplots

    _, (h,) = height.read()
    _, speeds = airspeeds.read()
    _, (m,) = machs.read()
    drawing, (left, right) = subplots(1, 2, sharey=True, layout="constrained", figsize=(9, 5))
    for label, speed in zip(("TAS", "CAS", "EAS"), speeds, strict=True):
        left.plot(speed, h, label=label, linewidth=1.5)
    right.plot(m, h, linewidth=1.5)
    left.set_xlabel("airspeed [kt]")
    left.set_ylabel("altitude [ft]")
    left.legend()
    right.set_xlabel("Mach number [-]")
    left.grid(alpha=0.4)
    right.grid(alpha=0.4)
    drawing.suptitle("climb at 250 KCAS / Mach 0.70")
    return drawing


if __name__ == "__main__":
    from pathsim_jsbsim_blocks.air import cas_to_tas, crossover_altitude, isa
    from pathsim_jsbsim_blocks.plots import show

    sim.run(DURATION)
    _, (h,) = height.read()
    _, (v, _, _) = airspeeds.read()
    _, (m,) = machs.read()
    i = abs(h - 10_000).argmin()
    print(
        f"crossover altitude {crossover_altitude(cas.value, mach.value) / foot:.0f} ft; "
        f"{v[i]:.1f} KTAS, Mach {m[i]:.3f} at {h[i]:,.0f} ft; "
        f"{v[-1]:.1f} KTAS, Mach {m[-1]:.3f} at {h[-1]:,.0f} ft"
    )
    print("altitude [ft]  CAS [kt]  TAS [kt]  TAS/CAS")
    for level in (0, 5_000, 10_000, 20_000, 30_000, 40_000):
        true = cas_to_tas(120 * knot, isa(level * foot)) / knot
        print(f"{level:13,d}  {120:8.1f}  {true:8.1f}  {true / 120:7.3f}")
    show(figure(), "constant_cas_climb")
