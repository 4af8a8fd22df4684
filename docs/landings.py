"""Land in random cases and write the tables of docs/evidence/landings.md.

    python docs/landings.py [CASES [SEED]]
    python docs/landings.py crosswind

Default is 100 cases of each aircraft; another seed draws others and prints what becomes of them.
Each flies the diagram ``autoland_737`` or ``autoland_c172p`` with weight, centre of gravity, wind,
turbulence, course and elevation of the runway drawn anew.

With ``crosswind`` five tables make 20 approaches each at 1.3 of the lowest airspeed that trims, in
10 kt of crosswind with turbulence.
"""

import math
import sys
from dataclasses import replace

import numpy as np
from gain_tables import flight_of, fuel, lowest_level, turbulence
from tables import EVIDENCE, markdown, put

from pathsim_jsbsim_blocks import Aircraft, FlightError, TrimCondition, TrimError, fly
from pathsim_jsbsim_blocks.catalogue import load_diagram
from pathsim_jsbsim_blocks.flight import Airframe, trim

CASES = 100
PAGE = EVIDENCE / "landings.md"
KNOT = 1.68781  # ft/s
# JSBSim's turbulence counts its height from sea level: beyond 2000 ft this, not the wind at 20 ft,
# sets its rms, 3.3 to 3.6 ft/s
SEVERITY = 2.0
AIM = (47.0, 11.0)
BEYOND = 8000.0  # ft, from the aiming point to the antenna of the localizer

# tanks and empty weight [lb], x of the empty CG and chord [in], airspeed [KCAS] at a weight [lb],
# height above the runway [ft], crosswind [kt], distance from the aiming point [ft]
FLEET = {
    "737": ((10_200, 10_200, 15_000), 83_000, 639.0, 147.7, (148.0, 107_000), 1000.0, 15.0, 2000.0),
    "c172p": ((185, 185), 1680, 41.0, 58.8, (70.0, 1880), 400.0, 10.0, 1000.0),
}
# flaps, and what `FlareHold` has unlike that of `autoland_737`, by table
FLARE = {"tau": 3.0, "float_max": 8000.0, "theta_max": 10.0}
# the elevator of the MD11 turns it slowly
SLOW_FLARE = FLARE | {"tau": 6.0, "sink_max": 25.0}
LIGHT_FLARE = {"tau": 2.0, "float_max": 1400.0, "climb": 8.0, "theta_max": 8.0}
CROSSWIND = {
    "c172p-designed": (0.5, LIGHT_FLARE | {"gear_height": 4.4}),
    "A320": (1.0, FLARE | {"gear_height": 8.9}),
    "T37": (1.0, FLARE | {"gear_height": 1.9}),
    "MD11": (0.3, SLOW_FLARE | {"gear_height": 19.1}),
    "737-landing": (1.0, {}),
}
# crosswind, and wind at 20 ft [kt] of its turbulence
CROSS, CROSS_GUSTS, APPROACHES = 10.0, 14.0, 20
# of the lowest airspeed, height of the beginning [ft], and airspeeds from which the lowest is
# looked for, of level flight
OF_LOWEST, ABOVE, FROM = 1.3, 700.0, (1.0, 0.9, 0.8, 0.7, 0.6)
INTERCEPT = 20.0  # deg
# KCAS at which a roll-out ends, and its longest, s
ROLLED, LONGEST = 30.0, 60.0
# the touchdown's limits; the distance past the aiming point in a crosswind, ft
PAST = 2000.0
LIMITS = {
    "across": 30.0,  # from the centre line, ft
    "bank": 5.0,  # deg
    "sink": 6.0,  # ft/s
    "roll_out": 40.0,  # from the centre line, ft
}
ROWS = {
    "past": "past the aiming point [ft]",
    "across": "right of the centre line [ft]",
    "sink": "sink rate of the hardest touchdown [ft/s]",
    "bounce": "bounce [ft]",
    "roll_out": "farthest from the centre line in the roll-out [ft]",
    "bank": "bank [deg]",
    "crab": "heading less course [deg]",
    "vc": "airspeed [KCAS]",
}
CROSSWIND_HEAD = """\
| | landed within the limits | went around | KCAS | sink rate [ft/s] | past [ft] | aside [ft] \
| in the roll-out [ft] |"""


def draw(name, cases, seed=0):
    """Random cases."""
    crosswind, rng = FLEET[name][6], np.random.default_rng(seed)
    drawn = {
        "fuel": (0.2, 1.0),  # of the tanks
        "cg": (-0.03, 0.03),  # of the chord
        "head": (-5.0, 20.0),  # kt
        "cross": (-crosswind, crosswind),
        "gusts": (15.0, 30.0),  # kt, the wind at 20 ft of the turbulence
        "course": (0.0, 360.0),  # deg
        "elevation": (0.0, 5000.0),  # ft
        "aside": (-500.0, 500.0),  # ft
    }
    return [
        {**{key: float(rng.uniform(*span)) for key, span in drawn.items()}, "seed": float(i)}
        for i in range(1, cases + 1)
    ]


def place(ahead, aside, course):
    """Latitude and longitude beyond the aiming point and to the right of it, ft."""
    chi, lat = math.radians(course), math.radians(AIM[0])
    north = ahead * math.cos(chi) - aside * math.sin(chi)
    east = ahead * math.sin(chi) + aside * math.cos(chi)
    return AIM[0] + north / 364_785.0, AIM[1] + east / (365_221.0 * math.cos(lat) * 1.0018)


def wind(head, cross, course):
    """North and east component in ft/s of a headwind and a crosswind from the left, kt."""
    chi, head, cross = math.radians(course), head * KNOT, cross * KNOT
    return (
        -head * math.cos(chi) - cross * math.sin(chi),
        -head * math.sin(chi) + cross * math.cos(chi),
    )


def scene(condition, rough, elevation, course):
    """Settings of both kinds of approach: the beginning, the turbulence and the runway."""
    return {
        "aircraft.condition": condition,
        "TURBULENCE": rough,
        "ELEVATION": elevation,
        "COURSE": course,
        "ANTENNA": place(BEYOND, 0.0, course),
    }


def beginning(height, aside, course):
    """Latitude and longitude 6000 ft before the glide path at a height, ft; aside of the course."""
    return place(-height / math.tan(math.radians(3.0)) - 6000.0, aside, course)


def settings(name, case):
    """What the diagram is built with."""
    tanks, empty, cg, chord, (speed, weight), height, *_ = FLEET[name]
    fuel, course = [case["fuel"] * tank for tank in tanks], case["course"]
    north, east = wind(case["head"], case["cross"], course)
    latitude, longitude = beginning(height, case["aside"], course)
    condition = TrimCondition(
        altitude=case["elevation"] + height,
        speed=speed * math.sqrt((empty + sum(fuel)) / weight),
        heading=(course - math.copysign(INTERCEPT, case["aside"])) % 360.0,
        latitude=latitude,
        longitude=longitude,
        wind_north=north,
        wind_east=east,
        fuel=fuel,
        empty_cg_x=cg + case["cg"] * chord,
        gear=1.0 if name == "737" else None,
        flaps=1.0 if name == "737" else 0.5,
    )
    rough = turbulence(SEVERITY, case["gusts"] * KNOT, case["seed"])
    return scene(condition, rough, case["elevation"], course)


def approach(table, number, head, cross, gusts):
    """Course of an approach in a wind, kt, and what the diagram ``autoland_737`` is built with."""
    flaps, flare = CROSSWIND[table]
    name, rng = table.partition("-")[0], np.random.default_rng([number, 7])
    flight = flight_of(name)
    share, course, elevation = rng.uniform(0.2, 0.8), rng.uniform(0, 360), rng.uniform(0, 3000)
    latitude, longitude = beginning(ABOVE, 0.0, course)
    tanks = fuel(Aircraft(name, condition=flight.condition, create=flight.create), share)
    condition = replace(
        flight.condition,
        altitude=elevation + ABOVE,
        fuel=tanks,
        gear=1.0,
        flaps=flaps,
        solver="newton",
    )
    for part in FROM:
        begin = replace(condition, speed=part * condition.speed)
        try:
            trim(Airframe(name, create=flight.create), begin, hint=False)
        except TrimError:
            continue
        break
    north, east = wind(head, cross, course)
    condition = replace(
        condition,
        speed=OF_LOWEST * lowest_level(name, begin, flight.create),
        heading=course,
        latitude=latitude,
        longitude=longitude,
        wind_north=north,
        wind_east=east,
    )
    rough = turbulence(SEVERITY, gusts * KNOT, number)
    built = scene(condition, rough, elevation, course) | {
        "aircraft.aircraft": name,
        "aircraft.create": flight.create,
        **{f"{x}.gains": table for x in ("lateral", "vertical", "airspeed", "damper", "flare")},
        **{f"flare.{key}": value for key, value in flare.items()},
        # of both blocks, as in the diagrams
        **({"vertical.sink_max": flare["sink_max"]} if "sink_max" in flare else {}),
    }
    return course, built


def land(name, case):
    """Fly one case: its touchdown, or where and why it went around."""
    return landed(f"autoland_{name}", settings(name, case), case["course"])


def landed(diagram, settings, course):
    """Fly a diagram with settings: its touchdown, or where and why it went around."""
    diagram, error = load_diagram(diagram, settings), ""
    outputs = diagram.flare.outputs
    try:
        while diagram.sim.time < 300.0 and outputs["phase"] < 2.0:
            fly(diagram.sim, 2.0)
        end = diagram.sim.time + LONGEST
        while diagram.sim.time < end and outputs["phase"] < 3.0:
            if diagram.aircraft.outputs["vc"] < ROLLED:
                break
            fly(diagram.sim, 1.0)
        if outputs["phase"] == 3.0:
            fly(diagram.sim, 30.0)
    except FlightError as crash:
        error = str(crash)
    _, (height, _) = diagram.height.read()
    _, (phase, wheels) = diagram.landing.read()
    _, (climb, vc) = diagram.rates.read()
    _, (_, bank, heading) = diagram.attitude.read()
    _, (across, distance) = diagram.ground.read()
    found = {"error": error, "around": bool((phase == 3.0).any())}
    if found["around"]:
        begun = int(np.argmax(phase == 3.0))
        found.update(begun=height[begun], lowest=height[begun:].min(), end=height[-1])
        found["across"] = across[begun]
    elif wheels.any():
        touch = int(wheels.argmax())
        crab = (heading[touch] - course + 180.0) % 360.0 - 180.0
        found.update(past=BEYOND - distance[touch], across=across[touch], bank=bank[touch])
        # the hardest of them, after a bounce too
        touches = np.flatnonzero((wheels[1:] > 0.0) & (wheels[:-1] == 0.0))
        found.update(sink=-climb[touches].min(), crab=crab, vc=vc[touch])
        found["bounce"] = height[touch:].max() - height[touch]
        slow = vc[touch:] < ROLLED
        rolled = across[touch:][: slow.argmax() if slow.any() else None]
        found["roll_out"] = rolled[np.abs(rolled).argmax()]
    return found


def outcome(name, found):
    """ "landed", "around", or what is wrong."""
    if found["error"]:
        return found["error"]
    if found["around"]:
        return "around" if found["end"] > found["begun"] + 50.0 else "does not climb away"
    if "sink" not in found:
        return "does not come down"
    limits = {"past": FLEET[name][7] if name in FLEET else PAST, **LIMITS}
    beyond = [key for key, most in limits.items() if not abs(found[key]) < most]
    return ", ".join(f"{key} {found[key]:.1f}" for key in beyond) or "landed"


def tables(results):
    """The tables of the page, from the cases and what was found by aircraft."""
    lines = []
    for key, label in ROWS.items():
        cells = [label]
        for rows in results.values():
            x = np.array([found[key] for _, found in rows if "sink" in found])
            low, middle, high = np.percentile(x, (5, 50, 95))
            cells.append(f"{middle:.1f} ({low:.1f} to {high:.1f}; {x[np.abs(x).argmax()]:.1f})")
        lines.append(cells)
    ends = {name: [outcome(name, found) for _, found in rows] for name, rows in results.items()}
    for label, kind in (("**landed within the limits**", "landed"), ("went around", "around")):
        lines.append([label] + [f"{end.count(kind)} of {len(end)}" for end in ends.values()])
    text = markdown(f"| median (5 % to 95 %; worst) of | {' | '.join(results)} |", lines)
    others = []
    for name, rows in results.items():
        for (case, found), end in zip(rows, ends[name], strict=True):
            if end == "around":
                end = f"went around at {found['begun']:.0f} ft, {found['across']:.0f} ft aside, "
                end += f"lowest {found['lowest']:.0f} ft"
            if end != "landed":
                wind = ", ".join(f"{case[key]:.0f}" for key in ("head", "cross", "gusts"))
                others.append(f"| {case['seed']:.0f} | {name} | {wind} | {end} |")
    if others:
        text += "\n\n| case | aircraft | head, cross, gusts [kt] | outcome |\n|--:|---|--:|---|\n"
    return text + "\n".join(others)


def crosswind():
    """The table of approaches in a crosswind."""
    lines = []
    for name in CROSSWIND:
        ends, speeds, touches = [], [], []
        for number in range(1, APPROACHES + 1):
            cross = CROSS if number % 2 else -CROSS
            course, built = approach(name, number, head=0.0, cross=cross, gusts=CROSS_GUSTS)
            found = landed("autoland_737", built, course)
            ends.append(outcome(name, found))
            speeds.append(built["aircraft.condition"].speed)
            touches += [found] if "sink" in found else []
            print(name, number, ends[-1], flush=True)
        cells = [name, *(f"{ends.count(end)} of {APPROACHES}" for end in ("landed", "around"))]
        cells.append(f"{min(speeds):.0f} to {max(speeds):.0f}")
        for key, digits in (("sink", 1), ("past", 0), ("across", 0), ("roll_out", 0)):
            x = [abs(found[key]) for found in touches]
            cells.append(f"{min(x):.{digits}f} to {max(x):.{digits}f}" if x else "")
        lines.append(cells)
    put(PAGE, "crosswind", markdown(CROSSWIND_HEAD, lines))


def main(cases=CASES, seed=0):
    results = {}
    for name in FLEET:
        results[name] = []
        for case in draw(name, cases, seed):
            found = land(name, case)
            results[name].append((case, found))
            print(name, int(case["seed"]), outcome(name, found), flush=True)
    if not seed:
        put(PAGE, "landings", tables(results))


if __name__ == "__main__":
    if sys.argv[1:] == ["crosswind"]:
        crosswind()
    else:
        main(*map(int, sys.argv[1:]))
