"""Trim maps: one aircraft trimmed at every point of a grid."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .._core.checks import integer, property_list
from .._core.extras import required
from ..errors import TrimError
from ..flight.airframe import Airframe
from ..flight.trimming import TrimState, trim
from ..flight.trimming.condition import TrimCondition
from ..flight.trimming.state import UNITS
from .grid import column, expand, requested, structure, trim_condition
from .journal import of_models
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

# points trimmed on one aircraft; results depend on it in the last bits
_CHAIN = 20

# fields of a state that a table shows, in this order
_FOUND = [name for name in UNITS if name in {f.name for f in dataclasses.fields(TrimState)}]


def trim_sweep(
    aircraft: str,
    grid: Any,
    *,
    outputs: Sequence[str] = (),
    root: str | None = None,
    create: Mapping[str, float] | str | None = None,
    chunk: int = 20,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Trim an aircraft at every point of a grid.

    The table does not depend on the order of the points, on ``chunk`` or on the number of workers,
    bit for bit: the points are sorted and cut into chains of 20, each trimmed in order on a fresh
    aircraft. The Newton search starts at the trim of the previous point in its chain. A failed
    search that alters JSBSim's state is also followed by a fresh aircraft.

    Parameters
    ----------
    aircraft : str
        name of the model
    grid : dict, DataFrame or list of dicts
        a dict of axes, ``{"altitude": 15000, "speed": range(120, 460, 10), "gamma": [0, 3]}``,
        means their product, the last axis fastest; a table or a list of dicts is taken row by row.
        Columns are the parameters of `TrimCondition`, in its units (for ``payload`` and ``fuel``
        each value is a list or dict), and JSBSim properties by their path, which are written
        before the trim
    outputs : list of str
        further JSBSim properties to read at each trimmed point
    root : str, optional
        JSBSim root directory; default is the one shipped with jsbsim
    create : dict or "missing", optional
        properties that the model expects from outside, as for `Airframe`
    chunk : int
        points that a worker processes together, rounded up to whole chains of 20
    jobs : int
        worker processes, at most 1024, -1 for all cores; under ``joblib.parallel_config("dask")``
        the cluster's workers are used instead
    resume : Path, optional
        file that keeps finished chunks: repeating a killed call with the same file resumes it
        with the same points, versions and XML files below ``root``
    progress : bool
        show a progress bar on stderr

    Returns
    -------
    pandas.DataFrame
        one row for each point, in the grid's order: the requested values (``requested_...``),
        ``trimmed``, ``reason`` (empty, or "thrust", "alpha limit", "elevator", "no convergence",
        "worker died" or another limit) and the trim, NaN if there is none.
        Each column ends with its unit (kcas: calibrated airspeed in kt, fps: ft/s, norm: fraction
        of the range). ``throttle_norm`` is that of the first engine: the trim moves all together;
        ``thrust_lb`` is their sum

    Raises
    ------
    ParameterError
        before the work begins: empty grid, unknown column, impossible values, a file that cannot
        be written or belongs to another study
    AircraftError, PropertyError
        before the work begins: unknown aircraft, property, tank or point mass
    """
    pd = required("pandas", "studies")

    points, count = expand("grid", grid)
    conditions = [trim_condition(i, point) for i, point in enumerate(points)]
    outputs = list(dict.fromkeys(property_list("outputs", outputs)))
    chunk = integer("chunk", chunk, low=1)
    airframe = partial(Airframe, aircraft, root=root)
    properties = _try_out(partial(airframe, create=create), conditions, outputs)
    airframe = partial(airframe, create=properties)
    order = sorted(range(len(points)), key=lambda i: _place(conditions[i]))
    chain = [conditions[i] for i in order]
    rows = run_parts(
        partial(_trim_points, airframe, tuple(outputs)),
        _chunks(chain, chunk),
        death={"trimmed": False, "reason": WORKER_DIED},
        describe=lambda condition: f"{aircraft}: {condition}",
        title=f"trim_sweep {aircraft}, {count} points",
        job=lambda: {
            "aircraft": str(aircraft),
            "root": root and str(root),
            "create": properties,
            "outputs": outputs,
            "chunk": chunk,
            "chain": _CHAIN,
            "conditions": [dataclasses.asdict(c) for c in chain],
            **of_models([root]),
        },
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    rows_at = dict(zip(order, rows, strict=True))
    rows = [rows_at[i] for i in range(len(points))]
    columns = [column(name) for name in _FOUND] + outputs
    parts = [
        pd.DataFrame(requested(conditions, points)),
        pd.DataFrame(rows, columns=["trimmed", "reason"]),
        pd.DataFrame([[row.get(x) for x in columns] for row in rows], columns=columns, dtype=float),
    ]
    table = pd.concat(parts, axis=1)
    table.attrs["aircraft"] = aircraft  # for the titles of figures
    return table


def _place(condition: TrimCondition) -> tuple[Any, ...]:
    """Sort key that groups conditions of one structure, with similar ones side by side."""
    values = [getattr(condition, field.name) for field in dataclasses.fields(condition)]
    return structure(condition), *map(_sortable, [condition.empty_cg_x, *values])


def _sortable(value: Any) -> tuple[Any, ...]:
    """A value of a condition, in a form that can be compared with any other."""
    if isinstance(value, (float, int)):
        return "number", value
    if value is None:
        return ("",)
    if isinstance(value, Mapping):
        value = tuple(value.items())
    return type(value).__name__, value


def _chunks(conditions: list[TrimCondition], size: int) -> list[list[TrimCondition]]:
    """The conditions in order, cut between chains; a new structure begins a new chain."""
    size = math.ceil(size / _CHAIN) * _CHAIN
    chunks: list[list[TrimCondition]] = []
    previous = None
    for condition in conditions:
        key = (structure(condition), condition.empty_cg_x)
        if key != previous or len(chunks[-1]) == size:
            chunks.append([])
        chunks[-1].append(condition)
        previous = key
    return chunks


def _try_out(
    load: Callable[..., Airframe], conditions: list[TrimCondition], outputs: list[str]
) -> dict[str, float]:
    """Trim one point of each structure, so that bad input fails before the work begins.

    Returns the properties created for the model.
    """
    for condition in {structure(condition): condition for condition in conditions}.values():
        airframe = load(empty_cg_x=condition.empty_cg_x)
        for name in outputs:
            airframe.reader(name)
        with contextlib.suppress(TrimError):
            trim(airframe, condition, hint=False)
    return airframe.created


def _trim_points(
    load: Callable[..., Airframe], outputs: tuple[str, ...], conditions: list[TrimCondition]
) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = []
    for i, condition in enumerate(conditions):
        if i % _CHAIN == 0:
            airframe = load(empty_cg_x=condition.empty_cg_x)
        try:
            state = trim(airframe, condition, hint=False, warm=True)
        except TrimError as error:
            rows.append({"trimmed": False, "reason": error.reason})
            continue
        row = {"trimmed": True, "reason": ""} | {column(x): getattr(state, x) for x in _FOUND}
        row[column("throttle")] = state.throttle[0] if state.throttle else None
        rows.append(row | {name: airframe.fdm[name] for name in outputs})
    return rows
