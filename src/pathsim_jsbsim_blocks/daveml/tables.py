"""Tables of several variables: each axis gives the weights of its breakpoints."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

_ORDERS = {"quadraticSpline": 2, "cubicSpline": 3}
METHODS = ("linear", "discrete", "floor", "ceiling", *_ORDERS)


@dataclass
class Axis:
    """Breakpoints of one variable, and how to interpolate between them.

    ``discrete`` takes the nearest breakpoint, the upper one in the middle; ``floor`` the one at or
    below the variable, ``ceiling`` the one at or above. Beyond its ends the table is held, unless
    ``below`` or ``above`` continue it there; ``low`` and ``high`` limit the variable.
    """

    points: Sequence[float]
    method: str = "linear"
    below: bool = False
    above: bool = False
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        points, n = self.points, len(self.points)
        self._least, self._most = self._held(self.low), self._held(self.high)
        self._middles = [(a + b) / 2 for a, b in itertools.pairwise(points)]
        self._spline: Any = None
        if n > 1 and self.method in _ORDERS:
            import numpy as np
            from scipy.interpolate import make_interp_spline

            # linear in the values: a spline through the unit values gives the weights
            self._spline = make_interp_spline(points, np.eye(n), k=min(_ORDERS[self.method], n - 1))

    def _held(self, x: float) -> float:
        x = x if self.below else max(x, self.points[0])
        return x if self.above else min(x, self.points[-1])

    @property
    def plain(self) -> bool:
        """Whether it is linear and held at its ends."""
        ends = (self._least, self._most) == (self.points[0], self.points[-1])
        return ends and self.method == "linear"

    def weights(self, x: float) -> Sequence[tuple[int, float]]:
        """Numbers and weights of the breakpoints that count at ``x``."""
        x = self._least if x < self._least else self._most if x > self._most else x
        points = self.points
        last = len(points) - 1
        if self._spline is not None:
            return [*enumerate(self._spline(x).tolist())]
        if self.method == "linear" and last:
            j = min(max(bisect_right(points, x) - 1, 0), last - 1)
            part = (x - points[j]) / (points[j + 1] - points[j])
            return ((j, 1.0 - part), (j + 1, part))
        if self.method == "discrete":
            j = bisect_right(self._middles, x)
        elif self.method == "ceiling":
            j = bisect_left(points, x)
        else:
            j = bisect_right(points, x) - 1
        return ((min(max(j, 0), last), 1.0),)


@dataclass
class Grid:
    """Values on a grid; the last axis changes fastest."""

    axes: Sequence[Axis]
    values: Sequence[float]

    def __call__(self, *x: float) -> float:
        terms: Sequence[tuple[int, float]] = ((0, 1.0),)
        for axis, value in zip(self.axes, x, strict=True):
            n, near = len(axis.points), axis.weights(value)
            terms = [(i * n + j, w * v) for i, w in terms for j, v in near]
        values = self.values
        return sum([w * values[i] for i, w in terms])
