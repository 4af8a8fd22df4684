"""Try in a copy of the process what may end the process."""

from __future__ import annotations

import contextlib
import faulthandler
import logging
import os
import warnings
from collections.abc import Callable
from typing import Any

_LONGEST = 20  # s of computing; what runs on for longer reads memory that is not its own


def survives(action: Callable[[], Any]) -> bool:
    """Whether an action ends and lets the process live.

    A forked child does it first and is thrown away, a few ms for a short action. Where the
    platform cannot fork (Windows) the answer is always yes.
    """
    if not hasattr(os, "fork"):
        return True
    answer, tell = os.pipe()
    with warnings.catch_warnings():
        # of threads that the child would miss: it needs none
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        _rehearse(action, tell)
    os.close(tell)
    try:
        return os.read(answer, 1) == b"y"
    finally:
        os.close(answer)
        with contextlib.suppress(ChildProcessError):
            os.waitpid(child, 0)


def _rehearse(action: Callable[[], Any], tell: int) -> None:
    """Never returns; neither prints nor logs, because the parent will."""
    try:
        import resource  # where there is fork there is this

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (_LONGEST, _LONGEST))
        logging.disable()
        faulthandler.disable()
        nowhere = os.open(os.devnull, os.O_WRONLY)
        for stream in (1, 2):
            os.dup2(nowhere, stream)
        with contextlib.suppress(Exception):
            action()
        os.write(tell, b"y")
    finally:
        os._exit(0)
