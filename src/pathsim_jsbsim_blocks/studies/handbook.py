"""A model's performance against a handbook's, value by value."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import as_path, did_you_mean, nearest, refuse
from .._core.extras import required
from ..errors import FileError
from .flight_tests import QUANTITIES
from .performance import performance_table

if TYPE_CHECKING:
    import pandas as pd

_GIVEN = ("quantity", "altitude_ft", "weight_lb", "flaps_norm", "value", "unit", "source")
_NUMBERS = ("altitude_ft", "weight_lb", "flaps_norm", "value", "speed_kcas")
_TERMS = ("lift slope", "drag at zero lift", "induced drag factor", "full thrust at Vy")


def against_handbook(
    aircraft: str, handbook: str | Path | pd.DataFrame, **options: Any
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """The performance of a model at the conditions of a handbook, and the difference.

    Parameters
    ----------
    aircraft : str
        name of the model
    handbook : Path or DataFrame
        CSV with the columns ``quantity`` (as `performance_table` names it), ``altitude_ft``,
        ``weight_lb``, ``flaps_norm``, ``value``, ``unit`` and ``source`` (document and page), and
        ``speed_kcas`` for values at an airspeed. An altitude that is left open is 0 ft, a weight
        the model's own, flaps are up
    **options
        ``root``, ``jobs``, ``resume`` and ``progress`` of `performance_table`

    Returns
    -------
    compared : pandas.DataFrame
        the handbook with ``model``, ``difference_percent`` of the model, its ``reason`` where it
        has no value, and the terms that make the value at this altitude and weight: lift slope,
        drag at zero lift, induced drag, full thrust
    table : pandas.DataFrame
        that of `performance_table` at these conditions

    Raises
    ------
    FileError
        for a file that cannot be read
    ParameterError
        for a missing column, and for a quantity or unit that the charts do not have
    """
    rows = _rows(handbook)
    table = performance_table(
        aircraft,
        altitudes=sorted(rows.altitude_ft.unique()),
        weights=[*rows.weight_lb.dropna().unique()] or None,
        flaps=sorted(rows.flaps_norm.unique()),
        **options,
    )
    pd = required("pandas", "studies")
    return pd.DataFrame([_compared(row, table) for row in rows.to_dict("records")]), table


def _rows(handbook: Any) -> pd.DataFrame:
    """The rows of a handbook, its columns checked."""
    pd = required("pandas", "studies")
    if not hasattr(handbook, "columns"):
        path = as_path("handbook", handbook)
        try:
            handbook = pd.read_csv(path, comment="#", skipinitialspace=True)
        except OSError as error:
            raise FileError("read", path, error) from None
        except ValueError as error:
            refuse("handbook", str(path), f"{str(path)!r} is not a CSV file: {error}")
    for name in _GIVEN:
        if name not in handbook.columns:
            refuse("handbook", [*handbook.columns], f"the handbook has no column {name!r}")
    if handbook.empty:
        refuse("handbook", handbook, "the handbook has no rows")
    handbook = handbook.fillna({"altitude_ft": 0.0, "flaps_norm": 0.0})
    for name, unit in zip(handbook.quantity, handbook.unit.astype(object).fillna(""), strict=True):
        if name not in QUANTITIES:
            guess = did_you_mean(nearest(name, QUANTITIES))
            refuse("quantity", name, f"no chart has {name!r}{guess}")
        usual = QUANTITIES[name][1]
        if unit != usual:
            refuse("unit", unit, f"{name} is in {usual or 'no unit'}, not {unit!r}")
    for name in handbook.columns.intersection(_NUMBERS):
        try:
            handbook[name] = pd.to_numeric(handbook[name]).astype(float)
        except (ValueError, TypeError) as error:
            refuse(name, [*handbook[name]], f"{name} of the handbook: {error}")
    if not (handbook.value.abs() > 0.0).all():
        refuse("value", [*handbook.value], "a value of the handbook is missing or 0")
    return handbook


def _compared(row: dict[str, Any], table: pd.DataFrame) -> dict[str, Any]:
    """A handbook's value with the model's."""
    name, speed = row["quantity"], row.get("speed_kcas", math.nan)

    def near(rows: pd.DataFrame, column: str, within: float = 1.0) -> pd.DataFrame:
        is_open = math.isnan(row[column])
        return rows if is_open else rows[(rows[column] - row[column]).abs() < within]

    here = near(table, "weight_lb")
    level = near(here, "altitude_ft")
    same = near(here if "ceiling" in name else level, "flaps_norm", 1e-6)
    same = same[same.quantity == name]
    if not math.isnan(speed):
        same = _at_speed(same, speed)
    failed = table.reason[table.quantity.str.startswith("all of ")]
    why = "not at these conditions" if failed.empty else failed.iloc[0]
    model, reason = (math.nan, why) if same.empty else same.iloc[0][["value", "reason"]]
    return {
        **{column: row[column] for column in _GIVEN[:-1]},
        "speed_kcas": speed,
        "model": model,
        "difference_percent": 100.0 * (model / row["value"] - 1.0),
        "reason": reason,
        **{term: level.value[level.quantity == term].max() for term in _TERMS},
        "source": row["source"],
    }


def _at_speed(curve: pd.DataFrame, speed: float) -> pd.DataFrame:
    """The value of a curve at an airspeed; nothing beyond its ends."""
    curve = curve.dropna(subset=["value"]).sort_values("speed_kcas")
    if not curve.speed_kcas.min() <= speed <= curve.speed_kcas.max():
        return curve[:0]
    return curve[:1].assign(value=np.interp(speed, curve.speed_kcas, curve.value), reason="")
