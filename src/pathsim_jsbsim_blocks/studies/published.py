"""The published trim studies, each a function that returns its table, and the catalogue.

They follow the notebooks of jsbsim-python-examples (De Marco, McLeod, da Silva), with their
settings. Those loops take one step before some of the trims, which moves results by up to 1e-6.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..flight.airframe import Airframe
from ..flight.model_files import empty_weight_cg
from . import figures
from .failure import engine_failure, engine_failure_chart
from .sweep import trim_sweep

if TYPE_CHECKING:
    import pandas as pd

_FULL_TANK = 8097.63  # lb, each of the global5000's three tanks
_FULL_PAYLOAD = 15172.0  # lb

# weight case: payload in lb, fuel in each tank in lb
_WEIGHTS = {
    "light": (1500.0, 1000.0),
    "mid": (_FULL_PAYLOAD / 2, _FULL_TANK / 2),
    "heavy": (_FULL_PAYLOAD, _FULL_TANK),
}

_SPEEDS = range(90, 550, 10)  # KCAS

_ALPHA_LIMITS = {"alpha_min": -4.0, "alpha_max": 12.0}  # deg, of the published loops


def _solver(aircraft: str, published: str) -> dict[str, Any]:
    """JSBSim's own search for the published aircraft, the usual one for others."""
    return {"solver": "jsbsim"} if aircraft == published else {}


def aoa_vs_cas(
    *,
    aircraft: str = "global5000",
    altitude: float = 15000.0,
    speeds: Iterable[float] = _SPEEDS,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Angle of attack and elevator of a business jet in level flight, against airspeed.

    A Global 5000 with half payload and half fuel at 15,000 ft, 90 to 540 KCAS.

    Parameters
    ----------
    aircraft : str
        name of the model. The Global 5000 flies with half payload and half fuel, any other
        aircraft with the payload and fuel of its model
    altitude : float
        ft
    speeds : iterable of float
        KCAS
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        that of `trim_sweep`
    """
    payload, fuel = _WEIGHTS["mid"]
    loading = {"payload": [[payload]], "fuel": [[fuel] * 3]} if aircraft == "global5000" else {}
    solver = _solver(aircraft, "global5000")
    grid = {"altitude": altitude, **loading, **solver, "speed": speeds}
    return trim_sweep(aircraft, grid, jobs=jobs, resume=resume, progress=progress)


def aoa_vs_cas_loading(
    *, wide: bool = False, jobs: int = -1, resume: str | Path | None = None, progress: bool = True
) -> pd.DataFrame:
    """Angle of attack and elevator against airspeed for three weights and two CG positions.

    A Global 5000 in level flight with its empty-weight CG actually moved by 39.5 in: 5 % of its
    fuselage station (790.8 in aft of the datum), which is 30 % of the mean aerodynamic chord of
    10.99 ft. (The published notebook loads the model before it edits the CG: its forward case flies
    with the original CG, its aft case with the forward one.)

    With the CG aft, light and mid are statically unstable; they still trim, with an elevator that
    moves the opposite way with speed.

    Parameters
    ----------
    wide : bool
        False: the published six cases, empty CG 39.5 in forward at 8000 ft and 39.5 in aft at
        30,000 ft. True: both positions at both altitudes
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        that of `trim_sweep`, preceded by ``cg_shift_percent``, of the fuselage station of
        the empty-weight CG and aft positive, and ``weight_case``
    """
    cg_x = empty_weight_cg("global5000")[0]
    cases = [
        (shift, weight, altitude)
        for shift, published_altitude in ((-5, 8000), (5, 30000))
        for weight in _WEIGHTS
        for altitude in (8000, 30000)
        if wide or altitude == published_altitude
    ]
    grid = [
        {
            "altitude": altitude,
            "speed": speed,
            "empty_cg_x": (1 + shift / 100) * cg_x,
            "payload": [_WEIGHTS[weight][0]],
            "fuel": [_WEIGHTS[weight][1]] * 3,
            "solver": "jsbsim",
        }
        for shift, weight, altitude in cases
        for speed in _SPEEDS
    ]
    table = trim_sweep("global5000", grid, jobs=jobs, resume=resume, progress=progress)
    table.insert(0, "cg_shift_percent", [shift for shift, _, _ in cases for _ in _SPEEDS])
    table.insert(1, "weight_case", [weight for _, weight, _ in cases for _ in _SPEEDS])
    return table


def thrust_vectoring(
    *,
    aircraft: str = "737",
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Thrust of an airliner against the pitch angle of its engines, and its minimum.

    A 737 in cruise (30,000 ft, Mach 0.8) and in climb (15,000 ft, 300 KCAS, 3 deg), 100 angles
    from 0 to 10 deg. The minimum is at about 4 deg in both.

    Parameters
    ----------
    aircraft : str
        name of the model; all its engines are turned
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        that of `trim_sweep`, preceded by ``case`` and ``thrust_angle_deg``

    References
    ----------
    G. B. Gilyard, A. Bolonkin, "Optimal Pitch Thrust-Vector Angle and Benefits for all Flight
    Regimes", NASA/TM-2000-209021, 2000
    """
    cases = {
        "cruise": {"altitude": 30000.0, "mach": 0.8},
        "climb": {"altitude": 15000.0, "speed": 300.0, "gamma": 3.0},
    }
    solver = _solver(aircraft, "737")
    angles = np.linspace(0.0, 10.0, 100).tolist()
    nozzles = [f"propulsion/engine[{i}]/pitch-angle-rad" for i in range(Airframe(aircraft).engines)]
    grid: list[dict[str, Any]] = [
        {**condition, **solver, **dict.fromkeys(nozzles, math.radians(angle))}
        for condition in cases.values()
        for angle in angles
    ]
    table = trim_sweep(aircraft, grid, jobs=jobs, resume=resume, progress=progress)
    table.insert(0, "case", [case for case in cases for _ in angles])
    table.insert(1, "thrust_angle_deg", angles * len(cases))
    return table


def trim_envelope(
    *,
    aircraft: str = "737",
    altitude: float = 15000.0,
    speeds: Iterable[float] = range(120, 460, 10),
    wide: bool = False,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Envelope of steady flight of an airliner: airspeed against flight path angle.

    A 737 at 15,000 ft, 120 to 450 KCAS, -10 to 9 deg.

    Parameters
    ----------
    aircraft : str
        name of the model
    altitude : float
        ft
    speeds : iterable of float
        KCAS
    wide : bool
        False: the published settings, gear down (the model's own setting) and alpha within
        [-4, 12] deg. True: gear up and alpha within [-5, 15] deg
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        that of `trim_sweep`, 680 rows for the 737
    """
    settings = {"gear": 0.0, "alpha_min": -5.0, "alpha_max": 15.0} if wide else _ALPHA_LIMITS
    settings = {**settings, **_solver(aircraft, "737")}
    grid = {"altitude": altitude, **settings, "speed": speeds, "gamma": range(-10, 10)}
    return trim_sweep(aircraft, grid, jobs=jobs, resume=resume, progress=progress)


def climb_schedule(
    *,
    aircraft: str = "A4",
    speed: float = 300.0,
    gamma: float = 5.0,
    jobs: int = -1,
    resume: str | Path | None = None,
    progress: bool = True,
) -> pd.DataFrame:
    """Throttle and pitch trim of a jet in a steady climb, against altitude.

    An A-4 at 300 KCAS and 5 deg, 1000 to 20,000 ft: the tables that the diagram ``scheduled_climb``
    flies by. Alpha is within [-4, 12] deg.

    Parameters
    ----------
    aircraft : str
        name of the model
    speed : float
        KCAS
    gamma : float
        flight path angle in deg
    jobs, resume, progress
        as in `trim_sweep`

    Returns
    -------
    pandas.DataFrame
        that of `trim_sweep`
    """
    altitudes = range(1000, 21000, 1000)
    settings = {**_ALPHA_LIMITS, **_solver(aircraft, "A4")}
    grid = {"speed": speed, "gamma": gamma, **settings, "altitude": altitudes}
    return trim_sweep(aircraft, grid, jobs=jobs, resume=resume, progress=progress)


class Study(NamedTuple):
    """A study of the catalogue: its table, and the table's figure."""

    table: Callable[..., pd.DataFrame]
    figure: Callable[[pd.DataFrame], Any]


STUDIES = {
    "aoa_vs_cas": Study(aoa_vs_cas, figures.alpha_elevator_chart),
    "aoa_vs_cas_loading": Study(aoa_vs_cas_loading, figures.alpha_elevator_chart),
    "climb_schedule": Study(climb_schedule, figures.climb_chart),
    "engine_failure": Study(engine_failure, engine_failure_chart),
    "thrust_vectoring": Study(thrust_vectoring, figures.thrust_chart),
    "trim_envelope": Study(trim_envelope, figures.envelope_map),
}
