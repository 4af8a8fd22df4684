"""Gain tables: JSON files, and the other values of the holds' parameter ``gains``."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import reprlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from .._core.checks import did_you_mean, nearest, refuse
from .._core.files import as_path, ending, write_whole
from ..errors import FileError, ParameterError
from .airspeeds import true_airspeed
from .gains import LOOPS, OPTIONAL, AircraftGains, DesignPoint, GainSchedule

FORMAT = "pathsim-jsbsim-blocks gains 1"
# designed, and three that were tuned by hand on the nonlinear aircraft in still air
TABLES = Path(__file__).parent / "tables"
_DIGITS = 6
_LANDING = ("landing", "no_landing")


def loop_gains(gains: Any, *loops: str) -> tuple[Any, ...]:
    """The gains of some loops, from a table, a file or numbers; of a schedule the nominal point's.

    Parameters
    ----------
    gains : str, AircraftGains, GainSchedule, dict, or the gains of the loop
        a name among `tables`, or the path of a file that ends in ".json"; or, for one loop, its
        gains or a dict of their values; or, for several, a dict from the loop's name to any of
        these
    *loops : str
        "pitch", "roll", "heading", "altitude", "speed", "yaw", or "envelope", which is None if
        absent

    Raises
    ------
    ParameterError
        for an unknown table, loop or gain, naming the nearest, and for a missing one
    FileError
        for a file that cannot be read
    """
    if isinstance(gains, str):
        gains = table(gains)
    if isinstance(gains, GainSchedule):
        gains = gains.points[gains.nominal].gains
    if isinstance(gains, AircraftGains):
        for loop in loops:
            if loop != "envelope" and getattr(gains, loop) is None:
                why = f"these gains lack the loop {loop!r}: the aircraft has no engine"
                refuse("gains", gains, why)
        return tuple(getattr(gains, loop) for loop in loops)
    if len(loops) == 1:
        return (_one_loop(gains, loops[0]),)
    if not isinstance(gains, Mapping):
        refuse(
            "gains",
            gains,
            f"gains must be the name of a table or a dict of the gains of {', '.join(loops)}, "
            f"not {reprlib.repr(gains)}{_instead(gains)}",
        )
    _check_keys(gains, loops, [loop for loop in loops if loop != "envelope"], "loop")
    return tuple(loop_gains(gains[loop], loop)[0] if loop in gains else None for loop in loops)


def schedule_of(gains: Any) -> GainSchedule | None:
    """The schedule given by ``gains``; None for gains that do not depend on the airspeed."""
    schedule = named(gains)
    return schedule if schedule and len(schedule.points) > 1 else None


def named(gains: Any) -> GainSchedule | None:
    """The table given by ``gains``, even with a single point; None for other gains."""
    if isinstance(gains, str):
        gains = table(gains)
    return gains if isinstance(gains, GainSchedule) else None


def slowest(gains: Any) -> float | None:
    """True airspeed in ft/s of the slowest design point of gains; None if they have no points."""
    schedule = named(gains)
    if schedule is None:
        return None
    return min(true_airspeed(point.speed, point.altitude) for point in schedule.points)


def tables() -> list[str]:
    """Names of the gain tables that come with this package."""
    return sorted(path.stem for path in TABLES.glob("*.json"))


def table(name: str) -> GainSchedule:
    """The gains of a table of this package, or of a file that ends in ".json".

    Raises
    ------
    ParameterError
        for an unknown name, naming the nearest, and for a file that is not a gain table
    FileError
        for a file that cannot be read
    """
    if name.lower().endswith(".json"):
        return read_gains(name)
    names = tables()
    if name not in names:
        close = did_you_mean(nearest(name, names, 1))
        why = f"there is no gain table {name!r}{close or '.'} Gains of any aircraft come from "
        why += "design.design_gains, or from a file that ends in .json; tables: "
        refuse("gains", name, f"{why}{', '.join(names)}")
    return read_gains(TABLES / f"{name}.json")


def read_gains(path: str | Path) -> GainSchedule:
    """The gain schedule in a file written by ``pathsim-jsbsim gains``.

    Raises
    ------
    ParameterError
        if the file is not a gain table, or a gain is missing, unknown (naming the nearest) or
        invalid
    FileError
        if the file cannot be read
    """
    path = Path(path)
    try:
        time_of_change = path.stat().st_mtime_ns
    except OSError as cause:
        neighbours = [file.name for file in path.parent.glob("*.json")]
        close = nearest(path.name, [*neighbours, *tables()], 1)
        raise FileError("read", path, cause, did_you_mean(close)) from cause
    except ValueError as cause:  # a null character
        refuse("gains", str(path), f"{str(path)!r} is not a path: {cause}")
    return _read(path.absolute(), time_of_change)


@functools.lru_cache(maxsize=64)
def _read(path: Path, time_of_change: int) -> GainSchedule:
    try:
        document = json.loads(path.read_text(encoding="utf-8"))
    except OSError as cause:
        raise FileError("read", path, cause) from cause
    except (ValueError, RecursionError) as cause:
        refuse("gains", str(path), f"{path} is not a JSON file: {cause}")
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        refuse("gains", str(path), f"{path} is not a gain table: its format must be {FORMAT!r}")
    try:
        return schedule_from(document)
    except ParameterError as error:
        refuse(error.parameter, error.value, f"{path}: {error}")
    except (KeyError, TypeError) as cause:
        refuse("gains", str(path), f"{path} is not a complete gain table: {cause!r}")


def schedule_from(document: Mapping[str, Any]) -> GainSchedule:
    """The gain schedule in a document written by `document_of`."""
    return GainSchedule(
        aircraft=document["aircraft"],
        points=tuple(
            DesignPoint(
                altitude=point["altitude"],
                speed=point["speed"],
                gains=_all_loops({**point["gains"]}),
            )
            for point in document["points"]
        ),
        nominal=document["nominal"],
        **{name: str(document.get(name, "")) for name in _LANDING},
    )


def _all_loops(gains: dict[str, Any]) -> AircraftGains:
    """The gains of an aircraft from those of its loops by name."""
    loops = [loop for loop in LOOPS if loop in gains or loop not in OPTIONAL]
    values = zip(loops, loop_gains(gains, *loops), strict=True)
    return AircraftGains(**{**dict.fromkeys(OPTIONAL), **dict(values)})


def document_of(schedule: GainSchedule) -> dict[str, Any]:
    """A gain schedule as plain data, in the format of gain table files.

    Further keys, of the document (such as "versions" and "condition") and of its "points" (such as
    "report"), are ignored when a file is read.
    """
    return {
        "format": FORMAT,
        "aircraft": schedule.aircraft,
        "nominal": schedule.nominal,
        **{name: getattr(schedule, name) for name in _LANDING},
        "points": [
            {
                "altitude": point.altitude,
                "speed": point.speed,
                "gains": {
                    loop: dict(vars(gains))
                    for loop, gains in vars(point.gains).items()
                    if gains is not None
                },
            }
            for point in schedule.points
        ],
    }


def write_gains(
    path: str | os.PathLike[str],
    schedule: GainSchedule,
    about: Mapping[str, Any],
    reports: Sequence[Any],
) -> None:
    """Write a gain table with 6 significant digits, to a path that ends in .json.

    ``about`` are further keys of the document, ``reports`` has one report per point, for readers.
    If the file cannot be written (`FileError`), an existing one is left unchanged.
    """
    file = ending("path", as_path("path", path), ".json")
    document = document_of(schedule)
    points = document.pop("points")
    for point, report in zip(points, reports, strict=True):
        point["report"] = report
    # a line for each point
    head = json.dumps(_rounded({**document, **about}))[:-1] + ', "points": ['
    rows = ",\n".join(json.dumps(_rounded(point), allow_nan=False) for point in points)
    write_whole(file, f"{head}\n{rows}\n]}}\n")


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, dict):
        return {name: _rounded(x) for name, x in value.items()}
    return [_rounded(x) for x in value] if isinstance(value, list) else value


def _one_loop(gains: Any, loop: str) -> Any:
    kind = LOOPS[loop]
    if isinstance(gains, kind):
        return gains
    if not isinstance(gains, Mapping):
        refuse(
            "gains",
            gains,
            f"{loop} gains must be the name of a table, {kind.__name__} or a dict, "
            f"not {reprlib.repr(gains)}{_instead(gains)}",
        )
    fields = dataclasses.fields(kind)
    required_names = [f.name for f in fields if f.default is dataclasses.MISSING]
    _check_keys(gains, [f.name for f in fields], required_names, f"{loop} gain")
    return kind(**gains)


def _instead(gains: Any) -> str:
    """Suggestion instead of a path, or of a result of `design_schedule`."""
    if isinstance(gains, os.PathLike):
        return did_you_mean([os.fspath(gains)])
    if isinstance(getattr(gains, "schedule", None), GainSchedule):
        return "; did you mean its attribute 'schedule'?"
    return ""


def _check_keys(gains: Mapping, names: Any, required_names: Any, what: str) -> None:
    for name in gains:
        if name not in names:
            refuse(
                "gains",
                gains,
                f"there is no {what} {name!r}; available: {', '.join(names)}"
                + did_you_mean(nearest(str(name), names, 1)),
            )
    missing = [name for name in required_names if name not in gains]
    if missing:
        refuse("gains", gains, f"{what} missing: {', '.join(missing)}")
