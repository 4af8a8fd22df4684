"""Recorded signals as tables: pandas, CSV, Parquet."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING

from .._core.extras import required
from .._core.scopes import recording, signal_label
from .track import Track, frame

if TYPE_CHECKING:
    import pandas
    from pathsim.blocks import Scope


def to_frame(scope: Scope) -> pandas.DataFrame:
    """What a scope has recorded as a pandas table; its labels are the columns' names.

    Parameters
    ----------
    scope : pathsim.blocks.Scope
        with recorded data

    Returns
    -------
    pandas.DataFrame
        one column for each signal; the index is the time in s

    Raises
    ------
    ParameterError
        if nothing was recorded
    MissingExtraError
        without pandas
    """
    time, data = recording(scope)
    return frame(time, {signal_label(scope, i): values for i, values in enumerate(data)})


def write_csv(path: Path, tracks: Sequence[Track], start: datetime, about: str) -> None:
    """One row for each sample; with several aircraft, the first column is the aircraft's name."""
    _table(tracks).to_csv(path, lineterminator="\n")


def write_parquet(path: Path, tracks: Sequence[Track], start: datetime, about: str) -> None:
    """The table of `write_csv` as Parquet."""
    _table(tracks).to_parquet(path)


def _table(tracks: Sequence[Track]) -> pandas.DataFrame:
    if len(tracks) == 1:
        return tracks[0].to_frame()
    pandas = required("pandas", "tracks")
    return pandas.concat({track.name: track.to_frame() for track in tracks}, names=["aircraft"])
