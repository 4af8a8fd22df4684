"""Search for the gains of one loop: margins by frequency response, steps with limits by time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..control.gains import AircraftGains, AttitudeGains
from ..control.loops import BEYOND
from ..linear.stability import LoopMargins, loop_margins
from .plant import OMEGA, Law, Plant, integral
from .requirements import (
    CHANGE_AIM,
    MARGINS,
    STEP_REQUIREMENTS,
    StepRequirement,
    requirement_met,
)

# gains of many loops, shape (gains, loops)
Gains = Sequence[np.ndarray] | np.ndarray


class Unstable(Exception):
    """No gains of a loop settle its step."""

    def __init__(self, loop: str, why: str):
        super().__init__(why)
        self.loop = loop


@dataclass(frozen=True)
class LoopReport:
    """Margins and step response of one loop.

    Attributes
    ----------
    loop : str
        "pitch", "roll", "yaw", "heading", "speed" or "altitude"
    crossover : float
        rad/s
    gain_margin, phase_margin : float
        dB, deg
    Ms, Ms_delayed : float
        maximum magnitude of the sensitivity 1 / (1 + L), without and with 50 ms of additional
        delay
    settling, overshoot : float
        of the step, in s and in the unit of the reference, predicted by the linear model; NaN for
        the rudder's loops
    use : float
        fraction of the command's remaining travel that the step uses
    flown_settling, flown_overshoot : float
        of the same step on the nonlinear aircraft; NaN if it was not flown
    relaxed : str
        requirements that the loop does not meet; empty if it meets all
    """

    loop: str
    crossover: float
    gain_margin: float
    phase_margin: float
    Ms: float
    Ms_delayed: float
    settling: float = math.nan
    overshoot: float = math.nan
    use: float = math.nan
    flown_settling: float = math.nan
    flown_overshoot: float = math.nan
    relaxed: str = ""


def margins_of(m: LoopMargins, k: int) -> dict[str, Any]:
    """The margins of one loop, by their names in its report."""
    names = ("crossover", "gain_margin", "phase_margin", "Ms", "Ms_delayed")
    return {name: float(x[k]) for name, x in zip(names, vars(m).values(), strict=True)}


def reported(
    loop: str,
    margins: LoopMargins,
    j: int,
    step: StepRequirement,
    settling: float,
    overshoot: float,
    use: float,
    more: Sequence[str] = (),
) -> LoopReport:
    """The report of loop ``j``; ``more`` are further requirements that it does not meet."""
    level = requirement_met(margins)[j]
    misses = [str(MARGINS[level])] if level else []
    if not math.isfinite(settling):
        misses.append("settling")
    elif settling > step.settling:
        misses.append(f"settling {settling:.1f} s")
    if overshoot > step.overshoot:
        misses.append(f"overshoot {overshoot:.2g} {step.unit}")
    return LoopReport(
        loop,
        **margins_of(margins, j),
        settling=float(settling),
        overshoot=float(overshoot),
        use=float(use),
        relaxed="; ".join([*misses, *more]),
    )


# cost of a factor of e beyond the aim; fraction of the maximum candidate that a smaller gain counts
# as, so that the ratio of two negligible gains costs nothing
_PRICE, _LEAST = 0.5, 0.05


class Neighbours:
    """Gains at the neighbouring conditions, which the search of the gains at one starts from."""

    def __init__(self, gains: Sequence[AircraftGains] = ()):
        self.gains = tuple(gains)

    def joined(self, loop: str, **candidates: np.ndarray) -> tuple[np.ndarray, ...]:
        """The candidates of a loop's gains, then the neighbours' gains, lower and higher too."""
        scale = CHANGE_AIM ** np.linspace(-1.0, 1.0, 5)
        return tuple(
            np.concatenate(
                [x, *(getattr(getattr(gains, loop), name) * scale for gains in self.gains)]
            )
            for name, x in candidates.items()
        )

    def cost(self, loop: str, **candidates: np.ndarray) -> np.ndarray:
        """Cost of gains that differ from the neighbours', as a fraction of a quick step's time."""
        total = np.zeros(len(next(iter(candidates.values()))))
        for gains in self.gains:
            for name, x in candidates.items():
                neighbour = abs(getattr(getattr(gains, loop), name))
                minimum = max(_LEAST * max(np.abs(x).max(), neighbour), 1e-12)
                factor = np.maximum(np.abs(x), minimum) / max(neighbour, minimum)
                total += np.maximum(np.abs(np.log(factor)) - math.log(CHANGE_AIM), 0.0)
        return _PRICE * total


ALONE = Neighbours()


@dataclass(frozen=True)
class Loop:
    """A loop that holds an output at a reference; names are the plant's."""

    name: str
    input: str
    output: str
    rate: str
    required: StepRequirement
    sign: float = 1.0  # -1 if a positive command lowers the output

    def law(self, Kp: Any, Ki: Any, Kr: Any) -> Law:
        """The law's feedback: proportional, integral, and of the rate."""
        s = self.sign
        return Law({self.output: (s * Kp, s * Ki), self.rate: (s * Kr,)})


PITCH = Loop("pitch", "elevator", "theta", "q", STEP_REQUIREMENTS["pitch"], -1.0)
ROLL = Loop("roll", "aileron", "phi", "p", STEP_REQUIREMENTS["roll"])

# crossovers in rad/s, phase margins in deg, Ki / (Kp crossover), b
_CROSSOVERS = np.geomspace(0.25, 6.0, 16)
_PHASES = np.linspace(45.0, 110.0, 8)
_RATIOS = np.geomspace(0.07, 1.0, 8)
_WEIGHTS = np.linspace(0.0, 1.0, 6)

# number of candidates whose step is computed, and its duration, s
_FLOWN, _SECONDS = 80, 28.0

# index of the margins from which any loop that settles is accepted
_ENOUGH = 2


def grid(*values: np.ndarray) -> tuple[np.ndarray, ...]:
    """All combinations of some values, arrays of shape (combinations,)."""
    return tuple(x.ravel() for x in np.meshgrid(*values, indexing="ij"))


def at(omega: np.ndarray, response: np.ndarray) -> np.ndarray:
    """A frequency response at other frequencies."""
    size = np.interp(np.log(omega), np.log(OMEGA), np.log(np.abs(response)))
    phase = np.interp(np.log(omega), np.log(OMEGA), np.unwrap(np.angle(response)))
    return np.exp(size + 1j * phase)


def crossing(x: np.ndarray, y: np.ndarray, phase: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gains a, b for which a x + b y has size 1 and a phase margin in deg.

    If b would be negative, it is 0 and the phase margin differs; a may be negative.
    """
    target = -np.exp(1j * np.radians(phase))
    det = x.real * y.imag - x.imag * y.real
    with np.errstate(divide="ignore", invalid="ignore"):
        a = (target.real * y.imag - target.imag * y.real) / det
        b = (x.real * target.imag - x.imag * target.real) / det
    negative = ~(b >= 0.0)
    return np.where(negative, 1.0 / np.abs(x), a), np.where(negative, 0.0, b)


def design_attitude(
    plant: Plant,
    loop: Loop,
    ramp: float,
    room: tuple[float, float],
    neighbours: Neighbours = ALONE,
) -> tuple[AttitudeGains, LoopReport]:
    """Gains of a pitch or roll loop, and its report.

    ``ramp`` is the rate of the reference in deg/s, ``room`` the minimum and maximum increment of
    the command.
    """
    g, requirement = plant.response(OMEGA, loop.input), loop.required
    shapes = _shaped(loop.sign * g[loop.output], loop.sign * g[loop.rate], plant.T)
    gains = np.array(neighbours.joined(loop.name, Kp=shapes[0], Ki=shapes[1], Kr=shapes[2]))
    margins = loop_margins(OMEGA, loop.law(*gains[:, :, None]).of(g, plant.T))
    level = requirement_met(margins)
    # rate feedback alone may cross again above the maximum crossover
    level[margins.crossover > 1.6 * _CROSSOVERS[-1]] = len(MARGINS)
    # among equal loops prefer the slower one, which is less sensitive to delay
    cost = 1.5 * level + 0.1 * margins.crossover
    cost += requirement.quick * neighbours.cost(loop.name, Kp=gains[0], Ki=gains[1], Kr=gains[2])
    best, minimum, flown = None, math.inf, np.zeros(len(level), dtype=bool)
    for row in range(len(MARGINS)):
        pick = np.flatnonzero((level <= row) & ~flown)
        if not len(pick):
            continue
        is_neighbour = pick >= len(shapes[0])
        pick = np.concatenate([_spread(pick[~is_neighbour], margins), pick[is_neighbour]])
        flown[pick] = True
        k, b = grid(pick, _WEIGHTS)
        score, settling, over, use = _scored(plant, loop, ramp, room, gains[:, k], b)
        i = int(np.argmin(score + cost[k]))
        j = k[i]
        if score[i] + cost[j] < minimum:
            minimum = score[i] + cost[j]
            best = (
                AttitudeGains(*(float(x) for x in (*gains[:, j], b[i], ramp))),
                reported(loop.name, margins, j, requirement, settling[i], over[i], use[i]),
            )
        if best and (not best[1].relaxed or row >= _ENOUGH):
            break
    if best is None:
        raise Unstable(loop.name, f"no gains of the {loop.input} settle a step in {loop.name}")
    return best


def _shaped(G: np.ndarray, R: np.ndarray, T: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kp, Ki, Kr for all combinations of crossover, phase margin and Ki / (Kp crossover)."""
    w, phase, ratio = grid(_CROSSOVERS, _PHASES, _RATIOS)
    Kp, Kr = crossing(at(w, G) * (1.0 + ratio * w * integral(w, T)), at(w, R), phase)
    good = np.isfinite(Kp) & (Kp > 0.0)
    Kp, Kr, Ki = Kp[good], Kr[good], (ratio * w * Kp)[good]
    _, once = np.unique(np.round(np.log([Kp, Ki, Kr + 1e-9]), 6), axis=1, return_index=True)
    return Kp[once], Ki[once], Kr[once]


def _spread(pick: np.ndarray, m: LoopMargins) -> np.ndarray:
    """At most `_FLOWN` candidates over all crossovers, more of the fast ones."""
    if len(pick) <= _FLOWN:
        return pick
    order = pick[np.argsort(m.crossover[pick] + 1e-3 * m.Ms[pick])]
    return order[np.unique((len(order) - 1) * np.linspace(0, 1, _FLOWN) ** 0.7).astype(int)]


def _scored(
    plant: Plant,
    loop: Loop,
    ramp: float,
    room: tuple[float, float],
    gains: Gains,
    b: np.ndarray,
) -> tuple[np.ndarray, ...]:
    """Score, settling time, overshoot and used fraction of the travel in reference steps."""
    requirement = loop.required
    error, peak = tracked(plant, loop, requirement.size, _SECONDS, ramp, room, gains, b)
    settling, over, late = step_quality(error, requirement.tolerance, plant.T)
    use = peak / min(-room[0], room[1])
    score = (
        np.maximum(settling, requirement.quick)
        + 20.0 * np.maximum(over - 0.5 * requirement.overshoot, 0.0) / requirement.size
        + 300.0 * np.maximum(over - 0.7 * requirement.overshoot, 0.0) / requirement.size
        + 200.0 * late / requirement.size
        + 20.0 * np.maximum(use - requirement.use, 0.0)
        + 0.5 * use
    )
    return np.where(np.isfinite(score), score, math.inf), settling, over, use


def settled(error: np.ndarray, tolerance: float, T: float) -> np.ndarray:
    """Time from which each column stays within the tolerance; infinite if it does not."""
    misses = ~(np.abs(error) <= tolerance)
    last = np.where(misses.any(axis=0), len(error) - np.argmax(misses[::-1], axis=0), 0)
    return np.where(last == len(error), np.inf, last * T)


class StepQuality(NamedTuple):
    """Quality of steps, one value for each; ``step_info`` of python-control has the same terms."""

    settling: Any  # s until the error stays within the tolerance; infinite if it does not
    overshoot: Any  # maximum excess over the reference, unit of the output
    steady_error: Any  # maximum distance from the reference in the last 5 s


def step_quality(error: np.ndarray, tolerance: float, T: float) -> StepQuality:
    """Quality of steps from their errors, which are negative before the reference is reached."""
    late = np.abs(error[-round(5.0 / T) :]).max(axis=0)
    return StepQuality(settled(error, tolerance, T), np.maximum(error.max(axis=0), 0.0), late)


def tracked(
    plant: Plant,
    loop: Loop,
    size: float,
    seconds: float,
    ramp: Any,
    room: tuple[float, float],
    gains: Gains,
    b: np.ndarray,
    Tf: float = 0.0,
    band: float = math.inf,
) -> tuple[np.ndarray, np.ndarray]:
    """Errors in a step of the reference, shape (samples, loops), and the maximum commands.

    Errors are below 0 before the step is reached. The ``gains`` are Kp, which acts on the output
    behind a lag of ``Tf`` s, Ki and Kr; only a fraction of an error beyond the ``band`` counts, as
    in `SpeedLoop`.
    """
    Kp, Ki, Kr = gains
    T, sign = plant.T, math.copysign(1.0, size)
    total, slow, peak = np.zeros((3, len(Kp)))
    low, high = sorted(loop.sign * np.array(room))
    unwind = np.minimum(T * Ki / np.maximum(Kp, 1e-12), 0.5)
    gain = -math.expm1(-T / Tf) if Tf else 1.0

    def law(k: int, y: np.ndarray) -> np.ndarray:
        r = sign * np.minimum(k * T * ramp, abs(size))
        error = r - y[0]
        if math.isfinite(band):
            error -= BEYOND * (error - np.minimum(np.maximum(error, -band), band))
        slow[:] += gain * (r - error - slow)
        v = Kp * (b * r - slow) + total - Kr * y[1]
        u = np.minimum(np.maximum(v, low), high)
        np.maximum(peak, np.abs(v), out=peak)
        total[:] += Ki * T * error + unwind * (u - v)
        return loop.sign * u

    y = plant.steps(loop.input, (loop.output, loop.rate), law, len(Kp), seconds)
    return sign * (y[:, 0] - size), peak


def closed(plant: Plant, loop: Loop, gains: AttitudeGains, reference: str) -> Plant:
    """The plant with the loop closed and the input ``reference`` in place of the actuator."""
    s, law = loop.sign, loop.law(gains.Kp, gains.Ki, gains.Kr)
    return plant.close(loop.input, law, (reference, s * gains.Kp * gains.b, s * gains.Ki))
