"""Run actions that may crash the process in a forked copy first."""

from __future__ import annotations

import contextlib
import enum
import faulthandler
import logging
import os
import signal
import warnings
from collections.abc import Callable
from typing import Any


class Outcome(enum.Enum):
    """What an action does to its process."""

    ENDS = enum.auto()
    KILLS = enum.auto()
    GOES_ON = enum.auto()


def rehearse(action: Callable[[], Any], seconds: int) -> Outcome:
    """What a forked child, which exits, shows of an action limited to a CPU time in s.

    It adds a few ms. On a platform without fork (Windows) the result is always `Outcome.ENDS`.
    """
    if not hasattr(os, "fork"):
        return Outcome.ENDS
    answer, tell = os.pipe()
    with warnings.catch_warnings():
        # fork warns about threads that the child lacks; it needs none
        warnings.simplefilter("ignore", DeprecationWarning)
        child = os.fork()
    if child == 0:
        _act(action, seconds, tell)
    os.close(tell)
    status = 0
    try:
        ended = os.read(answer, 1) == b"y"
    finally:
        os.close(answer)
        with contextlib.suppress(ChildProcessError):
            _, status = os.waitpid(child, 0)
    if ended:
        return Outcome.ENDS
    limits = signal.SIGXCPU, signal.SIGKILL
    over = os.WIFSIGNALED(status) and os.WTERMSIG(status) in limits
    return Outcome.GOES_ON if over else Outcome.KILLS


def _act(action: Callable[[], Any], seconds: int, tell: int) -> None:
    """Run the action in the child and exit, without output: the parent repeats the action."""
    try:
        import resource  # available wherever fork is

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
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
