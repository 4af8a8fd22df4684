"""Table functions: on a grid, interpolated axis by axis, or of scattered points."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .elements import Element

Table = Callable[..., float]

_ORDERS = {"quadraticSpline": 2, "cubicSpline": 3}
# a spline's weights need memory for the square of the number of breakpoints
_MOST_SPLINE = 1000

_METHODS = ("linear", "discrete", "floor", "ceiling", *_ORDERS)


@dataclass
class Axis:
    """Breakpoints of one variable, and how to interpolate between them.

    ``discrete`` uses the nearest breakpoint, the upper one in the middle; ``floor`` the one at or
    below the variable, ``ceiling`` the one at or above. Beyond its ends the table is constant,
    unless ``below`` or ``above`` extrapolate it; ``low`` and ``high`` limit the variable.
    """

    points: Sequence[float]
    method: str = "linear"
    below: bool = False
    above: bool = False
    low: float = -math.inf
    high: float = math.inf

    def __post_init__(self) -> None:
        points, n = self.points, len(self.points)
        limits = [x if self.below else max(x, points[0]) for x in (self.low, self.high)]
        self._least, self._most = (x if self.above else min(x, points[-1]) for x in limits)
        self._middles = [(a + b) / 2 for a, b in itertools.pairwise(points)]
        self._spline: Any = None
        if n > 1 and self.method in _ORDERS:
            import numpy as np
            from scipy.interpolate import make_interp_spline

            # a spline is linear in its values: one through the unit vectors gives the weights
            self._spline = make_interp_spline(points, np.eye(n), k=min(_ORDERS[self.method], n - 1))

    def weights(self, x: float) -> Sequence[tuple[int, float]]:
        """Indices and weights of the breakpoints used at ``x``."""
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
            n, weights = len(axis.points), axis.weights(value)
            terms = [(i * n + j, w * v) for i, w in terms for j, v in weights]
        values = self.values
        return sum([w * values[i] for i, w in terms])


def read_tables(root: Element) -> dict[str, tuple[Element, Table, tuple[str, ...]]]:
    """By output variable: the function element, its table and the table's arguments."""
    definitions: dict[tuple[str, str], Element] = {}
    children = (x for f in root.all("function") for d in f.all("functionDefn") for x in d.children)
    for element in [*root.children, *children]:
        for key in ("bpID", "gtID", "utID"):
            if key in element.attributes and not element.tag.endswith("Ref"):
                definitions[key, element.attributes[key]] = element

    def defined(key: str, reference: Element) -> Element:
        name = reference.get(key)
        if (key, name) not in definitions:
            names = [n for k, n in definitions if k == key]
            raise reference.error(f"no {key} {name!r}", name=name, of=names)
        return definitions[key, name]

    functions: dict[str, tuple] = {}
    for function in root.all("function"):
        variables = [*function.all("independentVarPts", "independentVarRef")]
        output = function.one("dependentVarPts", "dependentVarRef")
        name = output.get("varID")
        if name in functions or not variables:
            raise function.error("has two functions, or a function without variables", name)
        if output.tag == "dependentVarPts":
            table: Table = _grid(output, variables, variables)
        else:
            kinds = ("griddedTable", "griddedTableDef", "ungriddedTable", "ungriddedTableDef")
            refs = ("griddedTableRef", "ungriddedTableRef")
            data = function.one("functionDefn").one(*kinds, *refs)
            if data.tag in refs:
                data = defined(data.tag[0] + "tID", data)
            if data.tag[0] == "u":
                table = _scattered(data, variables)
            else:
                places = data.one("breakpointRefs").all("bpRef")
                points = [defined("bpID", x).one("bpVals") for x in places]
                table = _grid(data.one("dataTable"), variables, points)
        functions[name] = function, table, tuple(v.get("varID") for v in variables)
    return functions


def _grid(data: Element, variables: Sequence[Element], points: Sequence[Element]) -> Grid:
    if len(points) != len(variables):
        raise data.error(f"{len(variables)} variables, but {len(points)} sets of breakpoints")
    axes = [_axis(v, p, p.numbers()) for v, p in zip(variables, points, strict=True)]
    values, shape = data.numbers(), [len(axis.points) for axis in axes]
    if math.prod(shape) != len(values):
        counts = " x ".join(map(str, shape))
        raise data.error(f"{counts} breakpoints need {math.prod(shape)} values, not {len(values)}")
    return Grid(axes, values)


def _scattered(data: Element, variables: Sequence[Element]) -> Table:
    """Values at scattered points: linear on Delaunay triangles, outside the nearest point's."""
    rows = []
    for point in data.all("dataPoint"):
        rows.append(point.numbers())
        if len(rows[-1]) != len(variables) + 1:
            raise point.error(f"needs {len(variables)} coordinates and a value")
    if not rows:
        raise data.error("has no dataPoint")
    if len(variables) == 1:
        xs, ys = map(list, zip(*sorted(rows), strict=True))
        return Grid([_axis(variables[0], data, xs)], ys)
    axes = [_axis(v, data, [0.0]) for v in variables]
    for v, axis in zip(variables, axes, strict=True):
        if axis.method != "linear" or axis.below or axis.above:
            raise v.error("a table of scattered points must be linear, without extrapolation")
    from scipy.interpolate import LinearNDInterpolator, NearestNDInterpolator
    from scipy.spatial import QhullError

    points, values = [row[:-1] for row in rows], [row[-1] for row in rows]
    try:
        # rescaled, so that all variables have the same weight in distances
        linear = LinearNDInterpolator(points, values, rescale=True)
    except QhullError:
        raise data.error("its points span no area or volume") from None
    nearest = NearestNDInterpolator(points, values, rescale=True)

    def table(*x: float) -> float:
        at = [min(max(value, a.low), a.high) for value, a in zip(x, axes, strict=True)]
        y = float(linear([at])[0])
        return float(nearest([at])[0]) if math.isnan(y) else y

    return table


def _axis(variable: Element, at: Element, points: list[float]) -> Axis:
    sides = variable.get("extrapolate", "neither", "min", "max", "both")
    method = variable.get("interpolate", *_METHODS)
    if not points or any(a >= b for a, b in itertools.pairwise(points)):
        raise at.error(f"breakpoints must increase, not {points}"[:200])
    if method in _ORDERS and len(points) > _MOST_SPLINE:
        raise at.error(f"a spline has {_MOST_SPLINE:,} breakpoints at most, not {len(points):,}")
    low, high = variable.number("min", -math.inf), variable.number("max", math.inf)
    if low > high:
        raise variable.error(f"min {low:g} is above max {high:g}")
    return Axis(points, method, sides in ("min", "both"), sides in ("max", "both"), low, high)
