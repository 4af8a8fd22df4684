"""Flying qualities of a linear model by the limits of MIL-F-8785C."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .._core.checks import must_be, one_of
from .._core.units import GRAVITY
from .model import LinearModel

CLASSES = ("I", "II-L", "II-C", "III", "IV")
CATEGORIES = ("A", "B", "C")

# (minimum, maximum) for each level from 1
Limits = tuple[tuple[float, float], ...]
_INF = math.inf

# table IV, paragraph 3.2.2.1.2: damping ratios, above 1 for two real poles
_PRECISE, _GRADUAL = (
    ((0.35, 1.3), (0.25, 2.0), (0.15, _INF)),
    ((0.3, 2.0), (0.2, 2.0), (0.15, _INF)),
)
_SHORT_PERIOD_DAMPING: dict[str, Limits] = {"A": _PRECISE, "B": _GRADUAL, "C": _PRECISE}

# figures 1 to 3, paragraph 3.2.2.1.1: lines of constant omega^2 / (n/alpha), rad2/s2 per g/rad
_ANTICIPATION: dict[str, Limits] = {
    "A": ((0.28, 3.6), (0.16, 10.0), (0.16, _INF)),
    "B": ((0.085, 3.6), (0.038, 10.0), (0.038, _INF)),
    "C": ((0.16, 3.6), (0.096, 10.0), (0.096, _INF)),
}

# paragraph 3.2.1.2: damping ratio of levels 1 and 2, and s to double amplitude of level 3
_PHUGOID_DAMPING = (0.04, 0.0)
_PHUGOID_DOUBLE = 55.0

# table VIII, paragraph 3.3.1.3: s to double amplitude
_SPIRAL_DOUBLE = {"A": (12.0, 8.0, 4.0), "B": (20.0, 8.0, 4.0), "C": (12.0, 8.0, 4.0)}


@dataclass(frozen=True)
class Quality:
    """One requirement, with the value and level of the aircraft.

    Attributes
    ----------
    name : str
        required quantity
    paragraph : str
        of MIL-F-8785C
    value : float
        of the aircraft
    unit : str
        of the value
    level : int
        1 (clearly adequate), 2, 3, or 4: worse than the limits of level 3
    """

    name: str
    paragraph: str
    value: float
    unit: str
    level: int


def flying_qualities(
    model: LinearModel, category: str = "B", aircraft_class: str = "II-L"
) -> list[Quality]:
    """Levels of flying qualities of a model's modes.

    A short period of two real poles has the damping ratio and frequency of their sum and product.
    Requirements on modes that the aircraft lacks are left out, and so are the minimum
    frequency and n/alpha of figures 1 to 3 and the increment of Dutch roll damping for a large
    ratio of bank to sideslip.

    Parameters
    ----------
    model : LinearModel
        with the states of a rigid aircraft
    category : str
        flight phases: "A" demand rapid manoeuvres or precise tracking, "B" gradual manoeuvres
        (climb, cruise), "C" are take-off and landing
    aircraft_class : str
        "I" small and light, "II-L" medium (land-based), "II-C" medium (carrier-based), "III" large
        and heavy, "IV" highly manoeuvrable

    Returns
    -------
    list of Quality

    Raises
    ------
    ParameterError
        for an unknown category or class, or a model of another type

    References
    ----------
    MIL-F-8785C, "Flying Qualities of Piloted Airplanes", 5 November 1980: paragraphs 3.2.1.2,
    3.2.2.1, 3.3.1.1, 3.3.1.2 and 3.3.1.3.
    """
    if not isinstance(model, LinearModel):
        must_be("model", model, "a LinearModel, such as linear_model('c172p', ...)")
    one_of("category", category, CATEGORIES)
    one_of("aircraft_class", aircraft_class, CLASSES)
    modes = model.modes()
    oscillatory = {mode.name: mode for mode in modes if mode.oscillatory}
    real = {mode.name: mode for mode in modes if not mode.oscillatory}
    qualities: list[Quality] = []

    def add(name: str, paragraph: str, value: float, unit: str, level: int) -> None:
        qualities.append(Quality(name, paragraph, value, unit, level))

    # a pair of complex poles, or two real ones
    short = [mode.pole for mode in modes if mode.name == "short period"]
    both = [short[0], short[-1].conjugate()] if short else [0.0, 0.0]
    product = (both[0] * both[1]).real
    if product > 0.0:
        frequency = math.sqrt(product)
        damping = -0.5 * (both[0] + both[1]).real / frequency
        level = _within(damping, _SHORT_PERIOD_DAMPING[category])
        add("short-period damping ratio", "3.2.2.1.2", damping, "", level)
        anticipation = control_anticipation(model, frequency)
        if not math.isnan(anticipation):
            level = _within(anticipation, _ANTICIPATION[category])
            add("control anticipation parameter", "3.2.2.1.1", anticipation, "rad/s2 per g", level)
    if phugoid := oscillatory.get("phugoid"):
        level = 1 + sum(phugoid.damping < limit for limit in _PHUGOID_DAMPING)
        if level == 3 and phugoid.time_to_double < _PHUGOID_DOUBLE:
            level = 4
        add("phugoid damping ratio", "3.2.1.2", phugoid.damping, "", level)
    if dutch := oscillatory.get("Dutch roll"):
        levels = _dutch_roll(category, aircraft_class)
        values = (
            ("damping ratio", dutch.damping, ""),
            ("damping times frequency", -dutch.pole.real, "rad/s"),
            ("frequency", dutch.frequency, "rad/s"),
        )
        for i, (name, value, unit) in enumerate(values):
            level = _within(value, tuple((row[i], _INF) for row in levels))
            add(f"Dutch roll {name}", "3.3.1.1", value, unit, level)
    if roll := real.get("roll"):
        limits = _roll(category, aircraft_class)
        T = roll.time_constant
        level = _within(T, tuple((0.0, t) for t in limits))
        add("roll mode time constant", "3.3.1.2", T, "s", level)
    if spiral := real.get("spiral"):
        T = spiral.time_to_double
        level = 1 if math.isnan(T) else 1 + sum(t > T for t in _SPIRAL_DOUBLE[category])
        add("spiral time to double", "3.3.1.3", _INF if math.isnan(T) else T, "s", level)
    return qualities


def _within(value: float, limits: Sequence[tuple[float, float]]) -> int:
    """The first level whose limits contain a value."""
    return next((i for i, (low, high) in enumerate(limits, 1) if low <= value <= high), 4)


def _dutch_roll(category: str, aircraft_class: str) -> tuple[tuple[float, float, float], ...]:
    """Minimum damping ratio, product (rad/s), frequency (rad/s): table VI, paragraph 3.3.1.1."""
    nimble = aircraft_class in ("I", "II-C", "IV")
    if category == "A":
        first = (0.19, 0.35, 1.0 if aircraft_class in ("I", "IV") else 0.4)
    elif category == "B":
        first = (0.08, 0.15, 0.4)
    else:
        first = (0.08, 0.15, 1.0) if nimble else (0.08, 0.10, 0.4)
    return first, (0.02, 0.05, 0.4), (0.0, -_INF, 0.4)


def _roll(category: str, aircraft_class: str) -> tuple[float, float, float]:
    """Maximum time constant in s, table VII, paragraph 3.3.1.2."""
    nimble = {"A": ("I", "IV"), "B": (), "C": ("I", "II-C", "IV")}[category]
    return (1.0, 1.4, 10.0) if aircraft_class in nimble else (1.4, 3.0, 10.0)


def control_anticipation(model: LinearModel, frequency: float) -> float:
    """Control anticipation parameter, omega^2 / (n/alpha), in rad/s2 per g.

    ``frequency`` is omega of the short period in rad/s.

    n/alpha is taken from a steady pull-up at constant speed, V q / (g alpha), with the states
    alpha and q and those of the control system. NaN for a model without elevator.
    """
    fast = [i for i, name in enumerate(model.states) if name in ("alpha", "q") or name[0] == "x"]
    pitch = [i for i, name in enumerate(model.inputs) if "elevator" in name]
    if not pitch or not {"alpha", "q"} <= set(model.states):
        return math.nan
    try:
        x = np.linalg.solve(model.A[np.ix_(fast, fast)], model.B[fast, pitch[0]])
    except np.linalg.LinAlgError:
        return math.nan
    steady = dict(zip((model.states[i] for i in fast), x, strict=True))
    if not steady["alpha"]:
        return math.nan
    V = model.x0[model.states.index("vt")]
    load_factor_per_rad = V / GRAVITY * steady["q"] / steady["alpha"]
    return float(frequency**2 / load_factor_per_rad)
