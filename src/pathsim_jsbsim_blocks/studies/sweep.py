"""Trim maps: one aircraft trimmed at every point of a grid."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jsbsim

from .._core.checks import property_list, whole
from .._core.extras import required
from ..errors import TrimError
from ..flight._trim import UNITS, TrimState, trim
from ..flight.airframe import Airframe
from ..flight.condition import TrimCondition
from .grid import column, expand, requested, structure, trim_conditions
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

# fields of a state that a table shows, in this order
_FOUND = [name for name in UNITS if name in {f.name for f in dataclasses.fields(TrimState)}]


def trim_sweep(
    aircraft: str,
    grid: Any,
    *,
    outputs: Sequence[str] = (),
    root: str | None = None,
    chunk: int = 40,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Trim an aircraft at every point of a grid.

    The table does not depend on the number of workers, bit for bit: a loaded aircraft is reused
    only within a chunk of points, and the chunks are fixed by the grid. A failed search alters
    JSBSim's state, so the next point gets a fresh aircraft.

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
    chunk : int
        points that share a loaded aircraft; 1 loads a fresh one for each point. Results agree to
        rounding (2e-13 in alpha) for any value
    jobs : int
        worker processes, -1 for all cores; under ``joblib.parallel_config("dask")`` the cluster's
        workers are used instead
    resume : Path, optional
        file that keeps finished chunks: repeating a killed call with the same file resumes it
    progress : bool
        show a progress bar on stderr

    Returns
    -------
    pandas.DataFrame
        one row for each point, in the grid's order: the requested values (``requested_...``),
        ``trimmed``, ``reason`` (empty, or "thrust", "alpha limit", "elevator", "no convergence",
        "worker died" or another limit) and the trim found, NaN where there is none.
        Each column ends with its unit (kcas: calibrated airspeed in kt, fps: ft/s, norm: fraction
        of the range). ``throttle_norm`` is that of the first engine: the trim moves all together;
        ``thrust_lb`` is their sum

    Raises
    ------
    ParameterError
        before the work begins: empty grid, unknown column, values that are not possible, a file
        that cannot be written or belongs to another study
    AircraftError, PropertyError
        before the work begins: unknown aircraft, property, tank or point mass
    """
    pd = required("pandas", "studies")
    required("joblib", "studies")

    points = expand("grid", grid)
    conditions = trim_conditions(points)
    outputs = list(dict.fromkeys(property_list("outputs", outputs)))
    chunk = whole("chunk", chunk, low=1)
    _try_out(aircraft, root, conditions, outputs)
    rows = run_parts(
        partial(_trim_points, aircraft, root, tuple(outputs)),
        _chunks(conditions, chunk),
        died={"trimmed": False, "reason": WORKER_DIED},
        describe=lambda condition: f"{aircraft}: {condition}",
        title=f"trim_sweep {aircraft}, {len(points)} points",
        job=lambda: {
            "aircraft": aircraft,
            "root": root and str(root),
            "outputs": outputs,
            "chunk": chunk,
            "conditions": [dataclasses.asdict(c) for c in conditions],
            "jsbsim": jsbsim.__version__,
        },
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    found = [column(name) for name in _FOUND] + outputs
    table = pd.concat(
        [
            pd.DataFrame(requested(conditions, points)),
            pd.DataFrame(rows, columns=["trimmed", "reason"]),
            pd.DataFrame(
                [[row.get(name) for name in found] for row in rows], columns=found, dtype=float
            ),
        ],
        axis=1,
    )
    table.attrs["aircraft"] = aircraft  # for the titles of figures
    return table


def _chunks(conditions: list[TrimCondition], size: int) -> list[list[TrimCondition]]:
    """The conditions in order, cut so that each chunk can be trimmed on one aircraft."""
    chunks: list[list[TrimCondition]] = []
    before = None
    for condition in conditions:
        now = (structure(condition), condition.empty_cg_x)
        if now != before or len(chunks[-1]) == size:
            chunks.append([])
        chunks[-1].append(condition)
        before = now
    return chunks


def _try_out(
    aircraft: str, root: str | None, conditions: list[TrimCondition], outputs: list[str]
) -> None:
    """Trim one point of each structure, so that bad input fails before the work begins."""
    for condition in {structure(condition): condition for condition in conditions}.values():
        airframe = Airframe(aircraft, root=root, empty_cg_x=condition.empty_cg_x)
        for name in outputs:
            airframe.reader(name)
        with contextlib.suppress(TrimError):
            trim(airframe, condition, hint=False)


def _trim_points(
    aircraft: str, root: str | None, outputs: tuple[str, ...], conditions: list[TrimCondition]
) -> list[dict[str, Any]]:
    airframe = Airframe(aircraft, root=root, empty_cg_x=conditions[0].empty_cg_x)
    rows: list[dict[str, Any]] = []
    for condition in conditions:
        try:
            state = trim(airframe, condition, hint=False, warm=True)
        except TrimError as error:
            rows.append({"trimmed": False, "reason": error.reason})
        else:
            rows.append(
                {
                    "trimmed": True,
                    "reason": "",
                    **_found(state),
                    **{name: airframe.fdm[name] for name in outputs},
                }
            )
    return rows


def _found(state: TrimState) -> dict[str, float | None]:
    values = {name: getattr(state, name) for name in _FOUND}
    values["throttle"] = state.throttle[0] if state.throttle else None
    return {column(name): value for name, value in values.items()}
