"""Fly the autopilot in random cases and write the table of docs/monte-carlo.md.

    python docs/monte_carlo.py [CASES] [AIRCRAFT ...]

Default is 100 cases of each aircraft of `FLEET` that has a gain table. Weight, centre of gravity,
airspeed, altitude, wind and the seed of the turbulence are drawn anew for each case.
"""

import re
import sys
from pathlib import Path

import numpy as np

PLACE = re.compile(r"(<!-- flights -->\n).*?(<!-- end -->)", re.DOTALL)
FLIGHT = 60.0  # s
T = 1 / 60
TURN, CLIMB = 20.0, 100.0  # deg and ft, asked for at 5 s
CALM = 45.0  # s: from here on the references are reached

# altitude [ft], airspeed [KCAS], capacity of the tanks [lb], x of the empty CG and chord [in]
FLEET = {
    "c172p": ((3000, 7000), (80, 105), (185, 185), 41.0, 58.8),
    "737": ((5000, 15_000), (240, 310), (10_200, 10_200, 15_000), 639.0, 147.7),
    "A320": ((3000, 10_000), (240, 310), (23_940, 23_940), 672.0, 169.2),
    "T38": ((3000, 8000), (205, 265), (1953, 2029), 314.0, 80.8),
}
CG = 0.03  # of the chord, either way
FUEL = (0.2, 1.0)  # of the tanks
WIND = 40.0  # ft/s, from any direction
# what is measured, its row on the page, and the limit
LIMITS = {
    "altitude_error": ("altitude error from 45 s on [ft]", 60.0),
    "heading_error": ("heading error from 45 s on [deg]", 15.0),
    "airspeed_error": ("airspeed error [kt]", 30.0),
    "pitch_rms": ("pitch angle, rms [deg]", 6.0),
    "bank": ("bank [deg]", 35.0),
    "alpha": ("angle of attack [deg]", 14.0),
}


def draw(name, cases, seed=0):
    """Cases for `run_batch`."""
    altitude, speed, *_ = FLEET[name]
    rng = np.random.default_rng(seed)
    direction = rng.uniform(0.0, 2 * np.pi, cases)
    wind = rng.uniform(0.0, WIND, cases)
    columns = {
        "altitude": rng.uniform(*altitude, cases),
        "speed": rng.uniform(*speed, cases),
        "fuel": rng.uniform(*FUEL, cases),
        "cg": rng.uniform(-CG, CG, cases),
        "wind_north": wind * np.cos(direction),
        "wind_east": wind * np.sin(direction),
    }
    rows = [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]
    return [{"aircraft": name, **{k: round(float(x), 4) for k, x in row.items()}} for row in rows]


def flight(aircraft, altitude, speed, fuel, cg, wind_north, wind_east, seed):
    """Fly one case: climb and turn in moderate turbulence; the largest errors."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import Scope, StepSource

    from pathsim_jsbsim_blocks import Aircraft, Autopilot, TrimCondition, fly

    _, _, tanks, empty_cg, chord = FLEET[aircraft]
    condition = TrimCondition(
        altitude=altitude,
        speed=speed,
        heading=30.0,
        gear=None if aircraft == "c172p" else 0.0,
        wind_north=wind_north,
        wind_east=wind_east,
        fuel=[fuel * tank for tank in tanks],
        empty_cg_x=empty_cg + cg * chord,
    )
    turbulence = {
        "atmosphere/randomseed": float(seed % 30_000),
        "atmosphere/turb-type": 3.0,
        "atmosphere/turbulence/milspec/severity": 4.0,
        "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": 50.0,
    }
    plane = Aircraft(aircraft, condition=condition, T=T, properties=turbulence)
    autopilot = Autopilot(gains=aircraft, T=T)
    climb, turn = StepSource(amplitude=CLIMB, tau=5.0), StepSource(amplitude=TURN, tau=5.0)
    seen = [p for p in autopilot.input_port_labels if p in plane.output_port_labels]
    driven = ["elevator", "aileron", "rudder", "throttle"]
    signals = ["h", "vc", "psi", "theta", "phi", "alpha"]
    scope = Scope()
    sim = Simulation(
        [plane, autopilot, climb, turn, scope],
        [
            Connection(plane[seen], autopilot[seen]),
            Connection(autopilot[driven], plane[driven]),
            Connection(climb, autopilot["h_ref"]),
            Connection(turn, autopilot["psi_ref"]),
            Connection(plane[signals], scope[: len(signals)]),
        ],
        dt=T,
        log=False,
    )
    fly(sim, FLIGHT)
    time, (h, vc, psi, theta, phi, alpha) = scope.read()
    end = time >= CALM
    heading = (psi - psi[0] - TURN + 180.0) % 360.0 - 180.0
    return {
        "altitude_error": float(np.abs(h - h[0] - CLIMB)[end].max()),
        "airspeed_error": float(np.abs(vc - vc[0]).max()),
        "heading_error": float(np.abs(heading)[end].max()),
        "pitch_rms": float(np.std(theta)),
        "bank": float(np.abs(phi).max()),
        "alpha": float(alpha.max()),
    }


def table(results):
    """Median and worst case of every quantity, and the cases within all limits."""
    head = " | ".join(results)
    lines = [f"| median / worst of | {head} | limit |", f"|---|{'--:|' * (len(results) + 1)}"]
    for key, (label, limit) in LIMITS.items():
        cells = [
            f"{found[key].median():.1f} / {found[key].max():.1f}" for found in results.values()
        ]
        lines.append(f"| {label} | {' | '.join(cells)} | {limit:g} |")
    cells = []
    for found in results.values():
        inside = np.all([found[key] <= limit for key, (_, limit) in LIMITS.items()], axis=0)
        cells.append(f"{inside.sum()} of {len(found)}")
    return "\n".join([*lines, f"| within all limits | {' | '.join(cells)} | - |"]) + "\n"


def main(cases, names):
    from pathsim_jsbsim_blocks.control.gains import tables
    from pathsim_jsbsim_blocks.studies import run_batch

    known = [name for name in names if name in tables()]
    results = {name: run_batch(flight, draw(name, cases), progress=False) for name in known}
    for name, found in results.items():
        for reason in found.reason[~found.completed]:
            print(name, reason)
    page = Path(__file__).with_name("monte-carlo.md")
    text = PLACE.sub(
        lambda m: m[1] + table(results) + m[2], page.read_text(encoding="utf-8"), count=1
    )
    page.write_text(text, encoding="utf-8")
    print(table(results))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, sys.argv[2:] or list(FLEET))
