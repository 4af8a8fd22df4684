"""Ask the autopilot for too much, in random cases, and print which limits it does not keep.

    python docs/demands.py [CASES]
    python docs/demands.py engines [AIRCRAFT ...]

Default is 1,000 cases, over the gain tables of the fleet in turn. Weight, centre of gravity, flaps,
altitude and airspeed are drawn anew for each; half of them fly in moderate turbulence, and one
engine of a fifth of those with several fails. References lead beyond every limit, and modes change.

With ``engines`` the outer engine of each aircraft with several fails, in a climb at full throttle
and in cruise, with the tanks at a fifth and full, for docs/evidence/autopilots-engines.csv.
"""

import sys
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
from gain_tables import flight_of, flown_by, fuel, seen_by, table_of
from tables import write_table

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.control.airspeeds import fastest_airspeed
from pathsim_jsbsim_blocks.control.gain_tables import read_gains
from pathsim_jsbsim_blocks.errors import BlocksError, FlightError, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names, empty_weight_cg

CASES, T, SECONDS, CHANGES = 1000, 1 / 60, 100.0, 6
# of the tanks; of the chord, the empty weight's; ft above the table's lowest point; of the airspeed
# of its nominal point
FUEL, CG, HEIGHT, SPEED = (0.1, 1.0), (-0.03, 0.03), (0.0, 4000.0), (0.9, 1.15)
# deg; ft beyond the present altitude; deg of bank; of the airspeed; ft/s; of full travel
PITCH, CLIMB, BANK = (-25.0, 30.0), (-8000.0, 8000.0), (-75.0, 75.0)
VC, RATE, LEVER = (0.3, 2.0), (-80.0, 80.0), (-1.0, 1.0)
TURBULENCE = {
    "atmosphere/turb-type": 3.0,
    "atmosphere/turbulence/milspec/severity": 4.0,
    "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 50.0,
}
# s before the engine fails, and after it; the last of them; ft of climb
FAILS, AFTER, LAST, CLIMBS = 20.0, 100.0, 20.0, 20_000.0
ENGINES = """\
| | light: sideslip at the end, largest [deg] | rudder | heading [deg] \
| lowest airspeed (limit) [kt] | height [ft] \
| heavy: sideslip | rudder | heading | airspeed | height |
|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|"""
# deg beyond alpha_max, in turbulence of the mean over 2 s; kt beyond the highest airspeed, s
ALPHA, MEAN, FAST, LONG = 1.0, 2.0, 5.0, 10.0


@cache
def fleet():
    """Aircraft that have a gain table."""
    return [name for name in aircraft_names() if table_of(name).exists()]


def started(name, rng, seed, tries=5):
    """An aircraft in a random condition in which it trims, and the number of those it does not."""
    flight, schedule = flight_of(name), read_gains(table_of(name))
    nominal = schedule.points[schedule.nominal]
    turbulent = bool(rng.random() < 0.5)
    rough = {**TURBULENCE, "atmosphere/randomseed": float(seed)} if turbulent else {}
    plane = Aircraft(name, condition=flight.condition, create=flight.create)
    tanks, chord = fuel(plane, 1.0), 12.0 * plane.fdm["metrics/cbarw-ft"]
    cg = empty_weight_cg(name)[0] + np.random.default_rng([seed, 1]).uniform(*CG) * chord
    for failed in range(tries):
        share = rng.uniform(*FUEL)
        condition = replace(
            flight.condition,
            altitude=schedule.points[0].altitude + 1500.0 + rng.uniform(*HEIGHT),
            speed=nominal.speed * rng.uniform(*SPEED),
            empty_cg_x=cg,
            fuel={tank: share * full for tank, full in tanks.items()},
            flaps=0.3 if rng.random() < 0.2 else None,
        )
        try:
            plane = Aircraft(
                name,
                condition=condition,
                create=flight.create,
                properties=rough,
                T=T,
                substeps=2,
                output_properties=["h_agl"],
            )
        except (TrimError, BlocksError):
            continue
        return plane, turbulent, failed
    return None, turbulent, tries


def demanded(rng, seen):
    """References and modes, whether or not the aircraft can follow them."""
    return {
        "pitch_mode": float(rng.random() < 0.3),
        "roll_mode": float(rng.random() < 0.5),
        "v_mode": float(rng.integers(3)),
        "theta_ref": rng.uniform(*PITCH),
        "phi_ref": rng.uniform(*BANK),
        "psi_ref": rng.uniform(0.0, 360.0),
        "h_ref": seen["h"] + rng.uniform(*CLIMB),
        "vc_ref": seen["vc"] * rng.uniform(*VC),
        "hdot_ref": rng.uniform(*RATE),
        "thr_ref": rng.uniform(*LEVER),
    }


def pilot(name):
    """An autopilot with the gains of an aircraft, its references wired and absolute."""
    autopilot = Autopilot(str(table_of(name)), reference="absolute", T=T)
    for port in (port for port in Autopilot.input_port_labels if port.endswith("_ref")):
        autopilot[port].get_inputs()  # as a connection does
    return autopilot


def fly(case):
    """Name, what is not kept ("" for nothing) and the number of conditions without a trim."""
    rng, names = np.random.default_rng(case), fleet()
    name = names[case % len(names)]
    plane, turbulent, failed = started(name, rng, case)
    if plane is None:
        return name, "no trim", failed
    table = read_gains(table_of(name))
    fails = rng.uniform(0.0, SECONDS) if plane.airframe.engines > 1 and rng.random() < 0.2 else 1e9
    references, rows = {}, []

    def asked(k, seen):
        nonlocal references
        if k % round(SECONDS / CHANGES / T) == 0:
            references = demanded(rng, seen)
        if k * T > fails:
            stop_engine(plane)
        return references

    try:
        flight = flown_by(pilot(name), plane, round(SECONDS / T), asked)
        for k, (_, seen) in enumerate(flight):
            if k % 6 == 0:
                limits = table.at(seen["h"], seen["vc"]).envelope
            fastest = fastest_airspeed(limits.vmo, limits.mmo, seen["h"])
            rows.append((seen["alpha"] - limits.alpha_max, seen["vc"] - fastest - FAST))
    except FlightError as error:
        return name, f"ends: {error}"[:90], failed
    alpha, fast = np.array(rows).T
    if turbulent:
        window = round(MEAN / T)
        alpha = np.convolve(alpha, np.full(window, 1.0 / window), "valid")
    long = np.convolve(fast > 0.0, np.ones(round(LONG / T)), "valid")
    missed = [f"alpha {alpha.max():+.1f} deg"] if alpha.max() > ALPHA else []
    missed += ["overspeed"] if long.max() > LONG / T - 0.5 else []
    return name, ", ".join(missed), failed


def stop_engine(plane):
    """Stop the outer engine: a piston engine goes on running until its mixture is cut."""
    plane.airframe.fdm["propulsion/engine[0]/set-running"] = 0.0
    plane.airframe.fdm["fcs/mixture-cmd-norm[0]"] = 0.0


def engine_out(name, share, climbs):
    """Fly with a failed engine: signals from the failure on, or an error; and the lowest airspeed.

    Columns: sideslip, rudder, its excess, heading error, height gained, airspeed, throttle.
    """
    flight, schedule = flight_of(name), read_gains(table_of(name))
    nominal = schedule.points[schedule.nominal]
    tanks = fuel(Aircraft(name, condition=flight.condition, create=flight.create), 1.0)
    condition = replace(
        flight.condition,
        altitude=nominal.altitude,
        speed=nominal.speed,
        fuel={tank: share * full for tank, full in tanks.items()},
    )
    plane = Aircraft(name, condition=condition, create=flight.create, T=T, substeps=2)
    seen, rows = seen_by(plane), []
    references = {f"{port}_ref": seen[port] for port in ("h", "psi", "vc")}
    if climbs:
        references |= {"v_mode": 2.0, "thr_ref": 1.0, "h_ref": seen["h"] + CLIMBS}
    psi, h = seen["psi"], seen["h"]

    def asked(k, seen):
        if k * T >= FAILS:
            stop_engine(plane)
        return references

    for command, seen in flown_by(pilot(name), plane, round((FAILS + AFTER) / T), asked):
        off = (seen["psi"] - psi + 180.0) % 360.0 - 180.0
        moved = seen["beta"], command[2], seen["rud_sat"], off, seen["h"] - h, seen["vc"]
        rows.append((*moved, command[3]))
    return np.array(rows[round(FAILS / T) :]), schedule.at(seen["h"], seen["vc"]).envelope.vc_min


def engines(names):
    """The table of failed engines."""
    lines = [ENGINES]
    for name in names or fleet():
        if Airframe(name).engines < 2:
            continue
        for climbs, phase in ((True, "climb"), (False, "cruise")):
            cells = [f"| {name}, {phase}"]
            for share in (0.2, 1.0):
                try:
                    y, slowest = engine_out(name, share, climbs)
                except BlocksError as error:
                    cells.append(f"{error}"[:60] + " | | | | ")
                    continue
                last = y[-round(LAST / T) :].mean(axis=0)
                cells.append(
                    f"{abs(last[0]):.1f}, {np.abs(y[:, 0]).max():.1f} | {last[1]:+.2f} "
                    f"| {np.abs(y[:, 3]).max():.1f} | {y[:, 5].min():.0f} ({slowest:.0f}) "
                    f"| {y[-1, 4] - y[0, 4]:+.0f}"
                )
            lines.append(" | ".join(cells) + " |")
            print(lines[-1], flush=True)
    if not names:
        write_table("autopilots-engines", "\n".join(lines) + "\n")


def main(cases=CASES):
    """Print what is not kept, and how often."""
    counts, untrimmed = Counter(), Counter()
    for case in range(cases):
        name, missed, failed = fly(case)
        counts["kept" if not missed else missed.split()[0]] += 1
        untrimmed[name] += failed
        if missed:
            print(f"{case} {name}: {missed}", flush=True)
    print(f"{sum(counts.values())} cases: {dict(counts)}")
    print("without a trim:", {name: n for name, n in untrimmed.items() if n})


if __name__ == "__main__":
    if sys.argv[1:2] == ["engines"]:
        engines(sys.argv[2:])
    else:
        main(*map(int, sys.argv[1:]))
