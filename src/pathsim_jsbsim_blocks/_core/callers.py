"""Where in the user's code a call comes from."""

from __future__ import annotations

import traceback
import warnings
from collections.abc import Iterator
from types import FrameType

_OURS = (__name__.partition(".")[0], "pathsim")


def warn_user(message: str, *, once: bool = False) -> None:
    """Warn at the line of the user's that the calls come from; ``once`` for each line."""
    callers = list(frames())
    user = next(filter(is_users, callers), callers[-1])
    registry = user.f_globals.setdefault("__warningregistry__", {}) if once else None
    warnings.warn_explicit(
        message, RuntimeWarning, user.f_code.co_filename, user.f_lineno, registry=registry
    )


def frames() -> Iterator[FrameType]:
    """Frames of the callers, the innermost first: they hold the names that the user gave."""
    return (frame for frame, _ in traceback.walk_stack(None))


def is_users(frame: FrameType) -> bool:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0] not in _OURS
