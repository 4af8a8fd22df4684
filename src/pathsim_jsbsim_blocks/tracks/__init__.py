"""Record flights; write them as tables, for Google Earth and Tacview, or as a report."""

from .files import save_tracks
from .recorder import FlightRecorder
from .track import Track, to_frame

__all__ = ["FlightRecorder", "Track", "save_tracks", "to_frame"]
