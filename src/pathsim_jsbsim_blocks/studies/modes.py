"""Natural modes over airspeed: a linear model at each point of a sweep."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import number, refuse
from .._core.extras import required
from ..errors import LinearisationError, TrimError
from ..flight.airframe import Airframe
from ..flight.fleet import prepared
from .workers import WORKER_DIED, run_parts

if TYPE_CHECKING:
    import pandas as pd

# aircraft of the study: KCAS
_SWEEPS = {"c172p": range(60, 121, 5), "737": range(190, 341, 10)}

# columns of the table; the second short period is the slower one of two real poles
MODES = ("short period", "short period 2", "phugoid", "Dutch roll", "roll", "spiral")


def column(mode: str) -> str:
    """Name of a mode in columns."""
    return mode.lower().replace(" ", "_")


# columns of the poles
POLES = [f"{column(mode)}_{part}" for mode in MODES for part in ("real", "imag")]


def modes_over_speed(
    *,
    aircraft: str | None = None,
    altitude: float = 5000.0,
    speeds: Iterable[float] | None = None,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Natural modes of a light aircraft and an airliner in level flight, against airspeed.

    A c172p from 60 to 120 KCAS and a 737 from 190 to 340 KCAS at 5000 ft, flown linear models
    (`Aircraft.linear_model`), retractable gear up, fuel frozen.

    Parameters
    ----------
    aircraft : str, optional
        name of one model instead of both
    altitude : float
        ft
    speeds : iterable of float, optional
        KCAS; default is the aircraft's own range in this study
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        one row for each point: ``aircraft``, ``requested_altitude_ft``, ``requested_speed_kcas``,
        ``trimmed``, ``reason`` (why there is no trim or no linear model, else empty), ``warning``
        (if the aircraft is nonlinear there, else empty), and for each mode the real part
        (``phugoid_real``, 1/s) and the imaginary part (``phugoid_imag``, rad/s) of its pole, NaN
        if the mode does not exist. Two real poles of a short period are ``short_period`` and
        the slower ``short_period_2``

    Raises
    ------
    ParameterError
        before the work begins: speeds without an aircraft, an aircraft that needs speeds, values
        that are impossible, a file that cannot be written or belongs to another study
    AircraftError
        before the work begins: unknown aircraft
    """
    pd = required("pandas", "studies")
    altitude = number("altitude", altitude)
    if aircraft is None and speeds is not None:
        refuse("speeds", speeds, "speeds need an aircraft: aircraft=NAME")
    if aircraft is not None and speeds is None and aircraft not in _SWEEPS:
        Airframe(aircraft)
        why = f"{aircraft!r} needs speeds=...; the study has its own for {' and '.join(_SWEEPS)}"
        refuse("speeds", None, why)
    airspeeds = None if speeds is None else [number("speeds", x, above=0.0) for x in speeds]
    points: list[dict[str, Any]] = [
        {"aircraft": name, "requested_altitude_ft": altitude, "requested_speed_kcas": float(speed)}
        for name in (_SWEEPS if aircraft is None else [aircraft])
        for speed in (_SWEEPS[name] if airspeeds is None else airspeeds)
    ]
    if not points:
        refuse("speeds", speeds, "speeds is empty")
    clean = {name: prepared(name, None)[1] for name in {point["aircraft"] for point in points}}
    rows = run_parts(
        _modes_at,
        [[{**point, "clean": clean[point["aircraft"]]}] for point in points],
        died={"trimmed": False, "reason": WORKER_DIED},
        describe=lambda point: "{aircraft} at {requested_speed_kcas:g} KCAS".format(**point),
        title=f"modes_over_speed, {len(points)} points",
        job=lambda: {"study": "modes_over_speed", "points": points},
        jobs=jobs,
        resume=resume,
        progress=progress,
    )
    # columns of poles that no row has are numbers too
    empty = {"warning": "", **dict.fromkeys(POLES, np.nan)}
    table = [{**p, **empty, **row} for p, row in zip(points, rows, strict=True)]
    return pd.DataFrame(table, columns=[*points[0], "trimmed", "reason", "warning", *POLES])


def _modes_at(points: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Poles of the modes at each point."""
    from ..flight import linear_model

    rows = []
    for point in points:
        altitude, speed = point["requested_altitude_ft"], point["requested_speed_kcas"]
        condition = replace(point["clean"], altitude=altitude, speed=speed)
        row: dict[str, Any] = {"trimmed": True, "reason": "", "warning": ""}
        rows.append(row)
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always", RuntimeWarning)
                modes = linear_model(point["aircraft"], condition).modes()
        except TrimError as error:
            row.update(trimmed=False, reason=error.reason)
        except LinearisationError as error:
            row["reason"] = str(error)
        else:
            row["warning"] = "; ".join(str(x.message) for x in caught)
            for mode in modes:  # the fastest first
                name = column(mode.name)
                if name == "short_period" and f"{name}_real" in row:
                    name = "short_period_2"
                row[f"{name}_real"], row[f"{name}_imag"] = mode.pole.real, mode.pole.imag
    return rows
