"""Forked copies of this process. Only this file forks."""

from __future__ import annotations

import contextlib
import enum
import faulthandler
import logging
import os
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from multiprocessing.connection import wait
from typing import Any, NoReturn

from .._core import progress

# s between two looks of a copy whether its parent lives
_WATCH = 0.2

# bytes read at once
_PIECE = 1 << 20


class Fork:
    """A copy of this process that runs an action.

    Attributes
    ----------
    answer : bytearray
        the bytes that it has sent
    status : int
        how it ended, as from `os.waitpid`
    """

    def __init__(self, pid: int, pipe: int):
        self.pid, self.pipe = pid, pipe
        self.answer, self.status = bytearray(), 0


class Forks:
    """Context of copies of this process; those that run at its end are killed.

    They end too if this process is killed. Ctrl-C at a terminal, which reaches all processes,
    interrupts this one only.
    """

    def __init__(self) -> None:
        self.running: dict[int, Fork] = {}

    def __enter__(self) -> Forks:
        return self

    def __exit__(self, *_: object) -> None:
        with _interrupts_delayed():
            for fork in [*self.running.values()]:
                self.kill(fork)

    def start(self, action: Callable[[], bytes]) -> Fork:
        """Fork; the copy sends the bytes that ``action`` returns, and exits."""
        # what stands in the buffers would be printed by the copy too
        _flush()
        # a copy that is not yet listed could not be killed
        with _interrupts_delayed():
            pipe, end = os.pipe()
            parent = os.getpid()
            try:
                with warnings.catch_warnings():
                    # fork warns about threads that the copy lacks; it needs none
                    warnings.simplefilter("ignore", DeprecationWarning)
                    pid = os.fork()
            except OSError:
                os.close(pipe)
                os.close(end)
                raise
            if pid == 0:
                self._run(action, end, parent)
            os.close(end)
            fork = self.running[pipe] = Fork(pid, pipe)
        return fork

    def next(self) -> Fork:
        """Wait until one of the copies that run has ended."""
        while True:
            for pipe in wait([*self.running]):
                fork = self.running[pipe]  # type: ignore[index]
                if piece := os.read(fork.pipe, _PIECE):
                    fork.answer += piece
                    continue
                with _interrupts_delayed():
                    self._forget(fork)
                return fork

    def kill(self, fork: Fork) -> None:
        """End a copy that runs."""
        with contextlib.suppress(ProcessLookupError):
            os.kill(fork.pid, signal.SIGKILL)
        self._forget(fork)

    def _forget(self, fork: Fork) -> None:
        del self.running[fork.pipe]
        os.close(fork.pipe)
        # with SIGCHLD ignored the system has collected it
        with contextlib.suppress(ChildProcessError):
            fork.status = os.waitpid(fork.pid, 0)[1]

    def _run(self, action: Callable[[], bytes], end: int, parent: int) -> NoReturn:
        """Run the action in the copy and exit."""
        code = 1
        try:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
            for pipe in self.running:
                os.close(pipe)
            progress.bars_hidden = True
            threading.Thread(target=_end_with, args=(parent,), daemon=True).start()
            answer = memoryview(action())
            while answer:
                answer = answer[os.write(end, answer) :]
            code = 0
        finally:
            _flush()
            os._exit(code)


def _end_with(parent: int) -> None:
    """End this process once its parent has been killed."""
    while os.getppid() == parent:
        time.sleep(_WATCH)
    os._exit(1)


def _flush() -> None:
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(Exception):  # closed, or absent
            stream.flush()


@contextlib.contextmanager
def _interrupts_delayed() -> Iterator[None]:
    """Context in which Ctrl-C waits for its end; other threads than the main one have none."""
    signals: list[tuple[Any, ...]] = []
    main = threading.current_thread() is threading.main_thread()
    handler = signal.getsignal(signal.SIGINT) if main else None
    if not callable(handler):
        yield
        return
    signal.signal(signal.SIGINT, lambda *args: signals.append(args))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if signals:
            handler(*signals[0])


class Outcome(enum.Enum):
    """How a process ends that runs an action."""

    OK = enum.auto()
    CRASH = enum.auto()
    TIMEOUT = enum.auto()


def run_in_fork(action: Callable[[], Any], seconds: int) -> Outcome:
    """Outcome of an action that may crash the process, in a copy with limited CPU time, in s.

    The fork takes a few ms. On a platform without it (Windows) the result is always `Outcome.OK`.
    """
    if not hasattr(os, "fork"):
        return Outcome.OK
    with Forks() as forks:
        forks.start(lambda: _tried(action, seconds))
        fork = forks.next()
    if fork.answer:
        return Outcome.OK
    limits = signal.SIGXCPU, signal.SIGKILL
    over = os.WIFSIGNALED(fork.status) and os.WTERMSIG(fork.status) in limits
    return Outcome.TIMEOUT if over else Outcome.CRASH


def _tried(action: Callable[[], Any], seconds: int) -> bytes:
    """Run the action without output: the parent repeats it."""
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
    return b"y"
