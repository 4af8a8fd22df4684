"""The engine fails after take-off: straight ahead, or a turn back to the runway."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core.extras import required
from ..plots import subplots
from .futures import branch

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

INSTANTS = range(10, 90, 10)  # s after the screen height

# direction of the turn by the way taken
WAYS = {"straight ahead": 0.0, "left turn": -1.0, "right turn": 1.0}

_RUNWAY = 2500.0  # ft, drawn


def engine_failure(*, jobs: int = -1, progress: bool = True) -> pd.DataFrame:
    """Glides of a Cessna 172 whose engine fails after take-off: ahead, or back to the runway.

    A c172p climbs at 75 KCAS and full throttle in a crosswind of 10 kt from the left. At eight
    instants its engine fails, and from each the same flight goes on three ways (`branch`):
    straight ahead, and after a turn to the left or to the right, with 45 deg of bank at 68 KCAS, to
    the end of the runway. The pilot reacts after 4 s. The glide goes on below the height of the
    runway, so that a negative height at the threshold shows how much is missing.

    Parameters
    ----------
    jobs : int
        copies of the process at the same time, -1 for one on each core
    progress : bool
        show a progress bar on stderr

    Returns
    -------
    pandas.DataFrame
        a row for each half second of each glide: ``failure_s`` after the screen height of 50 ft,
        ``way``, ``time_s``, ``north_ft`` and ``east_ft`` from the end of the runway, ``height_ft``
        above it, ``speed_kcas``, ``distance_ft`` to its end

    Raises
    ------
    BranchError
        on a system without fork (Windows)
    """
    from tqdm import tqdm

    from .take_off import TakeOff  # loads PathSim

    pd = required("pandas", "studies")
    flight, rows = TakeOff.build(), list[dict[str, Any]]()
    for time in tqdm(INSTANTS, desc="engine_failure", unit=" failures", disable=not progress):
        flight.until(time)
        glides = branch([partial(flight.glide, side) for side in WAYS.values()], jobs)
        for way, glide in zip(WAYS, glides, strict=True):
            rows += [{"failure_s": time, "way": way, **row} for row in glide]
    return pd.DataFrame(rows)


def engine_failure_chart(table: pd.DataFrame, title: str = "") -> Figure:
    """Ground tracks of the glides, and the height at the threshold.

    Parameters
    ----------
    table : DataFrame
        of `engine_failure`
    title : str
        headline
    """
    from matplotlib import colormaps

    figure, (tracks, heights) = subplots(
        2, 1, figsize=(9, 8), layout="constrained", height_ratios=(1, 1.2)
    )
    back = table[table.way != "straight ahead"]
    times = list(table.failure_s.unique())
    colours = dict(zip(times, colormaps["viridis"](np.linspace(0.0, 0.9, len(times))), strict=True))
    for (time, _), glide in table.groupby(["failure_s", "way"], sort=False):
        at = glide[["east_ft", "north_ft"]] / 1000.0
        tracks.plot(at.east_ft, at.north_ft, color=colours[time], linewidth=1.2)
        tracks.plot(at.east_ft.iloc[0], at.north_ft.iloc[0], "o", color=colours[time], markersize=4)
    tracks.plot(
        [-_RUNWAY / 1000.0, 0.0], [0.0, 0.0], color="0.5", linewidth=6, solid_capstyle="butt"
    )
    tracks.annotate("runway", (-_RUNWAY / 1000.0, 0.12), fontsize="small")
    tracks.set(xlabel="east of the runway's end [1000 ft]", ylabel="north [1000 ft]")
    # the glides straight ahead go on
    tracks.set_xlim(-1.2 * _RUNWAY / 1000.0, 1.3 * back.east_ft.max() / 1000.0)
    for way, marker in zip([way for way, side in WAYS.items() if side], "<>", strict=True):
        glides = table[table.way == way].groupby("failure_s")
        heights.plot(
            glides.height_ft.first(),
            glides.height_ft.last(),
            f"{marker}-",
            label=f"{way} (45 deg of bank)",
        )
    heights.axhline(0.0, color="k", linewidth=1.0)
    heights.set(xlabel="height of the failure [ft]", ylabel="height at the threshold [ft]")
    heights.legend(loc="lower right", fontsize="small")
    for ax in (tracks, heights):
        ax.grid(alpha=0.4)
    figure.suptitle(title or "c172p: engine failure after take-off, wind 10 kt from the left")
    return figure
