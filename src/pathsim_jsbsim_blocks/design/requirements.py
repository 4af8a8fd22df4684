"""What the loops are held to: one table, for the search, the flights and the documentation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..linear.stability import LoopMargins


class MarginRequirement(NamedTuple):
    """What the margins of a loop must be at least, and its sensitivity at most."""

    Ms: float
    Ms_delayed: float  # with 50 ms of delay more
    gain: float  # dB
    phase: float  # deg

    def __str__(self) -> str:
        return f"Ms {self.Ms:g}, {self.gain:g} dB, {self.phase:g} deg"


# the first is what is asked for; the others are what is taken where it cannot be had
MARGINS = (
    MarginRequirement(1.4, 1.8, 7.0, 45.0),
    MarginRequirement(1.5, 2.0, 6.5, 42.0),
    MarginRequirement(1.8, 2.3, 6.0, 35.0),
    MarginRequirement(2.2, 2.7, 5.0, 28.0),
    MarginRequirement(3.0, 3.6, 3.5, 20.0),
)


def requirement_met(m: LoopMargins) -> np.ndarray:
    """Number of the first of `MARGINS` that each loop meets; their count where it meets none."""
    met = [
        (m.Ms <= r.Ms) & (m.Ms_delayed <= r.Ms_delayed) & (m.gain >= r.gain) & (m.phase >= r.phase)
        for r in MARGINS
    ]
    return np.argmax([*met, np.ones(len(m.Ms), dtype=bool)], axis=0)


@dataclass(frozen=True)
class StepRequirement:
    """A step of a loop's reference, and what it is held to; lengths are in the output's unit."""

    size: float
    tolerance: float  # settled is what stays within it
    unit: str
    seconds: float  # of flight after the step
    settling: float = math.inf  # s, at the design point
    settling_off: float = math.inf  # and off it
    quick: float = 0.0  # s; no credit below this
    overshoot: float = math.inf
    final_error: float = math.inf  # largest in the last 5 s
    use: float = math.inf  # largest share of the command's remaining travel


STEP_REQUIREMENTS = {
    "pitch": StepRequirement(5.0, 0.5, "deg", 30.0, 4.0, 6.0, 2.5, 0.25, 0.05, 0.8),
    "roll": StepRequirement(20.0, 1.0, "deg", 30.0, 5.0, 7.5, 2.5, 1.0, 0.05, 0.9),
    "heading": StepRequirement(30.0, 0.5, "deg", 120.0, overshoot=0.5, final_error=0.05),
    "altitude": StepRequirement(500.0, 10.0, "ft", 120.0, overshoot=5.0, final_error=0.1),
    "speed": StepRequirement(
        10.0, 0.5, "kt", 150.0, settling_off=75.0, quick=12.0, final_error=0.15, use=1.0
    ),
}

# ft of altitude kept in a step of the airspeed, at the design point and off it
ALTITUDE_KEPT, ALTITUDE_KEPT_OFF = 15.0, 22.5

# off the design point: deg of sideslip in a turn, s at the end of a command's travel
MAX_SIDESLIP, MAX_SECONDS_AT_A_STOP = 1.0, 1.0

# moderate turbulence: ft, deg of rms, share of the time with the throttle at a stop; shares of the
# latter two that are aimed at, because single flights scatter
ALTITUDE_IN_TURBULENCE, PITCH_IN_TURBULENCE, STOP_IN_TURBULENCE = 60.0, 5.0, 0.05
PITCH_AIM, STOP_AIM = 0.75, 0.2

# g, deg/s: load of a pitch reference that moves, and the limits of its rate
RAMP_LOAD, RAMP_LOW, RAMP_HIGH = 0.7, 2.0, 6.0

# deg: highest pitch reference, and what it is at least above that of level flight
THETA_MAX, NOSE_UP = 15.0, 6.0

# deg/s: rate of the roll reference, and the limits of it where the nose is high: a roll about the
# body's axis turns the angle of attack into sideslip, by so many deg/s
ROLL_RAMP, ROLL_SLOW, ROLL_SLIP = 10.0, 5.0, 1.2

# deg: bank of a turn
BANK = 25.0

# largest rate of climb that is demanded: ft/s, of the excess climb
CLIMB, CLIMB_OF_EXCESS = 25.0, 0.8

# kt: an airspeed error that may use all of the throttle that is left; what is beyond is a gust, and
# counts less
GUST = 12.0

# rad/s: lowest and highest crossover of the airspeed loop; s: its Kp / Ki; kt/s: least rate of its
# reference; s in which the reference moves by the airspeed, where that is faster
SPEED_CROSSOVERS, SPEED_TIME, SPEED_RAMP, SPEED_RAMP_TIME = (0.15, 0.2), 30.0, 1.0, 225.0

# share of the largest lift at which the angle of attack is limited, and the highest limit, deg;
# lowest airspeed over that of level flight at this angle
LIFT, ALPHA, ABOVE_STALL = 0.92, 20.0, 1.1

# damping ratio of the Dutch roll; divergence that is left to the loops around, 1/s
DUTCH_ROLL, DIVERGENCE = 0.35, 0.03

# largest share of the rudder's remaining travel: for so many deg/s of yaw and deg of sideslip, and
# in the entry of a turn
RUDDER_USE, YAW_RATE, SIDESLIP, TURN_USE = 0.9, 10.0, 5.0, 0.6

# largest share of the throttle's remaining travel that a step up in airspeed may hold
THROTTLE_USE = 0.7

# ft/s: rate of climb whose feed-forward uses all of the throttle's remaining travel: the first, or
# so many times the excess climb where that is less, but no less than the third; an excess climb
# below the last is none: the altitude is designed for a descent
RISE, RISE_OF_EXCESS, LEAST_RISE, NO_CLIMB = 40.0, 2.0, 25.0, 2.0

# largest factor between a gain at neighbouring conditions, unless the aircraft changes by more, and
# what the search aims at
CHANGE, CHANGE_AIM = 1.5, 1.4


_FURTHER = f"""

| further | at the design point | off it |
|---|--:|--:|
| altitude kept in a step of the airspeed | {ALTITUDE_KEPT:g} ft | {ALTITUDE_KEPT_OFF:g} ft |
| sideslip in the turn | | {MAX_SIDESLIP:g} deg |
| a command at its stop | | {MAX_SECONDS_AT_A_STOP:g} s |
| altitude in moderate turbulence, largest error | {ALTITUDE_IN_TURBULENCE:g} ft | |
| pitch angle in moderate turbulence | {PITCH_IN_TURBULENCE:g} deg rms | |
| throttle at a stop in moderate turbulence | {STOP_IN_TURBULENCE:.0%} of the time | |
| damping ratio of the Dutch roll | {DUTCH_ROLL:g} | |
| divergence that is left to the loops around | {DIVERGENCE:g} 1/s | |
| rudder for {YAW_RATE:g} deg/s of yaw and {SIDESLIP:g} deg of sideslip, of what is left \
| {RUDDER_USE:g} | |
| rudder in the entry of a turn, of what is left | {TURN_USE:g} | |
| factor between the gains of neighbouring conditions, and what the search aims at \
| {CHANGE:g}, {CHANGE_AIM:g} | |

| demanded at most | |
|---|--:|
| load of a pitch reference that moves | {RAMP_LOAD:g} g |
| its rate | {RAMP_LOW:g} to {RAMP_HIGH:g} deg/s |
| pitch reference | {THETA_MAX:g} deg, {NOSE_UP:g} deg above level flight |
| rate of the roll reference | {ROLL_RAMP:g} deg/s |
| sideslip by a roll, p sin &alpha;, but no slower than {ROLL_SLOW:g} deg/s | {ROLL_SLIP:g} deg/s |
| bank of a turn | {BANK:g} deg |
| rate of climb | {CLIMB:g} ft/s, {CLIMB_OF_EXCESS:.0%} of the excess |
| rate of climb that is fed all of the throttle | {RISE:g} ft/s, \
or {RISE_OF_EXCESS:g} times the excess where less, but no less than {LEAST_RISE:g} ft/s |
| step up of the airspeed in the design, of the throttle that is left | {THROTTLE_USE:g} |
| error of the airspeed that uses the throttle that is left, and counts in full | {GUST:g} kt |
| crossover of the airspeed loop, and its Kp / Ki \
| {SPEED_CROSSOVERS[0]:g} to {SPEED_CROSSOVERS[1]:g} rad/s, {SPEED_TIME:g} s |
| rate of its reference | {SPEED_RAMP:g} kt/s, or the airspeed in {SPEED_RAMP_TIME:g} s |
| angle of attack | {ALPHA:g} deg, {LIFT:.0%} of the largest lift |"""


def requirements_table() -> str:
    """The requirements as tables in Markdown, for the documentation."""

    def limit(value: float, unit: str) -> str:
        return "" if math.isinf(value) else f"{value:g} {unit}".rstrip()

    rows = ["| margins | Ms | with 50 ms more | gain | phase |", "|---|--:|--:|--:|--:|"]
    for i, m in enumerate(MARGINS):
        name = f"relaxed, {i}" if i else "asked for"
        rows.append(f"| {name} | {m.Ms:g} | {m.Ms_delayed:g} | {m.gain:g} dB | {m.phase:g} deg |")
    rows += [
        "",
        "| step | settles to | within | off the design point | overshoot | error at the end "
        "| share of the travel |",
        "|---|--:|--:|--:|--:|--:|--:|",
    ]
    for loop, r in STEP_REQUIREMENTS.items():
        cells = (
            f"{loop}, {r.size:g} {r.unit}",
            f"{r.tolerance:g} {r.unit}",
            limit(r.settling, "s"),
            limit(r.settling_off, "s"),
            limit(r.overshoot, r.unit),
            limit(r.final_error, r.unit),
            limit(r.use, ""),
        )
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows) + _FURTHER
