"""A flight report: one page that shows the track, the attitude and the time histories.

``report.html`` is the page. Its data are samples as 32-bit numbers in base64, distances in metres
east, north and up of the first sample; plotly.js is part of the file, so no network is needed.
"""

from __future__ import annotations

import base64
import datetime
import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .._core.scopes import name_and_unit
from .._core.units import FOOT
from .track import Track

# samples of one aircraft; a page with more reacts slowly
_MOST = 20_000


def write_report(path: Path, tracks: Sequence[Track], start: datetime.datetime, about: str) -> None:
    """Write the page with all aircraft; long flights are thinned out to 20,000 samples."""
    from plotly.offline import get_plotlyjs
    from pymap3d import geodetic2enu

    samples = [track.at_most(_MOST) for track in tracks]
    origin = samples[0].lat[0], samples[0].lon[0], samples[0].h[0] * FOOT
    places = [np.array(geodetic2enu(x.lat, x.lon, x.h * FOOT, *origin)) for x in samples]
    aircraft = [_aircraft(*both) for both in zip(samples, places, strict=True)]
    head = {}
    for track in tracks:  # with one aircraft, its name is in the title
        kind = [track.aircraft] * (track.aircraft != track.name)
        head[track.name if tracks[1:] else "flight"] = [*kind, *map(" ".join, track.about.items())]
    head |= {"t = 0": [f"{start:%Y-%m-%d %H:%M:%S %Z}"], "made by": [about]}
    if any(len(track.time) > _MOST for track in tracks):
        head["samples"] = [f"thinned out to {_MOST:,} for each aircraft"]
    rows = [(html.escape(k), html.escape(", ".join(v))) for k, v in head.items()]
    page = Path(__file__).with_name("report.html").read_text(encoding="utf-8")
    for place, text in {
        "TITLE": html.escape(", ".join(track.name for track in tracks)),
        "HEAD": "".join(f"<dt>{k}</dt><dd>{v}</dd>" for k, v in rows),
        # no "</script>" may end the element
        "DATA": json.dumps({"aircraft": aircraft, "boxes": _boxes(places)}).replace("<", "\\u003c"),
        "PLOTLY": get_plotlyjs(),
    }.items():
        page = page.replace(f"<!--{place}-->", text)
    path.write_text(page, encoding="utf-8", newline="\n")


def _boxes(places: Sequence[np.ndarray]) -> list[list[float]]:
    """Ranges of the axes east, north and up; a level track gets some height, most of it above."""
    low, high = (f([f(place, axis=1) for place in places], axis=0) for f in (np.min, np.max))
    half = np.maximum(0.6 * (high - low), 0.2 * max(np.max(high - low), 100.0))
    ends = np.where([0, 0, 1], low - 0.2 * half, (low + high) / 2 - half)
    return np.column_stack([ends, ends + 2.0 * half]).tolist()


def _aircraft(track: Track, place: np.ndarray) -> dict[str, Any]:
    signals = []
    for label, column in track.columns.items():
        name, unit = name_and_unit(label)
        if name == "heading":  # remove the jumps at north
            column = np.unwrap(column, period=360)
        if name not in ("latitude", "longitude"):
            signals.append({"name": name, "unit": unit, "values": _packed(column)})
    columns = {name: getattr(track, name) for name in ("time", "theta", "phi", "psi")}
    columns |= dict(zip(("east", "north", "up"), place, strict=True))
    texts = {name: _packed(column) for name, column in columns.items()}
    return {"name": track.name, **texts, "signals": signals}


def _packed(column: Any) -> str:
    return base64.b64encode(np.asarray(column, dtype="<f4").tobytes()).decode("ascii")
