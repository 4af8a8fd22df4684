"""Search for the gains of one loop: margins by frequency response, steps with limits by time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .margins import Margins, margins
from .plant import Plant
from .requirements import (
    MARGINS,
    STEP_REQUIREMENTS,
    StepRequirement,
    relaxation_text,
    requirement_met,
)

OMEGA = np.geomspace(0.02, 300.0, 220)  # rad/s


@dataclass(frozen=True)
class Attitude:
    """A pitch or roll loop to be designed.

    Attributes
    ----------
    input, angle, rate : str
        names in the plant
    sign : float
        -1 where a positive command lowers the angle
    required : StepRequirement
    cap : float
        highest crossover, rad/s
    """

    input: str
    angle: str
    rate: str
    sign: float
    required: StepRequirement
    cap: float = 6.0


PITCH = Attitude("elevator", "theta", "q", -1.0, STEP_REQUIREMENTS["pitch"])
ROLL = Attitude("aileron", "phi", "p", 1.0, STEP_REQUIREMENTS["roll"])

_CROSSOVERS = np.array(
    [0.25, 0.35, 0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 1.8, 2.2, 2.6, 3.0, 3.5, 4.0, 5.0, 6.0]
)
_PHASES = np.radians([45.0, 52.0, 60.0, 68.0, 76.0, 85.0, 95.0, 110.0])
_RATIOS = np.array([0.07, 0.12, 0.18, 0.26, 0.36, 0.5, 0.7, 1.0])
_WEIGHTS = np.array([0.0, 0.2, 0.4, 0.6, 0.8, 1.0])

# candidates flown in time, and for how long
_FLOWN, _SECONDS = 80, 28.0

# s; faster than this is worth nothing
_FAST = 2.5


@dataclass(frozen=True)
class Found:
    """The best gains of an attitude loop."""

    Kp: float
    Ki: float
    Kr: float
    b: float
    margins: dict[str, float]
    settling: float
    overshoot: float
    use: float
    relaxed: str


def integral(omega: np.ndarray, T: float) -> np.ndarray:
    """Frequency response of the sampled law's integral."""
    return T / (np.exp(1j * omega * T) - 1.0)


def design_attitude(
    plant: Plant, loop: Attitude, ramp: float, room: tuple[float, float]
) -> Found | None:
    """Gains of a pitch or roll loop, or None if none is stable.

    Parameters
    ----------
    plant : Plant
    loop : Attitude
    ramp : float
        rate of the reference, deg/s
    room : tuple of float
        lowest and highest increment of the command
    """
    g = plant.response(OMEGA, loop.input)
    G, R = loop.sign * g[loop.angle], loop.sign * g[loop.rate]
    Kp, Ki, Kr = _shaped(G, R, plant.T, loop.cap)
    L = (Kp[:, None] + Ki[:, None] * integral(OMEGA, plant.T)) * G + Kr[:, None] * R
    found = margins(OMEGA, L)
    level = requirement_met(found)
    # no crossover above the cap: rate feedback alone may cross again
    level[found.crossover > 1.6 * loop.cap] = len(MARGINS)
    best: tuple[float, Found] | None = None
    flown = np.zeros(len(Kp), dtype=bool)
    for allowed in (0, 1, 2, 3, 4):
        chosen = np.flatnonzero((level <= allowed) & ~flown)
        if not len(chosen):
            continue
        chosen = _spread(chosen, found.crossover[chosen], found.Ms[chosen])
        flown[chosen] = True
        candidate = _fly(plant, loop, ramp, room, Kp[chosen], Ki[chosen], Kr[chosen])
        for score, i, b, data in candidate:
            k = chosen[i]
            # no faster than needed
            score += 1.5 * level[k] + 0.1 * found.crossover[k]
            if best is None or score < best[0]:
                relaxed = []
                if not data["settling"] <= loop.required.settling:
                    relaxed.append(f"settling {data['settling']:.1f} s")
                if data["overshoot"] > loop.required.overshoot:
                    relaxed.append(f"overshoot {data['overshoot'] / loop.required.size:.0%}")
                best = (
                    score,
                    Found(
                        float(Kp[k]),
                        float(Ki[k]),
                        float(Kr[k]),
                        float(b),
                        margins_of(found, k),
                        relaxed=relaxation_text(level[k], *relaxed),
                        **data,
                    ),
                )
        if best is not None and not best[1].relaxed:
            break
        if best is not None and allowed >= 2 and math.isfinite(best[1].settling):
            break
    return None if best is None else best[1]


def margins_of(m: Margins, k: int) -> dict[str, float]:
    """The margins of one loop."""
    return {
        name: float(getattr(m, name)[k])
        for name in ("crossover", "gain", "phase", "Ms", "Ms_delayed")
    }


def _shaped(
    G: np.ndarray, R: np.ndarray, T: float, cap: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Kp, Ki, Kr with a crossover, a phase margin and Ki / (Kp crossover) each."""
    w, pm, ratio = (
        x.ravel()
        for x in np.meshgrid(_CROSSOVERS[cap >= _CROSSOVERS], _PHASES, _RATIOS, indexing="ij")
    )

    def there(x: np.ndarray) -> np.ndarray:
        size = np.interp(np.log(w), np.log(OMEGA), np.log(np.abs(x)))
        phase = np.interp(np.log(w), np.log(OMEGA), np.unwrap(np.angle(x)))
        return np.exp(size + 1j * phase)

    angle, rate = there(G), there(R)
    main = angle * (1.0 + ratio * w * integral(w, T))
    target = -np.exp(1j * pm)
    # Kp main + Kr rate = target, in real and imaginary part
    det = main.real * rate.imag - main.imag * rate.real
    with np.errstate(divide="ignore", invalid="ignore"):
        Kp = (target.real * rate.imag - target.imag * rate.real) / det
        Kr = (main.real * target.imag - main.imag * target.real) / det
    # more phase than asked for without any rate feedback
    plain = 1.0 / np.abs(main)
    without = ~(Kr >= 0.0)
    Kp, Kr = np.where(without, plain, Kp), np.where(without, 0.0, Kr)
    good = np.isfinite(Kp) & (Kp > 0.0)
    Kp, Kr, Ki = Kp[good], Kr[good], (ratio * w * Kp)[good]
    _, once = np.unique(np.round(np.log([Kp, Ki, Kr + 1e-9]), 6), axis=1, return_index=True)
    return Kp[once], Ki[once], Kr[once]


def _spread(chosen: np.ndarray, crossover: np.ndarray, Ms: np.ndarray) -> np.ndarray:
    """At most `_FLOWN` candidates over all crossovers, the fast ones more densely."""
    if len(chosen) <= _FLOWN:
        return chosen
    order = np.argsort(crossover + 1e-3 * Ms)
    return chosen[order[np.unique((len(order) - 1) * np.linspace(0, 1, _FLOWN) ** 0.7).astype(int)]]


def _fly(
    plant: Plant,
    loop: Attitude,
    ramp: float,
    room: tuple[float, float],
    Kp: np.ndarray,
    Ki: np.ndarray,
    Kr: np.ndarray,
) -> list[tuple[float, int, float, dict[str, float]]]:
    """Steps of all candidates with all weights: score, number, weight and what was measured."""
    n = len(Kp)
    index, b = (x.ravel() for x in np.meshgrid(np.arange(n), _WEIGHTS, indexing="ij"))
    y, peak = attitude_steps(plant, loop, ramp, room, Kp[index], Ki[index], Kr[index], b, _SECONDS)
    error = y - loop.required.size
    settling = settled(error, loop.required.tolerance, plant.T)
    overshoot = np.maximum(error.max(axis=0), 0.0)
    late = at_the_end(error, plant.T)
    travel = np.minimum(-room[0], room[1])
    use = peak / travel
    score = (
        np.maximum(settling, _FAST)
        + 20.0 * np.maximum(overshoot - 0.5 * loop.required.overshoot, 0.0) / loop.required.size
        + 300.0 * np.maximum(overshoot - 0.7 * loop.required.overshoot, 0.0) / loop.required.size
        + 200.0 * late / loop.required.size
        + 20.0 * np.maximum(use - loop.required.use, 0.0)
        + 0.5 * use
    )
    order = [k for k in np.argsort(score) if np.isfinite(score[k])][:8]
    return [
        (
            float(score[k]),
            int(index[k]),
            float(b[k]),
            {
                "settling": float(settling[k]),
                "overshoot": float(overshoot[k]),
                "use": float(use[k]),
            },
        )
        for k in order
    ]


def settled(error: np.ndarray, tolerance: float, T: float) -> np.ndarray:
    """Time from which each column stays within the tolerance; infinite if it does not."""
    outside = ~(np.abs(error) <= tolerance)
    last = len(error) - np.argmax(outside[::-1], axis=0)
    time = np.where(outside.any(axis=0), last * T, 0.0)
    return np.where(last == len(error), np.where(outside.any(axis=0), np.inf, 0.0), time)


def at_the_end(error: np.ndarray, T: float) -> np.ndarray:
    """Largest size of each column in the last 5 s."""
    return np.abs(error[-round(5.0 / T) :]).max(axis=0)


def attitude_steps(
    plant: Plant,
    loop: Attitude,
    ramp: float,
    room: tuple[float, float],
    Kp: np.ndarray,
    Ki: np.ndarray,
    Kr: np.ndarray,
    b: np.ndarray,
    seconds: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Angles in a step of the reference, shape (samples, loops), and the largest commands."""
    T, n = plant.T, len(Kp)
    c, cr, B = plant.row(loop.angle), plant.row(loop.rate), plant.column(loop.input)[:, None]
    both = np.vstack([plant.A, c @ plant.A, cr @ plant.A])
    effect = np.vstack([B, c @ B, cr @ B])
    size = len(plant.A)
    x, y, rate = np.zeros((size, n)), np.zeros(n), np.zeros(n)
    total, peak = np.zeros(n), np.zeros(n)
    low, high = sorted(loop.sign * np.array(room))
    unwind = np.where(Ki > 0.0, np.minimum(T * Ki / np.maximum(Kp, 1e-12), 0.5), 0.0)
    steps = round(seconds / T)
    recorded = np.empty((steps, n))
    r = 0.0
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(steps):
            recorded[k] = y
            if k:
                r = min(r + ramp * T, loop.required.size)
            v = Kp * (b * r - y) + total - Kr * rate
            u = np.minimum(np.maximum(v, low), high)
            peak = np.maximum(peak, np.abs(v))
            total += Ki * T * (r - y) + unwind * (u - v)
            z = both @ x + effect * (loop.sign * u)
            x, y, rate = z[:size], z[size], z[size + 1]
    return recorded, peak


def closed(plant: Plant, loop: Attitude, found: Found, reference: str) -> Plant:
    """The plant with the loop closed; ``reference`` in place of the actuator."""
    T, s = plant.T, loop.sign
    return plant.close(
        loop.input,
        law=np.array([[1.0], [s * 1.0]]),
        read={reference: np.array([found.Ki * T]), loop.angle: np.array([-found.Ki * T])},
        through={
            reference: s * found.Kp * found.b,
            loop.angle: -s * found.Kp,
            loop.rate: -s * found.Kr,
        },
        reference=reference,
    )
