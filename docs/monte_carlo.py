"""Fly the autopilot in random cases and write the table of docs/evidence/monte-carlo.md.

    python docs/monte_carlo.py [CASES] [TABLE ...]

Default is 100 cases of each gain table of `TABLES`. Weight, centre of gravity, airspeed, altitude,
wind and the seed of the turbulence are drawn anew for each case.
"""

import sys
from functools import partial

import numpy as np
from gain_tables import SECONDS, asked, at_point, largest_change, no_throttle, turbulence
from tables import EVIDENCE, markdown, put

from pathsim_jsbsim_blocks import Aircraft, TrimCondition
from pathsim_jsbsim_blocks.control.gain_tables import table as gains_called
from pathsim_jsbsim_blocks.design.requirements import ALTITUDE_KEPT, STEP_REQUIREMENTS
from pathsim_jsbsim_blocks.design.steps import STEPS, fly_step
from pathsim_jsbsim_blocks.studies import run_batch

T = 1 / 60
TABLES = ("c172p-designed", "737-designed", "A320", "T38")

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

# times the limits at a table's design point
OFF = 1.5
HEADING = 60.0  # s
IN_TURBULENCE = 90.0  # s
ENDLESS = sys.float_info.max  # s: it settles within the flight
# what is measured, its row on the page, and the limit
ROWS = {
    "pitch_time": ("pitch 5 deg: settling [s]", OFF * STEP_REQUIREMENTS["pitch"].settling),
    "pitch_over": ("pitch: overshoot [deg]", OFF * STEP_REQUIREMENTS["pitch"].overshoot),
    "roll_time": ("roll 20 deg: settling [s]", OFF * STEP_REQUIREMENTS["roll"].settling),
    "heading_time": ("heading 30 deg: settling [s]", ENDLESS),
    "heading_over": ("heading: overshoot [deg]", OFF * STEP_REQUIREMENTS["heading"].overshoot),
    "altitude_time": ("altitude 500 ft: settling [s]", ENDLESS),
    "altitude_over": ("altitude: overshoot [ft]", OFF * STEP_REQUIREMENTS["altitude"].overshoot),
    "speed_time": ("airspeed 10 kt: settling [s]", ENDLESS),
    "speed_kept": ("airspeed 10 kt: change of altitude [ft]", OFF * ALTITUDE_KEPT),
    "error": ("largest steady error, of its limit at the point", OFF),
    "alpha": ("angle of attack above its limit [deg]", 1.0),
    "gust_altitude": ("turbulence: altitude error [ft]", 60.0),
    "gust_pitch": ("turbulence: pitch angle, rms [deg]", 5.0),
    "gust_throttle": ("turbulence: throttle at its stop [% of the time]", 5.0),
}
STILL = [key for key in ROWS if not key.startswith("gust")]


def aircraft_of(table):
    return table.removesuffix("-designed")


def draw(table, cases):
    """Cases for `run_batch`."""
    altitude, speed, *_ = FLEET[aircraft_of(table)]
    rng, rows = np.random.default_rng(0), []
    for _ in range(cases):
        direction, wind = rng.uniform(0.0, 2 * np.pi), rng.uniform(0.0, WIND)
        row = {
            "altitude": rng.uniform(*altitude),
            "speed": rng.uniform(*speed),
            "fuel": rng.uniform(*FUEL),
            "cg": rng.uniform(-CG, CG),
            "wind_north": wind * np.cos(direction),
            "wind_east": wind * np.sin(direction),
        }
        rows.append({"table": table, **{k: round(float(x), 4) for k, x in row.items()}})
    return rows


def flight(table, altitude, speed, fuel, cg, wind_north, wind_east, seed):
    """Fly one case: five steps without turbulence, and a turn in it."""
    aircraft = aircraft_of(table)
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
    fresh = partial(Aircraft, aircraft, condition=condition, T=T, substeps=2)
    gains = gains_called(table)
    down = no_throttle(fresh, condition, fresh().trim)
    found, errors, alpha = {}, [], 0.0
    for loop, step in STEPS.items():
        seconds = {**SECONDS, "heading": HEADING}[loop]
        size, seconds = asked(loop, gains, condition, down, seconds)
        flown = fly_step(fresh, gains, step, size, seconds)
        found[f"{loop}_time"] = flown.quality.settling
        found[f"{loop}_over"] = flown.quality.overshoot
        errors.append(flown.quality.steady_error / STEP_REQUIREMENTS[loop].final_error)
        alpha = max(alpha, flown.outputs["alpha"].max())
        if loop == "speed":
            found["speed_kept"] = largest_change(flown, "h")
    here = at_point(gains, condition)
    found["error"], found["alpha"] = max(errors), alpha - here.envelope.alpha_max

    rough = partial(fresh, properties=turbulence(4.0, 50.0, seed % 30_000))
    y = fly_step(rough, gains, STEPS["heading"], seconds=IN_TURBULENCE).outputs
    found["gust_altitude"] = np.abs(y["h"] - altitude).max()
    found["gust_pitch"] = np.std(y["theta"])
    found["gust_throttle"] = 100.0 * np.mean(y["thr_sat"] != 0.0)
    return {key: float(found[key]) for key in ROWS}


def within(results, keys):
    """Which cases are within their limits; a case that failed is not."""
    return np.all([results[key] <= ROWS[key][1] for key in keys], axis=0)


def cell(values, limit):
    """Median and worst, and how many cases are within the limit, where not all are."""
    inside = (values <= limit).sum()
    few = f" ({inside})" if inside < len(values) else ""
    return f"{np.median(values):.2g}, {values.max():.3g}{few}"


def counted(results):
    """Median and worst case of every quantity, and the cases within their limits."""
    lines = []
    for key, (label, limit) in ROWS.items():
        cells = [cell(found[key].fillna(np.inf), limit) for found in results.values()]
        lines.append([label, *cells, "settles" if limit == ENDLESS else f"{limit:g}"])
    for label, keys in (("**all without turbulence**", STILL), ("**all**", list(ROWS))):
        cells = [f"{within(found, keys).sum()} of {len(found)}" for found in results.values()]
        lines.append([label, *cells, "-"])
    return markdown(f"| median, worst of | {' | '.join(results)} | limit |", lines)


def main(cases, names):
    results = {name: run_batch(flight, draw(name, cases), progress=False) for name in names}
    for name, found in results.items():
        for reason in found.reason[~found.completed]:
            print(name, reason)
    text = counted(results)
    print(text)
    if names == list(TABLES):
        put(EVIDENCE / "monte-carlo.md", "flights", text)
    return results


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 100, sys.argv[2:] or list(TABLES))
