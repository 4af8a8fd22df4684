"""Make the gain tables of the fleet: python docs/gain_tables.py [--fly] [AIRCRAFT ...].

Each aircraft that trims in level flight (`docs/fleet.md`) gets gains at three airspeeds, where it
trims there, in `src/pathsim_jsbsim_blocks/control/tables/AIRCRAFT.json`. The hand-tuned tables keep
their names: the designed ones of these aircraft are called `AIRCRAFT-designed`.

With ``--fly`` the steps are flown with the existing tables, for `docs/designed-gains.md`.
"""

import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from generate import put

from pathsim_jsbsim_blocks import Aircraft, TrimCondition
from pathsim_jsbsim_blocks.control.gains import GAINS, TABLES, read_gains
from pathsim_jsbsim_blocks.design import DesignedGains, design_gains, design_schedule
from pathsim_jsbsim_blocks.design.steps import STEPS, fly_step
from pathsim_jsbsim_blocks.errors import BlocksError, FlightError
from pathsim_jsbsim_blocks.flight import aircraft_names, level_flight

# of the airspeed of level flight, and ft above its altitude
SPEEDS = (0.8, 1.0, 1.25)
HIGHER = (0.0,)


def designed(name):
    """The designs of one aircraft."""
    flight = level_flight(name)
    condition = flight.condition

    def said(found):
        text = "designed" if isinstance(found, DesignedGains) else f"{found}"
        print(f"{name}: {text}", flush=True)

    return design_schedule(
        name,
        condition,
        [condition.altitude + more for more in HIGHER],
        [float(round(share * condition.speed)) for share in SPEEDS],
        progress=said,
        create=flight.create,
    )


def table_of(name):
    """File of the designed table of an aircraft."""
    return TABLES / f"{name}{'-designed' if name in GAINS else ''}.json"


# where the hand-tuned tables were tuned
TUNED_AT = {
    "c172p": TrimCondition(altitude=5000.0, speed=90.0),
    "737": TrimCondition(altitude=10_000.0, speed=280.0, gear=0.0),
    "global5000": TrimCondition(altitude=15_000.0, speed=250.0, gear=0.0),
}

# what the steps are held to: settling in s, overshoot and error at the end in their unit
LIMITS = {
    "pitch": (4.0, 0.25, 0.05),
    "roll": (5.0, math.inf, 0.05),
    "heading": (math.inf, 0.5, 0.05),
    "altitude": (math.inf, 5.0, 0.1),
    "speed": (math.inf, math.inf, 0.15),
}

# ft: altitude kept in a step of the airspeed
KEPT = 15.0

# less throttle than this is left where +10 kt cannot be flown: the step is one down
FULL = 0.85

HEADER = """\
| aircraft | KCAS | pitch: s, deg | roll: s, deg | heading: s, deg | in the turn: sideslip deg, ft \
| altitude: s, ft | speed: s, kt, ft | largest error at the end | predicted settling | |
|---|--:|--:|--:|--:|--:|--:|--:|---|--:|---|
"""


def flights(name, gains, condition, create, predicted=None):
    """One row of the table of flights; ``predicted`` are settling times by loop."""

    def fresh():
        return Aircraft(name, condition=condition, create=create)

    throttle = fresh().trim.throttle[0]
    cells, missed, late, apart = [], [], [], []
    for loop, step in STEPS.items():
        size, seconds = step.size, step.seconds
        if loop == "speed" and throttle > FULL:
            size = -size
        climb = gains.altitude.hdot_max
        if loop == "altitude":
            seconds = 80.0 + 1.3 * size / climb
        try:
            flown = fly_step(fresh, gains, step, size, seconds)
        except FlightError:
            cells.append("ends")
            missed.append(loop)
            continue
        quality = flown.quality
        settling, overshoot, error = LIMITS[loop]
        kept = np.abs(flown.outputs["h"] - flown.outputs["h"][0]).max()
        fits = quality.settling <= settling and quality.overshoot <= overshoot
        if loop == "speed":
            fits = fits and kept <= KEPT
        if not fits:
            missed.append(loop)
        if not quality.steady_error <= error:
            missed.append(f"{loop} error")
        late.append((quality.steady_error / error, f"{loop} {quality.steady_error:.2g}"))
        if predicted:
            apart.append(abs(quality.settling / predicted[loop] - 1.0))
        text = f"{quality.settling:.1f}, {quality.overshoot:.2g}"
        if loop == "heading":
            slip = np.abs(flown.outputs["beta"] - flown.outputs["beta"][0]).max()
            cells += [text, f"{slip:.1f}, {kept:.0f}"]
        elif loop == "speed":
            cells.append(f"{text}, {kept:.0f}")
        else:
            cells.append(text)
    cells += [max(late)[1] if late else "", f"{max(apart):.0%}" if apart else ""]
    verdict = "passes" if not missed else f"not: {', '.join(missed)}"
    return f"| {name} | {condition.speed:.0f} | {' | '.join(cells)} | {verdict} |\n"


def nominal(name):
    """Gains, condition and properties to create of a table's nominal point, and its report."""
    file = table_of(name)
    schedule = read_gains(file)
    point = json.loads(file.read_text(encoding="utf-8"))["points"][schedule.nominal]
    flight = level_flight(name)
    condition = replace(
        flight.condition, altitude=float(point["altitude"]), speed=float(point["speed"])
    )
    predicted = {loop: row.get("settling") for loop, row in point["report"].items()}
    return schedule.points[schedule.nominal].gains, condition, flight.create, predicted


def fly(names):
    """Fly the steps with the tables, and put the rows into the page."""
    rows = []
    for name in names or aircraft_names():
        if table_of(name).exists():
            rows.append(flights(name, *nominal(name)))
            print(rows[-1], end="", flush=True)
    if not names:
        page = Path(__file__).with_name("designed-gains.md")
        put(page, "flights", HEADER + "".join(rows).rstrip())
        put(page, "hand-tuned", HEADER + "".join(compared()).rstrip())


def compared():
    """Rows of the hand-tuned tables at their points, and of designs there."""
    for name, condition in TUNED_AT.items():
        designed = design_gains(name, condition, check=False)
        predicted = {row.loop: row.settling for row in designed.report}
        for kind, row in (
            ("hand-tuned", flights(name, GAINS[name], condition, {})),
            ("designed", flights(name, designed, condition, {}, predicted)),
        ):
            yield row.replace(name, f"{name}, {kind}", 1)


def main(names):
    TABLES.mkdir(exist_ok=True)
    for name in names or aircraft_names():
        try:
            found = designed(name)
        except BlocksError as error:
            print(f"{name}: no table: {error}", flush=True)
        else:
            found = replace(found, refused=())
            found.save(table_of(name))


if __name__ == "__main__":
    chosen = [name for name in sys.argv[1:] if name != "--fly"]
    (fly if "--fly" in sys.argv else main)(chosen)
