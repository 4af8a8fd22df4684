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
    """What `design_schedule` has found.

    Attributes
    ----------
    designs : tuple of DesignedGains
        sorted by altitude, then by airspeed
    nominal : int
        index of the design for holds that do not know the airspeed
    refused : tuple of (TrimCondition, Exception)
        conditions without gains, and why
    """

    designs: tuple[DesignedGains, ...]
    nominal: int
    refused: tuple[tuple[TrimCondition, Exception], ...]

    @property
    def schedule(self) -> GainSchedule:
        """The gains over altitude and airspeed, which ``gains=`` of every hold takes."""
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
        told = str(condition).replace("altitude=0.0, ", "").replace("speed=1.0, ", "")
        write_gains(
            path,
            self.schedule,
            {"versions": {"jsbsim": version("jsbsim")}, "condition": told},
            [{row.loop: _plain(row) for row in d.report} for d in self.designs],
        )


def _plain(row: LoopReport) -> dict[str, Any]:
    """A row of a report without its name and without numbers that JSON lacks."""
    numbers = {k: x for k, x in vars(row).items() if isinstance(x, float) and math.isfinite(x)}
    return numbers | ({"relaxed": row.relaxed} if row.relaxed else {})


def _sorted(name: str, values: Any, **bounds: Any) -> list[float]:
    """Checked numbers without repetition, in ascending order."""
    if np.asarray(values, dtype=object).ndim != 1:
        must_be(name, values, "a list of numbers")
    found = sorted({number(name, value, **bounds) for value in values})
    if not found:
        refuse(name, values, f"{name} is empty")
    return found


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

    The first design is the one nearest to ``condition``; each further one keeps to the gains of its
    neighbours as far as it is no worse for it. Conditions at which the aircraft does not trim or
    cannot be held are left out. Between the others the holds interpolate. A hold that does not know
    the airspeed takes those nearest to ``condition``.

    Parameters
    ----------
    aircraft : str
        name of the JSBSim model
    condition : TrimCondition
        everything but altitude and airspeed: gear, flaps, fuel
    altitudes : list of float
        ft
    speeds : list of float
        KCAS
    progress : callable, optional
        gets each design, or the error instead
    near : list of DesignedGains, optional
        designs of further altitudes and airspeeds, as neighbours of those to be found
    **options
        ``method``, ``T``, ``substeps`` and ``check`` as of `design_gains`, and the options of the
        aircraft that it has

    Raises
    ------
    DesignError, TrimError
        if there are gains at no condition: the first error
    ParameterError
        for no altitude, no airspeed, a value that cannot be, a Mach number, or an unknown option
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
            "a schedule is over the calibrated airspeed: give speeds instead of mach",
        )
    levels = _sorted("altitudes", altitudes)
    airspeeds = _sorted("speeds", speeds, above=0.0)
    conditions = [replace(condition, altitude=h, speed=vc) for h in levels for vc in airspeeds]
    designs: list[DesignedGains] = []
    refused: list[tuple[TrimCondition, Exception]] = []
    for there in sorted(conditions, key=lambda there: _away(there, condition)):
        found: DesignedGains | Exception
        try:
            before = [*near, *designs]
            # the airspeed loop is that of any
            beside = _neighbours(before, there) or before[:1]
            found = design_gains(aircraft, there, near=beside, **options)
            designs.append(found)
        except (DesignError, TrimError) as error:
            found = error
            refused.append((there, error))
        if progress is not None:
            progress(found)
    if not designs:
        raise refused[0][1]
    first = designs[0]
    designs.sort(key=lambda design: (design.condition.altitude, design.condition.speed))
    return DesignedSchedule(tuple(designs), designs.index(first), tuple(refused))


def _away(there: TrimCondition, condition: TrimCondition) -> float:
    """How far a condition is from another one."""
    apart = abs(there.altitude - condition.altitude) / 1e5
    return abs(math.log(there.speed / condition.speed)) + apart


def _neighbours(designs: Sequence[DesignedGains], there: TrimCondition) -> list[DesignedGains]:
    """The next designs at lower and higher airspeed, and at lower and higher altitude."""
    found = []
    for same, other in (("altitude", "speed"), ("speed", "altitude")):
        here = getattr(there, other)
        row = [d for d in designs if getattr(d.condition, same) == getattr(there, same)]
        below = [d for d in row if getattr(d.condition, other) < here]
        above = [d for d in row if getattr(d.condition, other) > here]
        found += sorted(below, key=lambda d: -getattr(d.condition, other))[:1]
        found += sorted(above, key=lambda d: getattr(d.condition, other))[:1]
    return found
