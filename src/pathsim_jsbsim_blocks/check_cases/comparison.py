"""Compare a flight of a check case with NASA's simulators: numbers, a table, a figure."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import refuse, whole
from .._core.running import fly
from ..catalogue import load_diagram

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pathsim.blocks import Scope

_DATA = Path(__file__).resolve().parent / "data"

CASES: Mapping[int, str] = {
    1: "a sphere falls without drag",
    2: "a brick tumbles without damping",
    3: "a brick tumbles with damping",
    4: "a sphere falls to a round Earth that does not rotate",
    5: "a sphere falls to a round Earth that rotates",
    6: "a sphere falls to the ellipsoid",
    7: "a sphere falls in a steady wind",
    8: "a sphere falls through a wind shear",
    9: "a sphere is thrown to the east",
    10: "a sphere is thrown to the north",
}

_KNOT = 6076.11548556 / 3600.0  # ft/s: 1852 m per hour


@dataclass(frozen=True)
class _Quantity:
    column: str  # in the reference tables
    unit: str  # of the reference
    per_signal: float  # factor from the signal to that unit
    limit: float | None  # from simulator 05, where that gives the quantity


# by the names that the diagrams' scopes give them
_QUANTITIES = {
    "altitude": _Quantity("altitude_ft", "ft", 1.0, 0.05),
    "latitude": _Quantity("latitude_deg", "deg", 1.0, 2e-7),
    "longitude": _Quantity("longitude_deg", "deg", 1.0, 2e-7),
    "true airspeed": _Quantity("tas_kt", "kt", 1.0 / _KNOT, 1e-3),
    "roll angle": _Quantity("roll_deg", "deg", 1.0, 1e-3),
    "pitch angle": _Quantity("pitch_deg", "deg", 1.0, 1e-3),
    "heading": _Quantity("yaw_deg", "deg", 1.0, 1e-3),
    "roll rate": _Quantity("p_deg_s", "deg/s", math.degrees(1.0), 1e-4),
    "pitch rate": _Quantity("q_deg_s", "deg/s", math.degrees(1.0), 1e-4),
    "yaw rate": _Quantity("r_deg_s", "deg/s", math.degrees(1.0), 1e-4),
    "velocity north": _Quantity("v_north_fps", "ft/s", 1.0, None),
    "velocity east": _Quantity("v_east_fps", "ft/s", 1.0, None),
    "velocity down": _Quantity("v_down_fps", "ft/s", 1.0, None),
}

# the medians have 12 digits, the spreads four
_ROUNDING, _ROUNDING_OF_SPREADS = 1e-11, 5e-4


@dataclass(frozen=True)
class Deviation:
    """How far a quantity of a flight is from NASA's simulators, at worst over the run.

    Attributes
    ----------
    quantity, unit : str
        what is compared, and the unit of all numbers
    worst : float
        largest distance from the median of the simulators
    band : float
        largest distance of the simulators from their median, the worst simulator left out
    from_05 : float or None
        largest distance from simulator 05, if that gives the quantity
    limit_05 : float or None
        limit of ``from_05``
    passes : bool
        whether the flight is within the band and the limit
    """

    quantity: str
    unit: str
    worst: float
    band: float
    from_05: float | None
    limit_05: float | None
    passes: bool


def fly_case(case: int, rate: int = 100, integrators: Any = "precise") -> list[Scope]:
    """Fly the diagram of a check case.

    Parameters
    ----------
    case : int
        1 to 10
    rate : int
        steps per second, an even number
    integrators : str or dict
        as in `JSBSimFDM`

    Returns
    -------
    list of pathsim.blocks.Scope
        the scopes of the diagram, with their recording

    Raises
    ------
    ParameterError
        for a case that does not exist, or a rate without a sample at each 0.5 s
    """
    from pathsim.blocks import Scope

    name = f"check_case_{_known(case):02d}"
    if whole("rate", rate, low=10) % 2:
        refuse(
            "rate",
            rate,
            f"rate must be even, for the reference has a point each 0.5 s, not {rate!r}",
        )
    T = 1 / rate
    diagram = load_diagram(name, {"vehicle.T": T, "vehicle.integrators": integrators, "sim.dt": T})
    fly(diagram.sim, diagram.DURATION)
    return [block for block in diagram.sim.blocks if isinstance(block, Scope)]


def compare(case: int, *scopes: Scope) -> list[Deviation]:
    """Compare the recording of a check case with NASA's simulators.

    Parameters
    ----------
    case : int
        1 to 10
    *scopes : pathsim.blocks.Scope
        with 30 s of the diagram's signals

    Returns
    -------
    list of Deviation
        one for each quantity

    Raises
    ------
    ParameterError
        for a case that does not exist, a signal that is missing, or times that are not recorded
    """
    reference, single = _reference(_known(case)), _simulator_05(case)
    found = []
    for name, quantity in _QUANTITIES.items():
        median = reference[quantity.column]
        worst = abs(_distance(name, scopes, reference["time_s"], median)).max()
        band = reference[f"{quantity.column}_spread_but_worst"].max()
        passes = worst <= band * (1 + _ROUNDING_OF_SPREADS) + _ROUNDING * max(1, abs(median).max())
        from_05 = None
        if quantity.limit is not None:
            from_05 = float(
                abs(_distance(name, scopes, single["time_s"], single[quantity.column])).max()
            )
            passes = passes and from_05 <= quantity.limit
        found.append(
            Deviation(
                name,
                quantity.unit,
                float(worst),
                float(band),
                from_05,
                quantity.limit,
                bool(passes),
            )
        )
    return found


def comparison_table(case: int, deviations: Sequence[Deviation]) -> str:
    """The deviations of a check case as text, one line for each quantity."""
    rows = [
        ("", "", "from the", "band of", "from", "", ""),
        ("quantity", "unit", "median", "NASA's", "sim. 05", "limit", ""),
        *(
            (
                d.quantity,
                d.unit,
                _short(d.worst),
                _short(d.band),
                _short(d.from_05),
                _short(d.limit_05),
                "pass" if d.passes else "FAIL",
            )
            for d in deviations
        ),
    ]
    return "\n".join(
        [
            f"check case {case}: {CASES[case]}",
            *(
                (
                    f"  {name:<15}{unit:<6}" + "".join(f"{x:>10}" for x in numbers) + f"  {verdict}"
                ).rstrip()
                for name, unit, *numbers, verdict in rows
            ),
        ]
    )


def comparison_figure(case: int, *scopes: Scope) -> Figure:
    """A flight in the band of NASA's simulators: distances from their median over time.

    Parameters
    ----------
    case : int
        1 to 10
    *scopes : pathsim.blocks.Scope
        with 30 s of the diagram's signals

    Returns
    -------
    matplotlib.figure.Figure
        a panel for each quantity in which the simulators differ
    """
    from ..plots import exact_curves, subplots

    reference, single = _reference(_known(case)), _simulator_05(case)
    time = reference["time_s"]
    shown = {
        name: quantity
        for name, quantity in _QUANTITIES.items()
        if reference[f"{quantity.column}_spread_but_worst"].max()
        > _ROUNDING * max(1, abs(reference[quantity.column]).max())
    }
    rows = math.ceil(len(shown) / 2)
    figure, axes = subplots(
        rows, 2, sharex=True, squeeze=False, layout="constrained", figsize=(10, 1 + 1.7 * rows)
    )
    with exact_curves():
        for ax, (name, quantity) in zip(axes.flat, shown.items(), strict=False):
            band = reference[f"{quantity.column}_spread_but_worst"]
            ax.fill_between(
                time,
                -band,
                band,
                color="tab:gray",
                alpha=0.3,
                label="NASA's simulators but the worst",
            )
            ax.plot(
                time,
                _distance(name, scopes, time, reference[quantity.column]),
                label="this diagram",
            )
            if quantity.limit is not None:
                median = np.interp(single["time_s"], time, reference[quantity.column])
                ax.plot(
                    single["time_s"],
                    _on_circle(quantity, single[quantity.column] - median),
                    "k:",
                    label="simulator 05",
                )
            for edge in (-band.max(), band.max()):
                ax.axhline(edge, color="tab:gray", linestyle="--", linewidth=0.8)
            ax.set_ylabel(f"{name}\n[{quantity.unit}]")
            ax.grid(alpha=0.4)
        for ax in list(axes.flat)[len(shown) :]:
            ax.set_visible(False)
    for ax in list(axes.flat)[max(len(shown) - 2, 0) : len(shown)]:
        ax.set_xlabel("time [s]")
        ax.tick_params(labelbottom=True)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(f"check case {case}: {CASES[case]}; distance from NASA's median")
    return figure


def _known(case: Any) -> int:
    number = whole("case", case, low=1)
    if number not in CASES:
        refuse("case", case, f"case must be one of 1 to {max(CASES)}, not {case!r}")
    return number


@functools.cache
def _reference(case: int) -> np.ndarray:
    return np.genfromtxt(_DATA / f"nesc_{case:02d}.csv", delimiter=",", names=True)


@functools.cache
def _simulator_05(case: int) -> np.ndarray:
    table = np.genfromtxt(_DATA / "nesc_sim05.csv", delimiter=",", names=True)
    return table[table["case"] == case]


def _distance(
    name: str, scopes: Sequence[Scope], time: np.ndarray, expected: np.ndarray
) -> np.ndarray:
    """A recorded signal minus what is expected at given times."""
    from ..plots import signal

    scope = next((s for s in scopes if any(name in label for label in s.labels)), None)
    if scope is None:
        refuse("scopes", scopes, f"none of the scopes records the {name}")
    recorded, values = signal(scope, name)
    at = np.minimum(np.searchsorted(recorded, time - 1e-6), len(recorded) - 1)
    missing = time[abs(recorded[at] - time) > 1e-6]
    if missing.size:
        refuse(
            "scope",
            scope,
            f"the recording has no sample at t = {missing[0]:g} s, which the reference has",
        )
    quantity = _QUANTITIES[name]
    return _on_circle(quantity, values[at] * quantity.per_signal - expected)


def _on_circle(quantity: _Quantity, difference: np.ndarray) -> np.ndarray:
    turns = np.round(difference / 360.0) if quantity.unit == "deg" else 0.0
    return difference - 360.0 * turns


def _short(value: float | None) -> str:
    """Two digits; 0 for what is rounding."""
    return "" if value is None else "0" if value <= 1e-12 else f"{value:.2g}"
