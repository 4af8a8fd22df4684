"""A flight seen: recorded, as a table, in Google Earth, Tacview and Cesium, as a page."""

from .files import save_tracks
from .recorder import FlightRecorder
from .track import Track, to_frame

__all__ = ["FlightRecorder", "Track", "save_tracks", "to_frame"]
