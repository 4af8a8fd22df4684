"""Gauss-Newton search within limits for the zero of the residuals of steady flight."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .equations import SteadyFlight, size

# fraction of the tolerances at which the search ends
POLISHED = 1e-5

# stop if the step would leave more than this fraction of the residuals; with a quantity at its
# limit, where most failures end, the requirement is stricter
_MAX_LEFT = 0.98
_MAX_LEFT_AT_LIMIT = 0.9

# 10 are too few for the X15 at Mach 3
_ITERATIONS = 30

# strides; a search that comes this close to the end of an earlier one would repeat it, and stops
_ON_THE_WAY = 0.02

# maximum relative difference of the residuals of two ends at one limit that count as the same
_SAME_END = 0.5

# fractions of a step that are tried until the residuals decrease; whole steps alone do not
# bring the X15 to its glide at Mach 3
_SHARES = (1.0, 0.4, 0.16, 0.06, 0.02)


class Reached(NamedTuple):
    """The end of a search."""

    x: np.ndarray
    residuals: np.ndarray  # in tolerances
    slopes: np.ndarray | None  # of the residuals by x

    @property
    def size(self) -> float:
        """The maximum residual, in tolerances."""
        return size(self.residuals)


def descend(
    flight: SteadyFlight,
    x: np.ndarray,
    slopes: np.ndarray | None = None,
    ends: Sequence[Reached] = (),
) -> Reached:
    """Search from ``x`` to its end; stop near one of the ``ends`` of earlier searches.

    Also stop at the same limit as one of them instead of renewing slopes that show no way on.
    """
    x = np.minimum(np.maximum(x, flight.low), flight.high)
    r = flight.settled(x)
    norm = _norm(r)
    for _ in range(_ITERATIONS):
        if size(r) <= POLISHED or not math.isfinite(norm) or flight.effort.over:
            break
        if any((abs(x - end.x) <= _ON_THE_WAY * flight.strides).all() for end in ends):
            break
        fresh = slopes is None
        if slopes is None:
            slopes = flight.slopes(x, r)
            if not np.all(np.isfinite(slopes)):
                slopes = None
                break
        full = _step(flight, x, r, slopes)
        hopeless = _is_hopeless(flight, x + full, _norm(r + slopes @ full) / norm)
        better = None if hopeless else _shortened(flight, x, full, norm, fresh)
        if better is None:
            if fresh or any(at_one_limit(flight, end, Reached(x, r, slopes)) for end in ends):
                break
            slopes = None
            continue
        y, ry, shorter = better
        if shorter < 0.5 * norm:
            # Broyden's update in the scaled unknowns
            move = (y - x) / flight.strides
            gap = ry - r - slopes @ (y - x)
            slopes = slopes + gap[:, None] * (move / flight.strides / (move @ move))
        else:
            slopes = None
        x, r, norm = y, ry, shorter
    return Reached(x, r, slopes)


def _is_hopeless(flight: SteadyFlight, to: np.ndarray, residual: float) -> bool:
    """Whether a step would leave too large a fraction of the residuals."""
    if residual <= _MAX_LEFT_AT_LIMIT:
        return False
    return residual > _MAX_LEFT or bool(((to <= flight.low) | (to >= flight.high)).any())


def _shortened(
    flight: SteadyFlight, x: np.ndarray, full: np.ndarray, norm: float, fresh: bool
) -> tuple[np.ndarray, np.ndarray, float] | None:
    """The first fraction of a step that reduces the residuals; old slopes get one trial."""
    for share in _SHARES if fresh else _SHARES[:1]:
        y = np.minimum(np.maximum(x + share * full, flight.low), flight.high)
        r = flight.trial(y)
        shorter = _norm(r)
        if shorter < norm * (1.0 - 1e-3 * share):
            return y, r, shorter
    return None


def at_one_limit(flight: SteadyFlight, one: Reached, two: Reached) -> bool:
    """Whether two searches have ended at the same limit, with similar residuals."""
    low = (one.x <= flight.low) & (two.x <= flight.low)
    high = (one.x >= flight.high) & (two.x >= flight.high)
    gap = np.linalg.norm(one.residuals - two.residuals)
    return bool((low | high).any() and gap < _SAME_END * np.linalg.norm(one.residuals))


def _norm(r: np.ndarray) -> float:
    norm = math.sqrt(r @ r)
    return norm if math.isfinite(norm) else math.inf


def _step(flight: SteadyFlight, x: np.ndarray, r: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    """The step of Newton, or the best one within limits and strides."""
    strides = flight.strides
    matrix = slopes * strides
    # at a limit the interval would be empty
    low = np.minimum(np.maximum((flight.low - x) / strides, -1.0), -1e-12)
    high = np.maximum(np.minimum((flight.high - x) / strides, 1.0), 1e-12)
    return bounded(matrix, -r, low, high, solution(matrix, -r)) * strides


def bounded(
    a: np.ndarray, b: np.ndarray, low: np.ndarray, high: np.ndarray, best: np.ndarray
) -> np.ndarray:
    """Least squares of a x - b within limits, low < high; ``best`` is the optimum without them."""
    # the active set method of Stark and Parker (1995), started with the limits that the optimum
    # without limits exceeds; scipy's lsq_linear is slower, also to import
    at_bound = (best < low) | (best > high)
    if not any(at_bound.tolist()):
        return best
    x = np.minimum(np.maximum(best, low), high)
    square, aim, unit = a.T @ a, a.T @ b, np.eye(len(best))
    limits = list(zip(low.tolist(), high.tolist(), strict=True))
    for _ in range(4 * len(x)):
        x_bound = np.where(at_bound, x, 0.0)
        aims = np.where(at_bound, x_bound, aim - square @ x_bound)
        y = solution(np.where(at_bound[:, None] | at_bound, unit, square), aims)
        # fractions of the step to each limit
        ways = [
            1.0 if least <= to <= most else ((least if to < least else most) - at) / (to - at)
            for at, to, (least, most) in zip(x.tolist(), y.tolist(), limits, strict=True)
        ]
        way = min(ways)
        if way < 1.0:
            i = ways.index(way)
            x = x + max(way, 0.0) * (y - x)
            x[i] = low[i] if y[i] < low[i] else high[i]
            at_bound[i] = True
            continue
        x = y
        # Lagrange multipliers of the active limits; a negative one means that it can be released
        uphill = square @ x - aim
        back = np.where(at_bound, np.where(x <= low, uphill, -uphill), 0.0)
        i = int(back.argmin())
        if back[i] >= -1e-10 * (1.0 + abs(uphill).max()):
            break
        at_bound[i] = False
    return x


def solution(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The solution of a x = b, of minimum norm if there are many; NaN if numbers overflow."""
    try:
        return np.linalg.solve(a, b)
    except np.linalg.LinAlgError:
        # lstsq would never return for infinities
        if np.isfinite(a).all() and np.isfinite(b).all():
            return np.linalg.lstsq(a, b, rcond=None)[0]
        return np.full(len(b), math.nan)
