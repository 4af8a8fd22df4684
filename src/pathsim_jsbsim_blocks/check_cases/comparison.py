"""Compare a flight of a check case with NASA's simulators: numbers, a table, a figure."""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import integer, must_be, number, refuse
from .._core.running import fly
from .._core.units import KNOT
from ..catalogue import load_diagram

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pathsim.blocks import Scope

_DATA = Path(__file__).resolve().parent / "data"

CASES: Mapping[float, str] = {
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
    11: "an F-16 in level flight, controls fixed",
    12: "an F-16 in supersonic flight, controls fixed",
    13.1: "an F-16's autopilot climbs by 100 ft",
    13.2: "an F-16's autopilot slows down by 5 kt",
    13.3: "an F-16's autopilot turns by 15 deg",
    13.4: "an F-16's autopilot moves 2000 ft to the right",
    15: "an F-16 flies a circle around the North Pole",
    16: "an F-16 circles where the equator meets the date line",
}


@dataclass(frozen=True)
class _Quantity:
    column: str  # in the reference tables
    unit: str  # of the reference
    per_signal: float  # factor from the signal to that unit
    limit: float | None  # of the distance from simulator 05; None if that lacks the quantity
    has_band: bool = True  # whether it must lie in NASA's band


# by their names in the diagrams' scopes
_QUANTITIES = {
    "altitude": _Quantity("altitude_ft", "ft", 1.0, 0.05),
    "latitude": _Quantity("latitude_deg", "deg", 1.0, 2e-7),
    "longitude": _Quantity("longitude_deg", "deg", 1.0, 2e-7),
    "true airspeed": _Quantity("tas_kt", "kt", 1.0 / KNOT, 1e-3),
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

# F-16 limits of the distance from simulator 05: altitude in ft, attitude in deg
_F16 = {
    11: (0.01, 0.002),
    12: (0.01, 0.002),
    13.1: (0.5, 0.02),
    13.2: (0.5, 0.02),
    13.3: (0.5, 0.6),
    13.4: (0.5, 0.6),
    15: (0.05, 0.05),
    16: (0.05, 0.05),
}
_F16_PLACE = 2e-5  # deg of latitude, and of longitude along the parallel
_F16_AIRSPEED = 0.05  # kt

# the medians have 12 digits, the spreads four
_ROUNDING, _ROUNDING_OF_SPREADS = 1e-11, 5e-4


@dataclass(frozen=True)
class Deviation:
    """Maximum distance of a quantity of a flight from NASA's simulators.

    Attributes
    ----------
    quantity, unit : str
        the quantity, and the unit of all numbers
    worst : float
        maximum distance from the median of the simulators, up to ``until``
    band : float or None
        maximum distance of the simulators from their median: all three in the F-16's cases, all
        but the worst in the others; None for the F-16's airspeed, which only two simulators give,
        and they differ
    from_05 : float or None
        maximum distance from simulator 05, None if that lacks the quantity
    limit_05 : float or None
        limit of ``from_05``
    ratio : float
        the larger of the two distances over their limits: ``worst`` over ``band`` (with the digits
        of the reference), ``from_05`` over ``limit_05``
    until : float
        end of the comparison, s
    """

    quantity: str
    unit: str
    worst: float
    band: float | None
    from_05: float | None
    limit_05: float | None
    ratio: float
    until: float = math.inf

    @property
    def passes(self) -> bool:
        """Whether the flight is within the band and the limit."""
        return self.ratio <= 1.0


def fly_case(case: float, rate: int | None = None, integrators: Any = "precise") -> list[Scope]:
    """Fly the diagram of a check case.

    Parameters
    ----------
    case : float
        1 to 12, 13.1 to 13.4, 15 or 16
    rate : int, optional
        steps per second, an even number; default is 100, and for the F-16 of cases 11 to 16 200,
        the minimum there
    integrators : str or dict
        as in `JSBSimFDM`

    Returns
    -------
    list of pathsim.blocks.Scope
        the scopes of the diagram, with their recording

    Raises
    ------
    ParameterError
        for a case that does not exist, a rate without a sample every 0.5 s, and a rate that is too
        low for the F-16's control laws
    """
    from pathsim.blocks import Scope

    least = 200 if _valid_case(case) in _F16 else 10
    rate = max(least, 100) if rate is None else rate
    if integer("rate", rate, low=least) % 2:
        must_be("rate", rate, "even, because the reference has a point every 0.5 s")
    T = 1 / rate
    name = f"check_case_{_file_name(case)}"
    diagram = load_diagram(name, {"vehicle.T": T, "vehicle.integrators": integrators, "sim.dt": T})
    fly(diagram.sim, diagram.DURATION)
    return [block for block in diagram.sim.blocks if isinstance(block, Scope)]


def compare(case: float, *scopes: Scope) -> list[Deviation]:
    """Compare the recording of a check case with NASA's simulators.

    Parameters
    ----------
    case : float
        as in `fly_case`
    *scopes : pathsim.blocks.Scope
        with the diagram's signals; a flight that ended early is compared up to its end, with the
        band and limits of the complete run

    Returns
    -------
    list of Deviation
        one for each ``quantity``, with its ``unit``: ``worst``, the maximum distance from the
        median of the simulators, and their ``band``; ``from_05`` and ``limit_05``, the distance
        from simulator 05 and its limit, or None; ``ratio`` and ``passes``; ``until``, the end of
        the comparison

    Raises
    ------
    ParameterError
        for a case that does not exist, a signal that is missing, or times that are not recorded
    """
    reference, table_05 = _reference(_valid_case(case)), _simulator_05(case)
    flown, flown_single = _flown(reference, scopes), _flown(table_05, scopes)
    until = float(flown["time_s"][-1])
    deviations = []
    for name, quantity in _quantities(case).items():
        median = reference[quantity.column]
        worst = abs(_distance(case, name, scopes, flown)).max()
        ratio, band, from_05 = 0.0, None, None
        if quantity.has_band:
            band = float(_band(case, quantity, reference).max())
            digits = _ROUNDING * max(1, abs(median).max())
            ratio = worst / (band * (1 + _ROUNDING_OF_SPREADS) + digits)
        if quantity.limit is not None:
            from_05 = float(abs(_distance(case, name, scopes, flown_single)).max())
            ratio = np.maximum(ratio, from_05 / quantity.limit)  # NaN stays NaN
        numbers = float(worst), band, from_05, quantity.limit, float(ratio)
        deviations.append(Deviation(name, quantity.unit, *numbers, until))
    return deviations


def _quantities(case: float) -> dict[str, _Quantity]:
    """The compared quantities: for the F-16 without rates and velocities, with its own limits."""
    if case not in _F16:
        return _QUANTITIES
    altitude, attitude = _F16[case]
    limits = {
        "altitude": altitude,
        "latitude": _F16_PLACE,
        "longitude": _F16_PLACE,
        "true airspeed": _F16_AIRSPEED,
        **dict.fromkeys(("roll angle", "pitch angle", "heading"), attitude),
    }
    return {
        name: replace(_QUANTITIES[name], limit=limit, has_band=name != "true airspeed")
        for name, limit in limits.items()
    }


def _band(case: float, quantity: _Quantity, reference: np.ndarray) -> np.ndarray:
    spread = "spread" if case in _F16 else "spread_but_worst"
    return reference[f"{quantity.column}_{spread}"] * _scale(case, quantity, reference)


def _scale(case: float, quantity: _Quantity, table: np.ndarray) -> Any:
    """Factor from a longitude difference to degrees along the parallel: cos(latitude)."""
    if case not in _F16 or quantity.column != "longitude_deg":
        return 1.0
    return np.cos(np.radians(table["latitude_deg"]))


def comparison_table(case: float, deviations: Sequence[Deviation]) -> str:
    """The deviations of a check case as text, one line for each quantity."""
    rows: list[tuple[str, ...]] = [
        ("", "", "from the", "band of", "from", "", ""),
        ("quantity", "unit", "median", "NASA's", "sim. 05", "limit", ""),
    ]
    for d in deviations:
        numbers = map(_short, (d.worst, d.band, d.from_05, d.limit_05))
        rows.append((d.quantity, d.unit, *numbers, "pass" if d.passes else "FAIL"))
    line = "  {:<15}{:<6}{:>10}{:>10}{:>10}{:>10}  {}"
    until, end = max(d.until for d in deviations), _reference(case)["time_s"][-1]
    part = f", until {until:g} s of {end:g} s" if until < end else ""
    headline = f"check case {case:g}: {CASES[case]}{part}"
    return "\n".join([headline, *(line.format(*row).rstrip() for row in rows)])


def comparison_figure(case: float, *scopes: Scope) -> Figure:
    """A flight in the limits of `compare`: distances from the simulators' median over time.

    The grey band is what `compare` allows: the maximum spread of the whole run, or for the F-16's
    airspeed its limit around simulator 05.

    Parameters
    ----------
    case : float
        as in `fly_case`
    *scopes : pathsim.blocks.Scope
        with the diagram's signals, as in `compare`

    Returns
    -------
    matplotlib.figure.Figure
        a panel for each quantity in which the simulators differ
    """
    from ..plots import subplots

    reference, table_05 = _reference(_valid_case(case)), _simulator_05(case)
    flown = _flown(reference, scopes)
    time = reference["time_s"]
    panels = {}
    for name, quantity in _quantities(case).items():
        rounding = _ROUNDING * max(1, abs(reference[quantity.column]).max())
        if _band(case, quantity, reference).max() > rounding:
            panels[name] = quantity
    rows = math.ceil(len(panels) / 2)
    figure, axes = subplots(
        rows, 2, sharex=True, squeeze=False, layout="constrained", figsize=(8, 1 + 1.7 * rows)
    )
    for ax, (name, quantity) in zip(axes.flat, panels.items(), strict=False):
        limits = np.full(len(time), _band(case, quantity, reference).max())
        centre = np.zeros(len(time))
        ax.plot(flown["time_s"], _distance(case, name, scopes, flown), label="this diagram")
        if quantity.limit is not None:
            at = np.searchsorted(time, table_05["time_s"])
            difference = table_05[quantity.column] - reference[quantity.column][at]
            # both angles may wrap around, their difference must not
            difference = _on_circle(quantity, difference) * _scale(case, quantity, table_05)
            ax.plot(table_05["time_s"], difference, "k:", label="simulator 05")
            if not quantity.has_band:  # compared with simulator 05 only
                limits[:] = quantity.limit
                centre = np.interp(time, table_05["time_s"], difference)
        low, high = centre - limits, centre + limits
        ax.fill_between(time, low, high, color="tab:gray", alpha=0.3, label="limits")
        ax.set_ylabel(f"{name}\n[{quantity.unit}]")
        ax.grid(alpha=0.4)
    *_, last, spare = axes.flat
    if len(panels) % 2:  # the last panel gets the whole row
        spare.set_visible(False)
        last.set_subplotspec(last.get_gridspec()[-1, :])
        for ax in axes[-2]:
            ax.tick_params(labelbottom=True)
    for ax in axes[-1]:
        ax.set_xlabel("time [s]")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    figure.suptitle(f"check case {case:g}: {CASES[case]}; distance from NASA's median")
    return figure


def _valid_case(case: Any) -> float:
    value = number("case", case)
    if value not in CASES:
        cases = ", ".join(f"{x:g}" for x in CASES)
        must_be("case", case, f"one of {cases}")
    return value


def _file_name(case: float) -> str:
    """The case in names of files: 01, 13_1."""
    return f"{case:g}".replace(".", "_").zfill(2)


@functools.cache
def _reference(case: float) -> np.ndarray:
    return np.genfromtxt(_DATA / f"nesc_{_file_name(case)}.csv", delimiter=",", names=True)


@functools.cache
def _simulator_05(case: float) -> np.ndarray:
    table = np.genfromtxt(_DATA / "nesc_sim05.csv", delimiter=",", names=True)
    return table[table["case"] == case]


def _flown(table: np.ndarray, scopes: Sequence[Scope]) -> np.ndarray:
    """The part of a table up to the end of the recording."""
    end = max((s.recording_time[-1] for s in scopes if s.recording_time), default=0.0)
    return table[table["time_s"] <= end + 1e-6]


def _distance(case: float, name: str, scopes: Sequence[Scope], table: np.ndarray) -> np.ndarray:
    """A recorded signal minus the values of a table, at the table's times."""
    from ..plots import signal

    scope = next((s for s in scopes if any(name in label for label in s.labels)), None)
    if scope is None:
        refuse("scopes", scopes, f"none of the scopes records the {name}")
    times, values = signal(scope, name)
    time = table["time_s"]
    at = np.minimum(np.searchsorted(times, time - 1e-6), len(times) - 1)
    missing = time[abs(times[at] - time) > 1e-6]
    if missing.size:
        why = f"the recording has no sample at t = {missing[0]:g} s, which the reference has"
        refuse("scope", scope, why)
    quantity = _QUANTITIES[name]
    difference = _on_circle(quantity, values[at] * quantity.per_signal - table[quantity.column])
    return difference * _scale(case, quantity, table)


def _on_circle(quantity: _Quantity, difference: np.ndarray) -> np.ndarray:
    turns = np.round(difference / 360.0) if quantity.unit == "deg" else 0.0
    return difference - 360.0 * turns


def _short(value: float | None) -> str:
    """Two digits; rounding errors as 0."""
    return "" if value is None else "0" if value <= 1e-12 else f"{value:.2g}"
