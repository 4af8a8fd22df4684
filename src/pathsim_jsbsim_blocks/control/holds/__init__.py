"""One block per hold, all made of the plain loops in ``control.loops``.

Their outputs are increments on the trimmed commands, as ``Aircraft`` takes them.
"""

from .lateral import HeadingHold, RollHold, YawDamper
from .longitudinal import AirspeedHold, AltitudeHold, PitchHold

__all__ = ["AirspeedHold", "AltitudeHold", "HeadingHold", "PitchHold", "RollHold", "YawDamper"]
