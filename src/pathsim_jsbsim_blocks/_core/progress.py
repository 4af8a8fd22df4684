"""The progress bar of runs."""

from __future__ import annotations

import functools
import sys
from typing import TYPE_CHECKING, Any

from .checks import flag

if TYPE_CHECKING:
    from tqdm import tqdm

_BAR = "{l_bar}{bar}| {n:.1f}/{total:.1f} s in {elapsed}, {rate_noinv_fmt}"
_SECONDS_BEFORE_BAR = 2.0

# of runs in a copy of this process: one line of the terminal would show them all
bars_hidden = False


def progress_bar(duration: float, visible: bool | None = None, **style: Any) -> tqdm:
    """A bar on stderr for a run of ``duration`` in s; default after 2 s, on a terminal."""
    if visible is not None:
        flag("progress", visible)
    return _bar_class()(
        total=duration,
        leave=False,
        delay=0.0 if visible else _SECONDS_BEFORE_BAR,
        # without a console (pythonw) there is no stderr
        disable=sys.stderr is None or ((bars_hidden or None) if visible is None else not visible),
        **(style or {"unit": " s", "bar_format": _BAR}),
    )


@functools.cache
def _bar_class() -> type[tqdm]:
    from tqdm import tqdm

    class Bar(tqdm):
        # tqdm starts a thread that watches its bars. If Ctrl-C leaves tqdm's lock held, that thread
        # blocks, and the process cannot end
        monitor_interval = 0

    return Bar
