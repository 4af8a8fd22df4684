"""Points of a study: expanded from a grid, checked one by one before any work begins."""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from numbers import Integral, Real
from typing import Any

import numpy as np

from .._core.checks import did_you_mean, must_be, nearest, number, refuse
from ..errors import ParameterError
from ..flight.trimming.condition import TrimCondition
from ..flight.trimming.state import UNITS

# columns that a grid can have, besides JSBSim properties
_COLUMNS = [f.name for f in dataclasses.fields(TrimCondition) if f.name != "setup"]

# suffixes of columns for units that cannot be suffixes themselves
_TAILS = {
    "KCAS": "kcas",
    "ft/s": "fps",
    "ft/s2": "fps2",
    "rad/s2": "radps2",
    "deg/s": "degps",
    "lbf": "lb",
    "cmd norm": "cmd_norm",
}


# sequences of numbers, but not meant as such
_BYTES = (bytes, bytearray, memoryview)


def column(name: str) -> str:
    """Name of a table's column: the quantity, then its unit."""
    unit = UNITS.get(name, "")
    tail = _TAILS.get(unit, unit)
    return name if not tail or name.endswith(f"_{tail}") else f"{name}_{tail}"


def expand(name: str, grid: Any) -> tuple[list[dict[str, Any]], str]:
    """Rows of a grid, and their number as text: 60 x 60 = 3,600.

    They are the product of a dict of axes (last axis fastest), or the rows of a table.
    """
    sizes: list[int] = []
    if hasattr(grid, "columns") and hasattr(grid, "to_dict"):
        grid = grid.to_dict("records")
    if isinstance(grid, Mapping):
        axes = {key: _axis(name, key, values) for key, values in grid.items()}
        values_of = itertools.product(*axes.values()) if axes else ()
        rows = [dict(zip(axes, values, strict=True)) for values in values_of]
        sizes = [len(values) for values in axes.values() if len(values) > 1]
    elif isinstance(grid, (str, bytes)) or not np.iterable(grid):
        must_be(name, grid, "a dict of axes, a table or a list of dicts")
    else:
        rows = list(grid)
        for row in rows:
            if not isinstance(row, Mapping):
                refuse(name, grid, f"{name} must hold one dict for each point, not {row!r}")
    if not rows:
        refuse(name, grid, f"{name} is empty")
    points = [
        {
            encodable(name, str(x)): plain(f"{name} point {i}: {x}", value)
            for x, value in row.items()
        }
        for i, row in enumerate(rows)
    ]
    product = f"{' x '.join(map(str, sizes))} = " if len(sizes) > 1 else ""
    return points, f"{product}{len(rows):,}"


def _axis(name: str, key: str, values: Any) -> list[Any]:
    if values is None or isinstance(values, (str, Real, Mapping, *_BYTES)):
        return [values]
    try:
        values = list(values)
    except TypeError:
        why = f"{name}: {key} must be a value or a list of values, not {values!r}"
        refuse(str(key), values, why)
    if not values:
        refuse(str(key), values, f"{name} is empty: {key} has no values")
    return values


def plain(name: str, value: Any) -> Any:
    """``value`` as plain Python data, which a file or another process returns unchanged."""
    if hasattr(value, "tolist") and not isinstance(value, _BYTES):  # numpy
        value = value.tolist()
    if value is None or isinstance(value, bool):
        return value
    if isinstance(value, str):
        return encodable(name, value)
    if isinstance(value, Integral):
        return int(value)
    if isinstance(value, Real):
        return number(name, value)
    if isinstance(value, Mapping):
        return {key: plain(f"{name}[{key!r}]", item) for key, item in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, _BYTES):
        return [plain(f"{name}[{i}]", item) for i, item in enumerate(value)]
    must_be(name, value, "a number, text, a list or a dict")


def encodable(name: str, text: str) -> str:
    """``text`` if a table can store it: file names may contain lone surrogates."""
    try:
        text.encode()
    except UnicodeEncodeError:
        must_be(name, text, "a text that can be encoded")
    return text


# lists and dicts whose text is JSON
_List = type("_List", (list,), {"__str__": json.dumps})
_Dict = type("_Dict", (dict,), {"__str__": json.dumps})


def cell(value: Any) -> Any:
    """Plain data as a cell of a table: lists and dicts for Parquet, JSON text in CSV."""
    if isinstance(value, dict):  # Parquet needs text for keys
        return _Dict({str(key): item for key, item in value.items()})
    return _List(value) if isinstance(value, list) else value


def trim_condition(i: int, point: dict[str, Any]) -> TrimCondition:
    """The condition of a point; columns with a slash are JSBSim properties."""
    fields = {key: value for key, value in point.items() if "/" not in key}
    for key in fields:
        if key not in _COLUMNS:
            close = did_you_mean(nearest(key, _COLUMNS))
            columns = f"columns: {', '.join(_COLUMNS)}, and JSBSim properties by their path"
            why = f"column {key!r} of the grid is not a field of TrimCondition{close} ({columns})"
            refuse(key, point[key], why)
    try:
        if fields.get("mach") is not None and fields.get("speed") is not None:
            refuse("mach", fields["mach"], "the grid sets both mach and speed; remove one")
        return TrimCondition(
            **{key: value for key, value in fields.items() if value is not None},
            setup={key: number(key, value) for key, value in point.items() if "/" in key},
        )
    except ParameterError as error:
        refuse(error.parameter, error.value, f"grid point {i}: {error}")


def structure(condition: TrimCondition) -> tuple[Any, ...]:
    """Which fields a condition writes to an aircraft, regardless of their values.

    Conditions with the same structure can share an aircraft, because each overwrites all that the
    one before has set.
    """
    return (
        condition.mode,
        *(getattr(condition, name) is None for name in _COLUMNS),
        condition.searched_by,
        *(tuple(getattr(condition, name)) for name in ("payload", "fuel", "setup")),
    )


def requested(conditions: list[TrimCondition], points: list[dict[str, Any]]) -> dict[str, list]:
    """Columns of the requested values, with defaults for those missing from the grid."""
    names = {key for point in points for key in point}
    names |= {"altitude", "speed", "gamma"}
    columns: dict[str, list] = {}
    for name in (name for name in _COLUMNS if name in names):
        values: list[Any] = [
            None if name == "speed" and condition.mach is not None else getattr(condition, name)
            for condition in conditions
        ]
        title = f"requested_{column(name)}"
        if name in ("payload", "fuel"):
            for index in sorted({index for value in values for index in value}):
                columns[f"{title}[{index}]"] = [value.get(index, math.nan) for value in values]
        else:
            columns[title] = [math.nan if value is None else value for value in values]
    for name in dict.fromkeys(key for point in points for key in point if "/" in key):
        columns[f"requested_{name}"] = [c.setup.get(name, math.nan) for c in conditions]
    return columns
