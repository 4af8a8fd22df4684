"""The progress bar of runs."""

from __future__ import annotations

import functools
import sys
from typing import TYPE_CHECKING

from .checks import flag

if TYPE_CHECKING:
    from tqdm import tqdm

_BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} s in {elapsed}, {rate_noinv_fmt}"
_SECONDS_BEFORE_BAR = 2.0


def progress_bar(duration: float, visible: bool | None = None) -> tqdm:
    """A bar on stderr for a run of ``duration`` in s; default after 2 s, on a terminal."""
    if visible is not None:
        flag("progress", visible)
    return _bar_class()(
        total=duration,
        unit=" s",
        bar_format=_BAR,
        leave=False,
        delay=0.0 if visible else _SECONDS_BEFORE_BAR,
        # without a console (pythonw) there is no stderr
        disable=sys.stderr is None or (None if visible is None else not visible),
    )


@functools.cache
def _bar_class() -> type[tqdm]:
    from tqdm import tqdm

    class Bar(tqdm):
        # tqdm starts a thread that watches its bars. If Ctrl-C leaves tqdm's lock held, that thread
        # blocks, and the process cannot end
        monitor_interval = 0

    return Bar
