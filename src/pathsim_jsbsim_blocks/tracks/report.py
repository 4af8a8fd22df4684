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

_PAGE = Path(__file__).with_name("report.html")

# a page with more samples of an aircraft than these reacts slowly
_MOST = 20_000


def write_report(path: Path, tracks: Sequence[Track], start: datetime.datetime, about: str) -> None:
    """The page with all aircraft; long flights are thinned out to 20,000 samples."""
    from plotly.offline import get_plotlyjs

    shown = [track.thinned(_MOST) for track in tracks]
    origin = shown[0].lat[0], shown[0].lon[0], shown[0].h[0] * FOOT
    data = {"aircraft": [_aircraft(track, origin) for track in shown]}
    title = ", ".join(track.name for track in tracks)
    head = []
    for track in tracks:
        flown = [track.aircraft, *(f"{k} {v}" for k, v in track.about.items())]
        name = "aircraft" if track.aircraft == track.name else track.name
        head.append((name, ", ".join(flown)))
    head += [("t = 0", f"{start:%Y-%m-%d %H:%M:%S %Z}"), ("made by", about)]
    if any(len(track.time) > _MOST for track in tracks):
        head.append(("samples", f"thinned out to {_MOST:,} for each aircraft"))
    page = _PAGE.read_text(encoding="utf-8")
    for place, text in {
        "TITLE": html.escape(title),
        "HEAD": "".join(f"<dt>{html.escape(k)}</dt><dd>{html.escape(v)}</dd>" for k, v in head),
        # no "</script>" may end the element
        "DATA": json.dumps(data).replace("<", "\\u003c"),
        "PLOTLY": get_plotlyjs(),
    }.items():
        page = page.replace(f"<!--{place}-->", text)
    path.write_text(page, encoding="utf-8", newline="\n")


def _aircraft(track: Track, origin: tuple[float, float, float]) -> dict[str, Any]:
    from pymap3d import geodetic2enu

    east, north, up = geodetic2enu(track.lat, track.lon, track.h * FOOT, *origin)
    signals = []
    for label, column in track.columns.items():
        name, unit = name_and_unit(label)
        if name == "heading":  # without the jumps at north
            column = np.unwrap(column, period=360)
        if name not in ("latitude", "longitude"):
            signals.append({"name": name, "unit": unit, "values": _packed(column)})
    columns = {name: getattr(track, name) for name in ("time", "theta", "phi", "psi")}
    columns |= {"east": east, "north": north, "up": up}
    packed = {name: _packed(column) for name, column in columns.items()}
    return {"name": track.name, **packed, "signals": signals}


def _packed(column: Any) -> str:
    return base64.b64encode(np.asarray(column, dtype="<f4").tobytes()).decode("ascii")
