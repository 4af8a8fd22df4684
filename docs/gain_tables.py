"""Make the gain tables of the fleet.

Each aircraft that trims in level flight (`docs/evidence/fleet.csv`) gets gains at three altitudes
and three airspeeds, where it trims there, in
`src/pathsim_jsbsim_blocks/control/tables/AIRCRAFT.json`. The hand-tuned tables keep their names:
the designed ones of these aircraft are called `AIRCRAFT-designed`.

With ``--fly`` the steps are flown with the existing tables, for the tables of `docs/evidence`;
with ``--cruise`` those of airliners at cruise altitudes; with ``--slow`` slowly near the ground;
with ``--airspeed`` large steps of the airspeed; with ``--rough`` in turbulence and in a shear.
"""

import argparse
import itertools
import json
import math
from dataclasses import replace
from functools import partial
from operator import attrgetter

import numpy as np
from tables import EVIDENCE, measured, put, read_table, write_table

from pathsim_jsbsim_blocks import Aircraft, Autopilot, TrimCondition
from pathsim_jsbsim_blocks.control.gain_tables import TABLES, read_gains, table
from pathsim_jsbsim_blocks.design import (
    DesignedGains,
    DesignedSchedule,
    design_gains,
    design_schedule,
)
from pathsim_jsbsim_blocks.design.requirements import (
    ALTITUDE_KEPT,
    ALTITUDE_KEPT_OFF,
    CHANGE,
    MAX_SECONDS_AT_A_STOP,
    MAX_SIDESLIP,
    STEP_REQUIREMENTS,
)
from pathsim_jsbsim_blocks.design.steps import STEPS, fly_step
from pathsim_jsbsim_blocks.errors import BlocksError, DesignError, FlightError, TrimError
from pathsim_jsbsim_blocks.flight import Airframe, aircraft_names, level_flight, trim

# of the airspeed of level flight
SPEEDS = (0.8, 1.0, 1.25)

# ft
LOWEST, HIGHER = 1000.0, 5000.0

# ft, with the shares of the airspeed there: airliners on the way to their cruise, and in it
CRUISE = {22_500.0: SPEEDS, 35_000.0: SPEEDS[:2]}
CRUISE_FLOWN = (24_000.0, 33_000.0)
AIRLINERS = ("737", "787-8", "A320", "fokker100", "global5000")


def flight_of(name):
    """Level flight of an aircraft by JSBSim's search, or else by the Newton search."""
    try:
        return level_flight(name)
    except TrimError:
        return level_flight(name, solver="newton")


def altitudes(name, middle):
    """Altitudes of a table in ft, for each those to try until one has a trim, and the airspeeds."""
    yield (middle,), SPEEDS
    yield (LOWEST, 0.5 * (LOWEST + middle)), SPEEDS
    yield (middle + HIGHER, middle + 0.5 * HIGHER), SPEEDS
    if name in AIRLINERS:
        yield from (((altitude,), speeds) for altitude, speeds in CRUISE.items())


def fastest(name):
    """VMO or VNE in KCAS, and MMO, as far as they are known."""
    for row in read_table("autopilots-limits"):
        if row["aircraft"].partition(" ")[0] == name:
            return {limit: float(row[limit]) for limit in ("vmo", "mmo") if row[limit]}
    return {}


def designed(name):
    """The designs of one aircraft."""
    flight = flight_of(name)
    condition = flight.condition

    def said(found):
        text = "designed" if isinstance(found, DesignedGains) else f"{found}"
        print(f"{name}: {text}", flush=True)

    designs = []
    for tries, speeds in altitudes(name, condition.altitude):
        for altitude in tries:
            try:
                found = design_schedule(
                    name,
                    condition,
                    [altitude],
                    [float(round(share * condition.speed)) for share in speeds],
                    progress=said,
                    near=designs,
                    create=flight.create,
                )
            except (TrimError, DesignError):
                if altitude == condition.altitude:
                    raise
            else:
                designs += found.designs
                break
    limits = fastest(name)
    designs = [replace(d, envelope=replace(d.envelope, **limits)) for d in designs]
    designs.sort(key=lambda design: (design.condition.altitude, design.condition.speed))
    nominal = [
        (d.condition.altitude, d.condition.speed) == (condition.altitude, condition.speed)
        for d in designs
    ].index(True)
    return DesignedSchedule(tuple(designs), nominal, ())


def table_of(name):
    """File of the designed table of an aircraft."""
    return TABLES / f"{name}{'-designed' if name in TUNED_AT else ''}.json"


# where the hand-tuned tables were tuned
TUNED_AT = {
    "c172p": TrimCondition(altitude=5000.0, speed=90.0),
    "737": TrimCondition(altitude=10_000.0, speed=280.0, gear=0.0),
    "global5000": TrimCondition(altitude=15_000.0, speed=250.0, gear=0.0),
}

# older tables that are made again only by name: with little throttle left the new ones fly worse,
# the landings of the c172p were flown with its own, and JSBSim's search trims the Short_S23 at the
# altitudes of its own only
KEPT = ("J3Cub", "Short_S23", "c172p", "c172r", "dr1", "pa28")

# a step of the airspeed is one down where level flight at its end would need more throttle than
# this, and more than before
FULL = 0.85

# s of the steps, that of the altitude without its climb
SECONDS = {x: r.seconds for x, r in STEP_REQUIREMENTS.items()} | {"altitude": 80.0}


def asked(loop, gains, condition, down, seconds):
    """Size and seconds of a step, one down for the loops in ``down``, longer by its climb."""
    size = STEP_REQUIREMENTS[loop].size
    if loop == "altitude":
        seconds += 1.3 * size / at_point(gains, condition).altitude.hdot_max
    return -size if loop in down else size, seconds


def no_throttle(fresh, condition, trim):
    """Loops whose step up takes all of the throttle; ``fresh`` makes an aircraft."""
    faster = replace(condition, speed=condition.speed + STEP_REQUIREMENTS["speed"].size)
    now = max(trim.throttle)
    try:
        needed = max(fresh(condition=faster).trim.throttle)
    except TrimError as error:
        needed = math.inf if error.reason == "thrust" else now
    return {"speed"} if needed > max(FULL, now) else set()


def flights(label, gains, condition, create, predicted=None):
    """The row of a table's steps; the label is the aircraft's name, or begins with it and a comma.

    ``predicted`` are settling times by loop.
    """
    fresh = partial(Aircraft, label.partition(",")[0], condition=condition, create=create)
    down = no_throttle(fresh, condition, fresh().trim)
    row = {"aircraft": label, "KCAS": f"{condition.speed:.0f}"}
    missed, late, apart = [], [], []
    for loop, step in STEPS.items():
        asked_for = STEP_REQUIREMENTS[loop]
        column = f"{loop}: s, {asked_for.unit}{', ft' if loop == 'speed' else ''}"
        size, seconds = asked(loop, gains, condition, down, SECONDS[loop])
        try:
            flown = fly_step(fresh, gains, step, size, seconds)
        except FlightError:
            row[column] = "ends"
            missed.append(loop)
            continue
        quality = flown.quality
        kept = largest_change(flown, "h")
        fits = quality.settling <= asked_for.settling and quality.overshoot <= asked_for.overshoot
        if loop == "speed":
            fits = fits and kept <= ALTITUDE_KEPT
        if not fits:
            missed.append(loop)
        if not quality.steady_error <= asked_for.final_error:
            missed.append(f"{loop} error")
        row[column] = f"{quality.settling:.1f}, {quality.overshoot:.2g}"
        if loop == "heading":
            slip = largest_change(flown, "beta")
            row["in the turn: sideslip deg, ft"] = f"{slip:.1f}, {kept:.0f}"
        elif loop == "speed":
            row[column] += f", {kept:.0f}"
        share = quality.steady_error / asked_for.final_error
        late.append((share, f"{loop} {quality.steady_error:.2g}"))
        if predicted:
            if loop in ("altitude", "speed"):
                # predicted are the gains of this point, which a table changes during these steps
                quality = fly_step(fresh, at_point(gains, condition), step, size, seconds).quality
            apart.append(abs(quality.settling / predicted[loop] - 1.0))
    row["largest error at the end"] = max(late)[1] if late else ""
    row["predicted settling"] = f"{max(apart):.0%}" if apart else ""
    row["verdict"] = "passes" if not missed else f"not: {', '.join(missed)}"
    return row


def largest_change(flown, output):
    """The farthest that an output moves from its value at the beginning of a step."""
    y = flown.outputs[output]
    return np.abs(y - y[0]).max()


def at_point(gains, condition):
    """The gains of a table, or those given, at a condition."""
    return gains.at(condition.altitude, condition.speed) if hasattr(gains, "at") else gains


def nominal(name):
    """Gains, condition and properties to create of a table's nominal point, and its report."""
    file = table_of(name)
    schedule = read_gains(file)
    point = json.loads(file.read_text(encoding="utf-8"))["points"][schedule.nominal]
    flight = flight_of(name)
    condition = replace(
        flight.condition, altitude=float(point["altitude"]), speed=float(point["speed"])
    )
    predicted = {loop: row.get("settling") for loop, row in point["report"].items()}
    return schedule, condition, flight.create, predicted


# s of flight after steps at cruise altitudes
CRUISE_SECONDS = {"pitch": 10.0, "roll": 12.0, "heading": 60.0, "altitude": 40.0, "speed": 75.0}


def fuel(plane, share):
    """Contents of the tanks in lb, all at the same share of what they hold."""
    fdm, contents = plane.airframe.fdm, {}
    for i, tank in enumerate(plane.airframe.tanks):
        percent = fdm[tank.replace("contents-lbs", "pct-full")]
        if percent > 0.0:
            contents[i] = share * fdm[tank] / (0.01 * percent)
    return contents


def cruise_point(name, schedule, condition, create):
    """What the steps at one condition do not meet, or "passes"."""
    fresh = partial(Aircraft, name, condition=condition, create=create)
    try:
        trim = fresh().trim
    except TrimError:
        return "no trim"
    down = no_throttle(fresh, condition, trim)
    size = math.radians(STEP_REQUIREMENTS["pitch"].size)
    if trim.tas * math.sin(size) > at_point(schedule, condition).envelope.climb_max:
        # at full throttle the airspeed would fall for as long as the pitch angle is held
        down.add("pitch")
    missed = []
    for loop, step in STEPS.items():
        size, seconds = asked(loop, schedule, condition, down, CRUISE_SECONDS[loop])
        try:
            flown = fly_step(fresh, schedule, step, size, seconds)
        except FlightError:
            missed.append(f"{loop} ends")
            continue
        if not flown.quality.settling <= STEP_REQUIREMENTS[loop].settling_off:
            missed.append(f"{loop} {flown.quality.settling:.1f} s".replace("inf s", "not settled"))
        if flown.stop > MAX_SECONDS_AT_A_STOP:
            missed.append(f"{loop} at a stop {flown.stop:.0f} s")
        if loop == "heading":
            slip = largest_change(flown, "beta")
            if slip > MAX_SIDESLIP:
                missed.append(f"sideslip {slip:.1f} deg")
        elif loop == "speed":
            kept = largest_change(flown, "h")
            if kept > ALTITUDE_KEPT_OFF:
                missed.append(f"{kept:.0f} ft in speed")
    return "; ".join(missed) or "passes"


def cruise_rows(name):
    """The row of the steps of an airliner at cruise altitudes between those of its table."""
    schedule, condition, create, _ = nominal(name)
    row = {"aircraft": name, "KCAS": f"{condition.speed:.0f}"}
    for altitude in CRUISE_FLOWN:
        point = replace(condition, altitude=altitude)
        row[f"{altitude:,.0f} ft"] = cruise_point(name, schedule, point, create)
    yield row


# what is fed back
FED_BACK = {
    "pitch": ("Kp", "Ki", "Kr"),
    "roll": ("Kp", "Ki", "Kr"),
    "heading": ("Kp",),
    "altitude": ("Kh", "Kp", "Ki"),
    "speed": ("Kp", "Ki"),
    "yaw": ("K",),
}


def jumps(schedule):
    """By loop: gains of neighbouring points, and those that change by more than `CHANGE`.

    Between airspeeds the effect of a control changes with the dynamic pressure; where this is more,
    it is what a gain may change by.
    """
    changes = {loop: [0, 0] for loop in FED_BACK}
    for axis, other in (("altitude", "speed"), ("speed", "altitude")):
        points = sorted(schedule.points, key=attrgetter(axis, other))
        for a, b in itertools.pairwise(points):
            if getattr(a, axis) != getattr(b, axis):
                continue
            most = max(CHANGE, (b.speed / a.speed) ** 2)
            for loop, names in FED_BACK.items():
                gains = getattr(a.gains, loop), getattr(b.gains, loop)
                for name in names:
                    low, high = sorted(abs(getattr(loop_gains, name)) for loop_gains in gains)
                    changes[loop][0] += 1
                    changes[loop][1] += high > 1.001 * most * low
    return changes


def step_rows(name):
    """The row of a table's steps."""
    yield flights(name, *nominal(name))


def compared():
    """Rows of the hand-tuned tables at their points, and of designs there."""
    for name, condition in TUNED_AT.items():
        designed = design_gains(name, condition, check=False)
        predicted = {row.loop: row.settling for row in designed.report}
        yield flights(f"{name}, hand-tuned", table(name).points[0].gains, condition, {})
        yield flights(f"{name}, designed", designed, condition, {}, predicted)


def turbulence(severity, wind, seed):
    """Properties of JSBSim's MIL-spec turbulence, for a wind in ft/s at 20 ft."""
    return {
        "atmosphere/randomseed": float(seed),
        "atmosphere/turb-type": 3.0,
        "atmosphere/turbulence/milspec/severity": severity,
        "atmosphere/turbulence/milspec/windspeed_at_20ft_AGL-fps": wind,
    }


# ft above the ground; of the lowest level airspeed: found by steps of this ratio, and where flights
# begin, in this order; what is asked for; s; random seeds
NEAR, FINE, BEGINS = 200.0, 0.99, (1.25, 1.35, 1.5)
TOO_SLOW, NEAR_SECONDS, SEEDS = 0.8, 90.0, (1, 2, 3)
SLOW_T = 1 / 60
# of the airspeed of level flight, where gear and flaps come down; deg or of the throttle, by which
# they change it
FASTEST_DOWN, MOVED = (1.0, 0.9, 0.8, 0.7, 0.6, 0.5, 0.45), 0.01
# deg, where the flaps bring the stall below the angle of attack that the table allows
ALPHA_DOWN = {"F80C": 12.0, "T38": 12.0, "fokker100": 10.0}


def lowest_level(name, condition, create):
    """The lowest airspeed in KCAS at which the aircraft trims on the way down from a condition."""
    speed = condition.speed
    while True:
        try:
            trim(Airframe(name, create=create), replace(condition, speed=FINE * speed), hint=False)
        except BlocksError:
            return speed
        speed *= FINE


def lowered(name, condition, create):
    """The condition with gear and flaps down, at an airspeed where it trims; None without any."""

    def trimmed(there):
        return trim(Airframe(name, create=create), there, hint=False)

    for share in FASTEST_DOWN:
        down = replace(condition, gear=1.0, flaps=1.0, speed=share * condition.speed)
        try:
            there = trimmed(down)
        except TrimError:
            continue
        try:
            clean = trimmed(replace(condition, speed=down.speed))
        except TrimError:
            return down
        # alpha or thrust: a model may have the commands and neither gear nor flaps
        moved = abs(there.alpha - clean.alpha), abs(max(there.throttle) - max(clean.throttle))
        return down if max(moved) > MOVED else None
    return None


def begun(name, condition, lowest, flight, seed):
    """An aircraft in turbulence, at the first of some airspeeds at which it trims."""
    for share in BEGINS:
        try:
            return Aircraft(
                name,
                condition=replace(condition, speed=share * lowest),
                create=flight.create,
                properties=turbulence(3.0, 25.0, seed),
                T=SLOW_T,
                substeps=2,
                output_properties=["h_agl"],
            )
        except TrimError as error:
            failed = error
    raise failed


def seen_by(plane):
    """The outputs of an aircraft by name."""
    return dict(zip(plane.output_port_labels, map(float, plane.outputs.to_array()), strict=True))


def flown_by(autopilot, plane, samples, asked):
    """Fly without a diagram: the commands, and the outputs after them, at each sample.

    ``asked(k, seen)`` gives references, and may do something to the aircraft.
    """
    ports, state, seen = list(plane.output_port_labels), autopilot.initial_state(), seen_by(plane)
    for k in range(samples):
        inputs = asked(k, seen) | seen
        u = [inputs.get(port, 0.0) for port in autopilot.input_port_labels]
        command, state = autopilot.law(u, state)
        y = plane.advance(k + 1, [*command[:4], 0.0, 0.0, 0.0])
        seen = dict(zip(ports, y, strict=True))
        yield command, seen


def slow_flight(name, plane, vc_ref, alpha_max):
    """Height, airspeed and angle of attack beyond its limit, at each sample."""
    autopilot = Autopilot(str(table_of(name)), vc_ref=vc_ref, T=SLOW_T, alpha_max=alpha_max)
    limits, limit, rows = read_gains(table_of(name)), 0.0, []

    def noted(k, seen):
        nonlocal limit
        if k % 60 == 0:
            limit = alpha_max or limits.at(seen["h"], seen["vc"]).envelope.alpha_max
        rows.append((seen["h_agl"], seen["vc"], seen["alpha"] - limit))
        return {}

    for _ in flown_by(autopilot, plane, round(NEAR_SECONDS / SLOW_T), noted):
        pass
    return np.array(rows).T


def slow_rows(name):
    """Rows of the table of flights near the ground that are asked to be too slow."""
    flight = flight_of(name)
    clean = replace(flight.condition, altitude=NEAR, solver="newton")
    down = lowered(name, clean, flight.create)
    yield slow_row(name, name, clean, flight)
    if down:
        most = ALPHA_DOWN.get(name)
        label = f"{name} with gear and flaps down" + (f"; alpha_max={most:g}" if most else "")
        yield slow_row(name, label, down, flight, most)


def slow_row(name, label, condition, flight, alpha_max=None):
    """The row of one configuration."""
    lowest = lowest_level(name, condition, flight.create)
    row = {"aircraft": label, "lowest level KCAS by trim": f"{lowest:.0f}"}
    row["asked for"] = f"{TOO_SLOW * lowest:.0f}"
    heights, speeds, alphas = [], [], []
    for seed in SEEDS:
        plane = begun(name, condition, lowest, flight, seed)
        try:
            h, vc, alpha = slow_flight(name, plane, TOO_SLOW * lowest, alpha_max)
        except FlightError:
            return row | {"lowest height of three, ft": "ends"}
        heights.append(h.min())
        speeds.append(vc.min())
        alphas.append(np.convolve(alpha, np.full(120, 1 / 120), "valid").max())
    return row | {
        "lowest height of three, ft": f"{min(heights):.0f}",
        "lowest KCAS": f"{min(speeds):.0f}",
        "largest alpha, mean of 2 s, less alpha_max, deg": f"{max(alphas):+.1f}",
    }


# steps of the airspeed, shares of it; s before the step, after it, and from which it is judged
SPEED_STEPS, SPEED_BEFORE, SPEED_AFTER, SPEED_JUDGED = (-0.2, -0.1, 0.1, 0.2), 5.0, 100.0, 75.0


def speed_steps(schedule):
    """Airspeeds before and after steps, within those of a table at its nominal altitude."""
    nominal = schedule.points[schedule.nominal]
    speeds = sorted(p.speed for p in schedule.points if p.altitude == nominal.altitude)
    low, high = speeds[0] - 0.6, speeds[-1] + 0.6
    for share in SPEED_STEPS:
        goal = (1.0 + share) * nominal.speed
        # a table of one airspeed has those around it
        if len(speeds) == 1 or low <= goal <= high:
            yield nominal.speed, goal
    for start, share in ((speeds[0], 0.2), (speeds[-1], -0.2)):
        if start != nominal.speed:
            yield start, (1.0 + share) * start


def speed_rows(name):
    """Rows of the table of large steps of the airspeed."""
    schedule, flight = read_gains(table_of(name)), flight_of(name)
    altitude = schedule.points[schedule.nominal].altitude
    for start, goal in speed_steps(schedule):
        condition = replace(flight.condition, altitude=altitude, speed=start)
        plane = Aircraft(name, condition=condition, create=flight.create, T=SLOW_T, substeps=2)
        autopilot = Autopilot(gains=schedule, T=SLOW_T)
        before, after = round(SPEED_BEFORE / SLOW_T), round(SPEED_AFTER / SLOW_T)
        size = goal - start

        def asked(k, _, size=size, before=before):
            return {"vc_ref": size * (k >= before)}

        flown = flown_by(autopilot, plane, before + after, asked)
        y = np.array([(seen["vc"], seen["h"], seen["thr_sat"]) for _, seen in flown])
        vc, h, stop = y[before:].T
        error = np.sign(size) * (vc - goal)
        outside = np.flatnonzero(np.abs(error) > 1.0)
        time = (outside[-1] + 1) * SLOW_T if len(outside) else 0.0
        late = np.abs(error[round(SPEED_JUDGED / SLOW_T) :]).max()
        yield {
            "aircraft": name,
            "from KCAS": f"{start:.0f}",
            "to KCAS": f"{goal:.0f}",
            "within 1 kt after s": f"{time:.0f}" if time < SPEED_AFTER else "",
            "largest error after 75 s, kt": f"{late:.1f}",
            "beyond the goal, kt": f"{max(error.max(), 0.0):.1f}",
            "altitude, ft": f"{np.abs(h - h[0]).max():.0f}",
            "throttle at its stop": f"{(stop != 0.0).mean():.0%}",
        }


# turbulence of severity 4: s of flight, and from which it is judged; s and deg of a turn; then a
# headwind in ft/s that goes within some s from another s on, and the flight's s
ROUGH = turbulence(4.0, 50.0, seed=7)
ROUGH_SECONDS, ROUGH_JUDGED, ROUGH_TURN = 200.0, 10.0, (30.0, 30.0)
SHEAR, SHEAR_FROM, SHEAR_WITHIN, SHEAR_SECONDS = 50.0, 5.0, 15.0, 60.0


def rough_rows(name):
    """The row of the table of flights in turbulence and in a shear."""
    schedule, condition, create, _ = nominal(name)

    def flown(seconds, wanted, properties=None, wind=None):
        there = replace(condition, heading=0.0, wind_north=-SHEAR) if wind else condition
        plane = Aircraft(
            name, condition=there, create=create, properties=properties, T=SLOW_T, substeps=2
        )
        autopilot, rows = Autopilot(gains=schedule, T=SLOW_T), []

        def asked(k, seen):
            if wind:
                plane.fdm["atmosphere/wind-north-fps"] = wind(k * SLOW_T)
            return wanted(k * SLOW_T)

        for command, seen in flown_by(autopilot, plane, round(seconds / SLOW_T), asked):
            throttle = command[3] - seen["thr_sat"]
            rows.append((seen["vc"] - condition.speed, throttle, seen["thr_sat"], seen["h"]))
        return np.array(rows).T

    begin, angle = ROUGH_TURN
    signals = flown(ROUGH_SECONDS, lambda t: {"psi_ref": angle * (t > begin)}, properties=ROUGH)
    error, throttle, stop, h = signals[:, round(ROUGH_JUDGED / SLOW_T) :]
    travel = np.abs(np.diff(throttle)).sum() / (ROUGH_SECONDS - ROUGH_JUDGED)

    def wind(t):
        return -SHEAR * (1.0 - min(max((t - SHEAR_FROM) / SHEAR_WITHIN, 0.0), 1.0))

    lowest = flown(SHEAR_SECONDS, lambda t: {}, wind=wind)[0].min()
    h -= condition.altitude
    yield {
        "aircraft": name,
        "KCAS": f"{condition.speed:.0f}",
        "travel of the throttle per s": f"{travel:.3f}",
        "at a stop": f"{(stop != 0.0).mean():.0%}",
        "airspeed, rms kt": f"{np.sqrt(np.mean(error**2)):.1f}",
        "altitude, ft": f"{h.min():.0f} to {h.max():.0f}",
        "lowest airspeed as 30 kt of headwind go, kt": f"{lowest:.1f}",
    }


FLIGHTS = {
    "fly": ("designed-gains-steps", step_rows),
    "cruise": ("designed-gains-cruise", cruise_rows),
    "slow": ("autopilots-near-ground", slow_rows),
    "airspeed": ("designed-gains-airspeed", speed_rows),
    "rough": ("designed-gains-turbulence", rough_rows),
}


def fly(kind, names):
    """Fly the aircraft that have gains, and write the rows of a kind of flight as its table."""
    file, rows_of = FLIGHTS[kind]
    fleet = AIRLINERS if kind == "cruise" else [n for n in aircraft_names() if table_of(n).exists()]
    rows = []
    for name in names or fleet:
        for row in rows_of(name):
            print(*row.values(), sep=" | ", flush=True)
            rows.append(row)
    if names:
        return
    write_table(file, rows)
    if kind == "fly":
        write_table("designed-gains-hand-tuned", list(compared()))
    if kind != "slow":
        tables = [name for name, _ in FLIGHTS.values() if name.startswith("designed-gains")]
        put(EVIDENCE / "designed-gains.md", "commit", measured(*tables))


def main(names):
    """Design the tables of aircraft."""
    for name in names or (name for name in aircraft_names() if name not in KEPT):
        try:
            found = designed(name)
        except BlocksError as error:
            print(f"{name}: no table: {error}", flush=True)
        else:
            found.save(table_of(name))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("aircraft", nargs="*")
    do = parser.add_mutually_exclusive_group()
    for kind in FLIGHTS:
        flight = partial(fly, kind)
        do.add_argument(f"--{kind}", dest="do", action="store_const", const=flight, default=main)
    options = parser.parse_args()
    options.do(options.aircraft)
