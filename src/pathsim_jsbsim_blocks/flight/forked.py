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
    """How a process ends that runs an action."""

    OK = enum.auto()
    CRASH = enum.auto()
    TIMEOUT = enum.auto()


def run_in_fork(action: Callable[[], Any], seconds: int) -> Outcome:
    """Outcome of an action in a forked child whose CPU time is limited, in s.

    The fork takes a few ms. On a platform without it (Windows) the result is always `Outcome.OK`.
    """
    if not hasattr(os, "fork"):
        return Outcome.OK
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
        return Outcome.OK
    limits = signal.SIGXCPU, signal.SIGKILL
    over = os.WIFSIGNALED(status) and os.WTERMSIG(status) in limits
    return Outcome.TIMEOUT if over else Outcome.CRASH


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
