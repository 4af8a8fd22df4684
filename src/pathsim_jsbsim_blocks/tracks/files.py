"""Write tracks to a file, in the format of its ending."""

from __future__ import annotations

import contextlib
import datetime
import os
import platform
import reprlib
from collections.abc import Callable, Iterable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.checks import must_be, refuse
from .._core.extras import required
from .._core.files import ending, replacing, writable
from .acmi import write_acmi
from .kml import write_kml
from .report import write_report
from .track import Track

if TYPE_CHECKING:
    import pandas


def _table(tracks: Sequence[Track]) -> pandas.DataFrame:
    """A row for each sample; with several aircraft, the first column is the aircraft's name."""
    if len(tracks) == 1:
        return tracks[0].to_frame()
    pandas = required("pandas", "tracks")
    return pandas.concat({track.name: track.to_frame() for track in tracks}, names=["aircraft"])


def _write_csv(path: Path, tracks: Sequence[Track], start: Any, about: str) -> None:
    _table(tracks).to_csv(path, lineterminator="\n")


def _write_parquet(path: Path, tracks: Sequence[Track], start: Any, about: str) -> None:
    _table(tracks).to_parquet(path)


# by ending: the writer and the packages that it needs
_FORMATS: dict[str, tuple[Callable[..., None], tuple[str, ...]]] = {
    ".csv": (_write_csv, ("pandas",)),
    ".parquet": (_write_parquet, ("pandas", "pyarrow")),
    ".acmi": (write_acmi, ()),
    ".kml": (write_kml, ()),
    ".html": (write_report, ("plotly",)),
}

# noon at the equinox, so that a globe with sunlight shows the flight by day
_START = datetime.datetime(2024, 3, 20, 12, tzinfo=datetime.timezone.utc)


def track_file(parameter: str, path: Any) -> Path:
    """``path`` if tracks can be written there."""
    path = ending(parameter, writable(parameter, path), *_FORMATS)
    for package in _FORMATS[path.suffix.lower()][1]:
        required(package, "tracks")
    return path


def save_tracks(
    path: str | os.PathLike[str],
    tracks: Track | Sequence[Track],
    start: datetime.datetime | None = None,
) -> None:
    """Write the flights of one or more aircraft to a file.

    Parameters
    ----------
    path : str or Path
        ``.csv`` or ``.parquet`` (a table), ``.acmi`` (Tacview), ``.kml`` (Google Earth) or
        ``.html`` (a report that opens in any browser, without a network). A ``.kml`` of tracks of
        all steps of a simulation has 5 points per second, fewer above 5 MB
    tracks : Track or list of Track
        the aircraft
    start : datetime, optional
        date and time of t = 0, for formats with a date; without a time zone it is UTC.
        Default is 2024-03-20 12:00 UTC

    Raises
    ------
    ParameterError
        for an unknown ending, no tracks, two of the same name, or dates beyond year 9999
    MissingExtraError
        if the format needs a package of the extra ``tracks`` that is not installed
    FileError
        if the file cannot be written; an existing one is left unchanged
    """
    path = track_file("path", path)
    tracks = list(tracks) if isinstance(tracks, Iterable) else [tracks]
    for track in tracks:
        if not isinstance(track, Track):
            why = f"tracks must be one Track or a list of them, not {reprlib.repr(track)}"
            refuse("tracks", track, why)
    names = [track.name for track in tracks]
    if not tracks or len(set(names)) != len(names):
        refuse("tracks", names, f"tracks must be one or more with different names, not {names}")
    start = _START if start is None else _utc(start)
    write, _ = _FORMATS[path.suffix.lower()]
    try:
        # a number beyond the range of a format becomes infinite
        with replacing(path) as file, np.errstate(over="ignore", invalid="ignore"):
            write(file, tracks, start, _versions())
    except OverflowError:
        why = f"the dates of the flight, which starts at {start}, end after the year 9999"
        refuse("start", start, why)


def _utc(start: Any) -> datetime.datetime:
    try:
        date = datetime.datetime.combine(start.date(), start.timetz())
        if date.utcoffset() is None:
            return date.replace(tzinfo=datetime.timezone.utc)
        return date.astimezone(datetime.timezone.utc)
    except (AttributeError, TypeError, ValueError, OverflowError):
        must_be("start", start, "a datetime between the years 1 and 9999 in UTC")


def _versions() -> str:
    versions = [f"Python {platform.python_version()}"]
    for package in ("pathsim", "jsbsim", "pathsim-jsbsim-blocks"):
        with contextlib.suppress(PackageNotFoundError):
            versions.insert(0, f"{package} {version(package)}")
    return ", ".join(versions)
