"""Requirements of the loops: one table for the search, the flights and the documentation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..linear.stability import LoopMargins


class MarginRequirement(NamedTuple):
    """Minimum margins of a loop, and its maximum sensitivity."""

    Ms: float
    Ms_delayed: float  # with 50 ms of additional delay
    gain: float  # dB
    phase: float  # deg

    def __str__(self) -> str:
        return f"Ms {self.Ms:g}, {self.gain:g} dB, {self.phase:g} deg"


# the first row is the target; the rest are successive fallbacks
MARGINS = (
    MarginRequirement(1.4, 1.8, 7.0, 45.0),
    MarginRequirement(1.5, 2.0, 6.5, 42.0),
    MarginRequirement(1.8, 2.3, 6.0, 35.0),
    MarginRequirement(2.2, 2.7, 5.0, 28.0),
    MarginRequirement(3.0, 3.6, 3.5, 20.0),
)


def requirement_met(m: LoopMargins) -> np.ndarray:
    """Index of the first row of `MARGINS` that each loop meets, or the number of rows."""
    passes = [
        (m.Ms <= r.Ms) & (m.Ms_delayed <= r.Ms_delayed) & (m.gain >= r.gain) & (m.phase >= r.phase)
        for r in MARGINS
    ]
    return np.argmax([*passes, np.ones(len(m.Ms), dtype=bool)], axis=0)


@dataclass(frozen=True)
class StepRequirement:
    """A step of a loop's reference and its requirements, in the unit of the output."""

    size: float
    tolerance: float  # error that counts as settled
    unit: str
    seconds: float  # duration of the flight after the step, s
    settling: float = math.inf  # maximum at the design point, s
    settling_off: float = math.inf  # maximum off the design point, s
    quick: float = 0.0  # settling time below which there is no credit, s
    overshoot: float = math.inf
    final_error: float = math.inf  # maximum in the last 5 s
    use: float = math.inf  # maximum fraction of the command's remaining travel


STEP_REQUIREMENTS = {
    "pitch": StepRequirement(5.0, 0.5, "deg", 30.0, 4.0, 6.0, 2.5, 0.25, 0.05, 0.8),
    "roll": StepRequirement(20.0, 1.0, "deg", 30.0, 5.0, 7.5, 2.5, 1.0, 0.05, 0.9),
    "heading": StepRequirement(30.0, 0.5, "deg", 120.0, overshoot=0.5, final_error=0.05),
    "altitude": StepRequirement(500.0, 10.0, "ft", 120.0, overshoot=5.0, final_error=0.1),
    "speed": StepRequirement(
        10.0, 0.5, "kt", 150.0, settling_off=75.0, quick=12.0, final_error=0.15, use=1.0
    ),
}

# maximum altitude error in an airspeed step, at the design point and off it, ft
ALTITUDE_KEPT, ALTITUDE_KEPT_OFF = 15.0, 22.5

# off the design point: sideslip in a turn, deg, and time of a command at the end of its travel, s
MAX_SIDESLIP, MAX_SECONDS_AT_A_STOP = 1.0, 1.0

# moderate turbulence: altitude error, ft; rms of the pitch angle, deg; fraction of the time with
# the throttle at a stop. The search aims at fractions of the latter two, as single flights scatter
ALTITUDE_IN_TURBULENCE, PITCH_IN_TURBULENCE, STOP_IN_TURBULENCE = 60.0, 5.0, 0.05
PITCH_AIM, STOP_AIM = 0.75, 0.2

# rms of the throttle in moderate turbulence, as a fraction of the smaller distance to a stop; and
# throttle per airspeed, 1/kt: in gusts beyond the limits of `ComplementaryAirspeed` the throttle
# follows the measured airspeed, and travels by 1.5 times this each second
THROTTLE_IN_TURBULENCE, THROTTLE_PER_KNOT = 1.0 / 3.0, 0.032

# load factor increment of a moving pitch reference, g, and the limits of its rate, deg/s
RAMP_LOAD, RAMP_LOW, RAMP_HIGH = 0.7, 2.0, 6.0

# maximum pitch reference, and its minimum above the pitch angle of level flight, deg
THETA_MAX, NOSE_UP = 15.0, 6.0

# rate of the roll reference, its minimum at a high angle of attack, and the maximum rate of the
# sideslip into which a roll about the body axis turns the angle of attack, deg/s
ROLL_RAMP, ROLL_SLOW, ROLL_SLIP = 10.0, 5.0, 1.2

# bank of a turn, deg
BANK = 25.0

# maximum commanded rate of climb: ft/s, and as a fraction of the excess climb
CLIMB, CLIMB_OF_EXCESS = 25.0, 0.8

# airspeed error beyond which an excess counts less, kt
GUST = 12.0

# airspeed loop: minimum and maximum crossover, and that without a model of turbulence, rad/s;
# Kp / Ki, s; minimum rate of its reference, kt/s; time in which the reference changes by the
# airspeed if that is faster, s
SPEED_CROSSOVERS, SPEED_CROSSOVER = (0.09, 0.3), 0.12
SPEED_TIME, SPEED_RAMP, SPEED_RAMP_TIME = 25.0, 1.0, 225.0

# fraction of the maximum lift at which the angle of attack is limited, and the maximum limit, deg;
# minimum airspeed over that of level flight at this angle
LIFT, ALPHA, ABOVE_STALL = 0.92, 20.0, 1.1

# damping ratio of the Dutch roll; divergence rate that is left to the outer loops, 1/s
DUTCH_ROLL, DIVERGENCE = 0.35, 0.03

# maximum fraction of the rudder's remaining travel, for a yaw rate in deg/s and a sideslip in deg,
# and in the entry of a turn
RUDDER_USE, YAW_RATE, SIDESLIP, TURN_USE = 0.9, 10.0, 5.0, 0.6

# maximum fraction of the throttle's remaining travel held after a step up in airspeed
THROTTLE_USE = 0.7

# rate of climb whose feed-forward uses all of the throttle's remaining travel, ft/s: the first, or
# the second times the excess climb if that is less, but at least the third. With an excess climb
# below the last, the altitude loop is designed for a descent
RISE, RISE_OF_EXCESS, LEAST_RISE, NO_CLIMB = 40.0, 2.0, 25.0, 2.0

# maximum factor between the gains at neighbouring conditions, unless the aircraft changes by more,
# and the factor that the search aims at
CHANGE, CHANGE_AIM = 1.5, 1.4
