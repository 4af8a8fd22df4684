"""Tacview's ACMI 2.2: text, one line for each aircraft and instant, with the changed properties.

Format and properties: Raia Software, *ACMI 2.2 File Format*, tacview.net/documentation/acmi.
"""

from __future__ import annotations

import datetime
import heapq
import itertools
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from .._core.scopes import name_and_unit
from .._core.units import FOOT, convert
from ..errors import ParameterError
from .track import Track

# ACMI property and unit by the signal's name. Control positions are fractions of full travel
_PROPERTIES = {
    "calibrated airspeed": ("CAS", "m/s"),
    "true airspeed": ("TAS", "m/s"),
    "Mach number": ("Mach", ""),
    "angle of attack": ("AOA", "deg"),
    "sideslip angle": ("AOS", "deg"),
    "height above ground": ("AGL", "m"),
    "throttle": ("Throttle", ""),
    "elevator": ("Elevator", ""),
    "left aileron": ("AileronLeft", ""),
    "right aileron": ("AileronRight", ""),
    "rudder": ("Rudder", ""),
    "flaps": ("Flaps", ""),
    "speed brake": ("AirBrakes", ""),
    "gear": ("LandingGear", ""),
    "fuel": ("FuelWeight", "kg"),
    "vertical load factor": ("VerticalGForce", "g"),
    "longitudinal load factor": ("LongitudinalGForce", "g"),
}


def write_acmi(path: Path, tracks: Sequence[Track], start: datetime.datetime, about: str) -> None:
    """One object for each aircraft: position, attitude, and the signals that ACMI defines."""
    head = {
        "ReferenceTime": start.replace(tzinfo=None).isoformat(timespec="milliseconds") + "Z",
        "DataSource": about,
        "DataRecorder": about,
        "Title": ", ".join(track.name for track in tracks),
    }
    # Tacview requires the byte order mark
    with path.open("w", encoding="utf-8-sig", newline="\n") as file:
        file.write("FileType=text/acmi/tacview\nFileVersion=2.2\n")
        file.writelines(f"0,{name}={_escaped(text)}\n" for name, text in head.items())
        present = None
        lines = (_lines(f"{n:x}", track) for n, track in enumerate(tracks, 1))
        for time, line in heapq.merge(*lines, key=lambda item: item[0]):
            if time != present:
                file.write(f"#{f'{time:.9f}'.rstrip('0').rstrip('.')}\n")
                present = time
            file.write(f"{line}\n")


def _lines(identity: str, track: Track) -> Iterator[tuple[float, str]]:
    names, columns = _columns(track)
    place = np.column_stack(
        [track.lon, track.lat, track.h * FOOT, track.phi, track.theta, track.psi]
    )
    first = f",Type=Air+FixedWing,Name={_escaped(track.aircraft)},CallSign={_escaped(track.name)}"
    previous: dict[str, str] = {}
    rows = zip(*columns, strict=True) if columns else itertools.repeat(())
    for time, (lon, lat, alt, *angles), row in zip(
        track.time.tolist(), place.tolist(), rows, strict=False
    ):
        values = {name: f"{x:.6g}" for name, x in zip(names, row, strict=True) if math.isfinite(x)}
        changes = "".join(f",{n}={x}" for n, x in values.items() if previous.get(n) != x)
        attitude = "|".join(f"{x:.4f}" for x in angles)
        yield time, f"{identity},T={lon:.9f}|{lat:.9f}|{alt:.4f}|{attitude}{first}{changes}"
        first, previous = "", values


def _columns(track: Track) -> tuple[list[str], list[list[float]]]:
    """The signals that are ACMI properties, with their values in ACMI's units."""
    columns = {}
    for text, column in track.signals.items():
        name, unit = name_and_unit(text)
        if name not in _PROPERTIES:
            continue
        acmi_name, target = _PROPERTIES[name]
        try:
            values = column if unit == target else convert(column, unit, target)
        except ParameterError:
            continue  # another quantity under the same name
        columns[acmi_name] = values.tolist()
    return list(columns), list(columns.values())


def _escaped(text: str) -> str:
    # a backslash escapes commas and ends of lines, but not itself
    return " ".join(text.split()).replace("\\", "/").replace(",", "\\,")
