"""Tables of the documentation: written as CSV beside the evidence, or put into a page."""

import csv
import math
import re
import subprocess
from pathlib import Path

from pathsim_jsbsim_blocks.design import requirements

DOCS = Path(__file__).resolve().parent
EVIDENCE = DOCS / "evidence"


def write_table(name, rows):
    """Write rows, dicts of texts, as CSV beside the pages of evidence, which have no long tables.

    The longest row has all columns. The last column is the commit whose code has made a row, unless
    the row has it already.
    """
    made_by = {"commit": commit()}
    columns = {**max(rows, key=len), **made_by}
    with open(EVIDENCE / f"{name}.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows({**made_by, **row} for row in rows)


def markdown(head, rows, align="--:", first="---"):
    """A table in Markdown under the line of its head; all columns but the first aligned alike."""
    rule = f"|{first}|{f'{align}|' * (head.count('|') - 2)}"
    return "\n".join([head, rule, *(f"| {' | '.join(cells)} |" for cells in rows)])


def commit():
    """The commit of the code that runs."""
    command = ["git", "log", "-1", "--abbrev=9", "--format=%h"]
    return subprocess.check_output(command, cwd=DOCS, text=True).strip()


def read_table(name):
    """The rows of a table of evidence, as dicts of texts."""
    with open(EVIDENCE / f"{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def measured(*names):
    """The first line of a page of evidence: the code that has made its tables."""
    commits = sorted({row["commit"] for name in names for row in read_table(name)})
    if len(commits) == 1:
        return f"Measured with the code of commit `{commits[0]}`."
    return f"Measured with the code of the commits {', '.join(f'`{c}`' for c in commits)}."


def put(page, name, text):
    """Put a generated text in its place on a page."""
    place = re.compile(rf"(<!-- {name} -->\n).*?(\n<!-- end -->)", re.DOTALL)
    before = page.read_text(encoding="utf-8")
    assert len(place.findall(before)) == 1, f"{page} has no place for {name}"
    page.write_text(place.sub(lambda m: m[1] + text + m[2], before), encoding="utf-8")


STEP_HEAD = """\
| step | settles to | within | off the design point | overshoot | error at the end \
| fraction of the travel |"""
FURTHER = """

| further | at the design point | off it |
|---|--:|--:|
| altitude error in a step of the airspeed | {ALTITUDE_KEPT:g} ft | {ALTITUDE_KEPT_OFF:g} ft |
| sideslip in the turn | | {MAX_SIDESLIP:g} deg |
| a command at its stop | | {MAX_SECONDS_AT_A_STOP:g} s |
| maximum altitude error in moderate turbulence | {ALTITUDE_IN_TURBULENCE:g} ft | |
| pitch angle in moderate turbulence | {PITCH_IN_TURBULENCE:g} deg rms | |
| throttle at a stop in moderate turbulence | {STOP_IN_TURBULENCE:.0%} of the time | |
| throttle in moderate turbulence, of the smaller distance to a stop \
| {THROTTLE_IN_TURBULENCE:.2g} rms | |
| throttle per airspeed | {THROTTLE_PER_KNOT:g} 1/kt | |
| damping ratio of the Dutch roll | {DUTCH_ROLL:g} | |
| divergence that is left to the outer loops | {DIVERGENCE:g} 1/s | |
| rudder for {YAW_RATE:g} deg/s of yaw and {SIDESLIP:g} deg of sideslip, of its remaining travel \
| {RUDDER_USE:g} | |
| rudder in the entry of a turn, of its remaining travel | {TURN_USE:g} | |
| factor between the gains of neighbouring conditions, and the aim of the search \
| {CHANGE:g}, {CHANGE_AIM:g} | |

| maximum commanded | |
|---|--:|
| load factor increment of a moving pitch reference | {RAMP_LOAD:g} g |
| its rate | {RAMP_LOW:g} to {RAMP_HIGH:g} deg/s |
| pitch reference | {THETA_MAX:g} deg, {NOSE_UP:g} deg above level flight |
| rate of the roll reference | {ROLL_RAMP:g} deg/s |
| sideslip rate in a roll, p sin &alpha;, but p at least {ROLL_SLOW:g} deg/s | {ROLL_SLIP:g} deg/s |
| bank of a turn | {BANK:g} deg |
| rate of climb | {CLIMB:g} ft/s, {CLIMB_OF_EXCESS:.0%} of the excess |
| rate of climb whose feed-forward is the remaining throttle | {RISE:g} ft/s, \
or {RISE_OF_EXCESS:g} times the excess if less, but at least {LEAST_RISE:g} ft/s |
| step up of the airspeed in the design, of the remaining throttle | {THROTTLE_USE:g} |
| airspeed error that counts in full | {GUST:g} kt |
| crossover of the airspeed loop, and its Kp / Ki \
| {SPEED_CROSSOVERS[0]:g} to {SPEED_CROSSOVERS[1]:g} rad/s, {SPEED_TIME:g} s |
| rate of its reference | {SPEED_RAMP:g} kt/s, or the airspeed in {SPEED_RAMP_TIME:g} s |
| angle of attack | {ALPHA:g} deg, {LIFT:.0%} of the maximum lift |"""


def requirements_table():
    """The requirements of the loops, as tables in Markdown."""

    def limit(value, unit):
        return "" if math.isinf(value) else f"{value:g} {unit}".rstrip()

    margins, steps = [], []
    for i, m in enumerate(requirements.MARGINS):
        name = f"fallback {i}" if i else "target"
        numbers = f"{m.Ms:g}", f"{m.Ms_delayed:g}", f"{m.gain:g} dB", f"{m.phase:g} deg"
        margins.append((name, *numbers))
    for loop, r in requirements.STEP_REQUIREMENTS.items():
        size = f"{loop}, {r.size:g} {r.unit}", f"{r.tolerance:g} {r.unit}"
        settling = limit(r.settling, "s"), limit(r.settling_off, "s")
        errors = limit(r.overshoot, r.unit), limit(r.final_error, r.unit)
        steps.append((*size, *settling, *errors, limit(r.use, "")))
    tables = (
        markdown("| margins | Ms | with 50 ms of delay | gain | phase |", margins),
        markdown(STEP_HEAD, steps),
    )
    return "\n\n".join(tables) + FURTHER.format(**vars(requirements))
