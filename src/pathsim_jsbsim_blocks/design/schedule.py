"""Gains designed at several altitudes and airspeeds, and their file."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from .._core.checks import must_be, number, refuse
from ..control.gain_tables import write_gains
from ..control.gains import DesignPoint, GainSchedule
from ..errors import DesignError, TrimError
from ..flight import TrimCondition
from ..flight.options import AircraftOptions
from ..flight.trimming.condition import check_condition
from .designed import DesignedGains, check_near, check_options, design_gains
from .search import LoopReport

if TYPE_CHECKING:
    from typing_extensions import Unpack


class DesignOptions(AircraftOptions, total=False):
    """Parameters of each design, as of `design_gains`."""

    method: Literal["flown", "algebraic"]
    T: float
    substeps: int
    check: bool


@dataclass(frozen=True)
class DesignedSchedule:
    """Result of `design_schedule`.

    Attributes
    ----------
    designs : tuple of DesignedGains
        sorted by altitude, then by airspeed
    nominal : int
        index of the design for holds without an airspeed
    refused : tuple of (TrimCondition, Exception)
        conditions without gains, and the error of each
    """

    designs: tuple[DesignedGains, ...]
    nominal: int
    refused: tuple[tuple[TrimCondition, Exception], ...]

    @property
    def schedule(self) -> GainSchedule:
        """The gains over altitude and airspeed, for ``gains=`` of every hold."""
        return GainSchedule(
            aircraft=self.designs[0].aircraft,
            points=tuple(
                DesignPoint(d.condition.altitude, d.condition.speed, d.gains) for d in self.designs
            ),
            nominal=self.nominal,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write a gain table that ``gains="PATH.json"`` reads, with the report of each design.

        Numbers are rounded to 6 significant digits.

        Raises
        ------
        ParameterError
            for an ending other than .json
        FileError
            if the file cannot be written; an existing one is left unchanged
        """
        condition = replace(self.designs[self.nominal].condition, speed=1.0, altitude=0)
        text = str(condition).replace("altitude=0.0, ", "").replace("speed=1.0, ", "")
        write_gains(
            path,
            self.schedule,
            {"versions": {"jsbsim": version("jsbsim")}, "condition": text},
            [{row.loop: _plain(row) for row in d.report} for d in self.designs],
        )


def _plain(row: LoopReport) -> dict[str, Any]:
    """A row of a report without its name and without NaN and infinity, which JSON lacks."""
    numbers = {k: x for k, x in vars(row).items() if isinstance(x, float) and math.isfinite(x)}
    return numbers | ({"relaxed": row.relaxed} if row.relaxed else {})


def _sorted(name: str, values: Any, **bounds: Any) -> list[float]:
    """Checked numbers without repetition, in ascending order."""
    if np.asarray(values, dtype=object).ndim != 1:
        must_be(name, values, "a list of numbers")
    numbers = sorted({number(name, value, **bounds) for value in values})
    if not numbers:
        refuse(name, values, f"{name} must have at least one number")
    return numbers


def design_schedule(
    aircraft: str,
    condition: TrimCondition,
    altitudes: Sequence[float],
    speeds: Sequence[float],
    *,
    progress: Callable[[DesignedGains | Exception], None] | None = None,
    near: Sequence[DesignedGains] = (),
    **options: Unpack[DesignOptions],
) -> DesignedSchedule:
    """Design gains at each of some altitudes and airspeeds.

    The first design is the one nearest to ``condition``; the search of each further one prefers
    gains close to its neighbours' among those of equal quality. Conditions at which the aircraft
    does not trim or no gains hold it are omitted; the holds interpolate between the others. A hold
    without an airspeed uses the gains nearest to ``condition``.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition
        all but altitude and airspeed: gear, flaps, fuel
    altitudes : list of float
        ft
    speeds : list of float
        KCAS
    progress : callable, optional
        called with each design, or with its error
    near : list of DesignedGains, optional
        designs at further altitudes and airspeeds, as neighbours of the new ones
    **options
        ``method``, ``T``, ``substeps`` and ``check`` as of `design_gains`, and the options of the
        aircraft that it has

    Raises
    ------
    DesignError, TrimError
        if no condition has gains: the first error
    ParameterError
        for an empty list, a value out of range, a Mach number, or an unknown option
    """
    check_options(design_schedule, options, DesignOptions)
    check_condition(condition)
    check_near(near, DesignedGains)
    if progress is not None and not callable(progress):
        must_be("progress", progress, "callable")
    if condition.mach is not None:
        refuse(
            "mach",
            condition.mach,
            "a schedule is over the calibrated airspeed: set speeds instead of mach",
        )
    levels = _sorted("altitudes", altitudes)
    airspeeds = _sorted("speeds", speeds, above=0.0)
    conditions = [replace(condition, altitude=h, speed=vc) for h in levels for vc in airspeeds]
    designs: list[DesignedGains] = []
    refusals: list[tuple[TrimCondition, Exception]] = []
    # from the nominal condition outwards, so that each point has a neighbour
    for point in sorted(conditions, key=lambda point: _distance(point, condition)):
        outcome: DesignedGains | Exception
        try:
            previous = [*near, *designs]
            # any design has the airspeed loop of all
            neighbours = _neighbours(previous, point) or previous[:1]
            outcome = design_gains(aircraft, point, near=neighbours, **options)
            designs.append(outcome)
        except (DesignError, TrimError) as error:
            outcome = error
            refusals.append((point, error))
        if progress is not None:
            progress(outcome)
    if not designs:
        raise refusals[0][1]
    first = designs[0]
    designs.sort(key=lambda design: (design.condition.altitude, design.condition.speed))
    return DesignedSchedule(tuple(designs), designs.index(first), tuple(refusals))


def _distance(a: TrimCondition, b: TrimCondition) -> float:
    """Measure of the difference in airspeed and altitude between two conditions."""
    altitude = abs(a.altitude - b.altitude) / 1e5
    return abs(math.log(a.speed / b.speed)) + altitude


def _neighbours(designs: Sequence[DesignedGains], point: TrimCondition) -> list[DesignedGains]:
    """The next designs at lower and higher airspeed, and at lower and higher altitude."""
    neighbours = []
    for axis, across_axis in (("altitude", "speed"), ("speed", "altitude")):
        value = getattr(point, across_axis)
        row = [d for d in designs if getattr(d.condition, axis) == getattr(point, axis)]
        lower = [d for d in row if getattr(d.condition, across_axis) < value]
        higher = [d for d in row if getattr(d.condition, across_axis) > value]
        neighbours += sorted(lower, key=lambda d: -getattr(d.condition, across_axis))[:1]
        neighbours += sorted(higher, key=lambda d: getattr(d.condition, across_axis))[:1]
    return neighbours
