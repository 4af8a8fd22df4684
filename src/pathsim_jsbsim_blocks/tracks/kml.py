"""KML 2.2 for Google Earth: a track with time stamps, altitudes and attitudes for each aircraft.

Written element by element, because simplekml does not follow the order of the schemas
``ogckml22.xsd`` and ``kml22gx.xsd``, and fastkml has no data in tracks.
"""

from __future__ import annotations

import datetime
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from .._core.units import FOOT
from .track import Track, instant

_KML = "http://www.opengis.net/kml/2.2"
_GX = "http://www.google.com/kml/ext/2.2"
_ICON = "http://maps.google.com/mapfiles/kml/shapes/airports.png"
_COLOURS = ("ff1e66ff", "ffb4771f", "ff2ca02c", "ffbd6794", "ff2827d6")  # alpha, blue, green, red
_FLOAT = {"nan": "NaN", "inf": "INF", "-inf": "-INF"}  # spelling of XML Schema

# limits for tracks of all steps: Google Earth interpolates, and is slow with large files
_RATE = 5.0  # points per second
_SIZE = 4.9e6  # bytes of all points
_POINT, _VALUE = 180, 44  # bytes of a point without signals, and of a signal's value, at most


def write_kml(path: Path, tracks: Sequence[Track], start: datetime.datetime, about: str) -> None:
    """One ``gx:Track`` for each aircraft, its signals as extended data.

    ``gx:angles`` are clockwise about z up, x right and y ahead, each seen against its axis: the
    tilt is the negative pitch angle, the roll the negative roll angle.
    """
    tracks = [_drawn(track, _SIZE / len(tracks)) if track.every_step else track for track in tracks]
    root = ET.Element("kml", {"xmlns": _KML, "xmlns:gx": _GX})
    document = _child(root, "Document")
    _child(document, "name", ", ".join(track.name for track in tracks))
    _child(document, "description", about)
    for n in range(len(tracks)):
        style = _child(document, "Style", id=f"style-{n}")
        _child(_child(_child(style, "IconStyle"), "Icon"), "href", _ICON)
        line = _child(style, "LineStyle")
        _child(line, "color", _COLOURS[n % len(_COLOURS)])
        _child(line, "width", "3")
    for n, track in enumerate(tracks):
        schema = _child(document, "Schema", id=f"signals-{n}")
        for i, label in enumerate(track.signals):
            field = _child(schema, "gx:SimpleArrayField", name=f"signal-{i}", type="float")
            _child(field, "displayName", label)
    for n, track in enumerate(tracks):
        mark = _child(document, "Placemark")
        _child(mark, "name", track.name)
        _child(mark, "description", track.description)
        _child(mark, "styleUrl", f"#style-{n}")
        _track(mark, track, start, f"#signals-{n}")
    ET.indent(root, " ")
    ET.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def _drawn(track: Track, size: float) -> Track:
    """5 samples per second of a track, or as many as fit a size in bytes."""
    most = _RATE * (track.time[-1] - track.time[0])
    return track.at_most(max(min(most, size / (_POINT + _VALUE * len(track.signals))), 1.0))


def _track(mark: ET.Element, track: Track, start: datetime.datetime, schema: str) -> None:
    line = _child(mark, "gx:Track")
    _child(line, "altitudeMode", "absolute")
    for t in track.time.tolist():
        _child(line, "when", instant(start, t))
    for place in _rows(track.lon, track.lat, track.h * FOOT):
        _child(line, "gx:coord", "{:.9f} {:.9f} {:.3f}".format(*place))
    for turn in _rows(track.psi, -track.theta, -track.phi):
        _child(line, "gx:angles", "{:.4f} {:.4f} {:.4f}".format(*turn))
    data = _child(_child(line, "ExtendedData"), "SchemaData", schemaUrl=schema)
    for i, column in enumerate(track.signals.values()):
        array = _child(data, "gx:SimpleArrayData", name=f"signal-{i}")
        for value in column.tolist():
            _child(array, "gx:value", _FLOAT.get(text := f"{value:.7g}", text))


def _rows(*columns: np.ndarray) -> Iterable[tuple[float, ...]]:
    return zip(*(column.tolist() for column in columns), strict=True)


def _child(parent: ET.Element, tag: str, text: str | None = None, **attributes: str) -> ET.Element:
    child = ET.SubElement(parent, tag, attributes)
    child.text = text
    return child
