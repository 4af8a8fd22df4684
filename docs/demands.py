"""Ask the autopilot for too much, in random cases, and print which limits it does not keep.

    python docs/demands.py [CASES]

Default is 1,000 cases, over the gain tables of the fleet in turn. Weight, centre of gravity, flaps,
altitude and airspeed are drawn anew for each; half of them fly in moderate turbulence, and one
engine of a fifth of those with several fails. References lead beyond every limit, and modes change.
"""

import sys
from collections import Counter
from dataclasses import replace
from functools import cache

import numpy as np
from gain_tables import flight_of, fuel, table_of

from pathsim_jsbsim_blocks import Aircraft, Autopilot
from pathsim_jsbsim_blocks.control.airspeeds import fastest_airspeed
from pathsim_jsbsim_blocks.control.gain_tables import read_gains
from pathsim_jsbsim_blocks.errors import BlocksError, FlightError, TrimError
from pathsim_jsbsim_blocks.flight import aircraft_names, empty_weight_cg

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
                input_properties=["throttle[0]"],
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


def fly(case):
    """Name, what is not kept ("" for nothing) and the number of conditions without a trim."""
    rng, names = np.random.default_rng(case), fleet()
    name = names[case % len(names)]
    plane, turbulent, failed = started(name, rng, case)
    if plane is None:
        return name, "no trim", failed
    table = read_gains(table_of(name))
    autopilot = Autopilot(str(table_of(name)), reference="absolute", T=T)
    for port in (name for name in Autopilot.input_port_labels if name.endswith("_ref")):
        autopilot[port].get_inputs()  # as a connection does
    fails = rng.uniform(0.0, SECONDS) if plane.airframe.engines > 1 and rng.random() < 0.2 else 1e9
    ports, state = list(plane.output_port_labels), autopilot.initial_state()
    seen, asked, rows = dict(zip(ports, map(float, plane.outputs.to_array()), strict=True)), {}, []
    for k in range(round(SECONDS / T)):
        if k % round(SECONDS / CHANGES / T) == 0:
            asked = demanded(rng, seen)
        u = [seen[n] if n in seen else asked.get(n, 0.0) for n in autopilot.input_port_labels]
        command, state = autopilot.law(u, state)
        engine = -1.0 if k * T > fails else 0.0
        try:
            y = plane.advance(k + 1, [*command[:4], 0.0, 0.0, 0.0, engine])
        except FlightError as error:
            return name, f"ends: {error}"[:90], failed
        seen = dict(zip(ports, y, strict=True))
        limits = table.at(seen["h"], seen["vc"]).envelope if k % 6 == 0 else limits  # noqa: F821
        fastest = fastest_airspeed(limits.vmo, limits.mmo, seen["h"])
        rows.append((seen["alpha"] - limits.alpha_max, seen["vc"] - fastest - FAST))
    alpha, fast = np.array(rows).T
    if turbulent:
        window = round(MEAN / T)
        alpha = np.convolve(alpha, np.full(window, 1.0 / window), "valid")
    long = np.convolve(fast > 0.0, np.ones(round(LONG / T)), "valid")
    missed = [f"alpha {alpha.max():+.1f} deg"] if alpha.max() > ALPHA else []
    missed += ["overspeed"] if long.max() > LONG / T - 0.5 else []
    return name, ", ".join(missed), failed


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
    main(*map(int, sys.argv[1:]))
