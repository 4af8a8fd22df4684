"""CZML for Cesium: position and orientation of each aircraft over time."""

from __future__ import annotations

import datetime
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from .._core.units import FOOT
from .track import Track, instant

_COLOURS = ([255, 102, 30, 255], [31, 119, 180, 255], [44, 160, 44, 255], [148, 103, 189, 255])


def write_czml(path: Path, tracks: Sequence[Track], start: datetime.datetime, about: str) -> None:
    """One packet for each aircraft; heights are above the ellipsoid."""
    import czml3
    import czml3.properties as of

    def span(first: float, last: float) -> czml3.TimeInterval:
        return czml3.TimeInterval(start=instant(start, first), end=instant(start, last))

    epoch = instant(start, 0.0)
    first = min(track.time[0] for track in tracks)
    interval = span(first, max(track.time[-1] for track in tracks))
    packets = [
        czml3.Packet(
            id="document",
            name=", ".join(track.name for track in tracks),
            description=about,
            version=czml3.CZML_VERSION,
            clock=of.Clock(currentTime=instant(start, first), multiplier=1, interval=interval),
        )
    ]
    for n, (track, colour) in enumerate(zip(tracks, _COLOURS * len(tracks), strict=False), 1):
        place = np.column_stack([track.time, track.lon, track.lat, track.h * FOOT])
        turn = np.column_stack([track.time, quaternions(track)])
        packets.append(
            czml3.Packet(
                id=f"aircraft-{n}",
                name=f"{track.name} ({track.aircraft})",
                description=track.description,
                availability=span(track.time[0], track.time[-1]),
                position=of.Position(epoch=epoch, cartographicDegrees=place.ravel().tolist()),
                orientation=of.Orientation(epoch=epoch, unitQuaternion=turn.ravel().tolist()),
                point=of.Point(pixelSize=8, color=of.Color(rgba=colour)),
                label=of.Label(text=track.name, font="13px sans-serif", show=True),
                path=of.Path(
                    width=2,
                    material=czml3.PolylineMaterial(
                        solidColor=czml3.SolidColorMaterial(color=of.Color(rgba=colour))
                    ),
                ),
            )
        )
    path.write_text(czml3.Document(packets=packets).dumps(), encoding="utf-8")


def quaternions(track: Track) -> np.ndarray:
    """Unit quaternions (x, y, z, w) from Cesium's axes of a model to Earth-fixed axes.

    A model's axes are x ahead, y left, z up. Signs are chosen so that neighbours are close.

    Returns
    -------
    array, shape (n, 4)
    """
    from scipy.spatial.transform import Rotation

    to_earth = Rotation.from_euler("ZY", np.column_stack([track.lon, -90 - track.lat]), True)
    to_level = Rotation.from_euler(
        "ZYX", np.column_stack([track.psi, track.theta, track.phi]), True
    )
    q = (to_earth * to_level * Rotation.from_euler("x", 180, True)).as_quat()
    flips = np.where(np.sum(q[1:] * q[:-1], axis=1) < 0, -1.0, 1.0)
    q[1:] *= np.cumprod(flips)[:, None]
    return q
