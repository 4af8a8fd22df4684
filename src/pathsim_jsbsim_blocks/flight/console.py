"""JSBSim's console of each thread, forwarded to the logger ``pathsim_jsbsim_blocks.jsbsim``."""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Callable
from typing import Any

import jsbsim

log = logging.getLogger("pathsim_jsbsim_blocks.jsbsim")

# no file can be created below a device, so JSBSim opens none while loading
SEALED_PATH = os.path.join(os.devnull, "sealed")

_LEVELS = {
    jsbsim.LogLevel.BULK: logging.DEBUG,
    jsbsim.LogLevel.DEBUG: logging.DEBUG,
    jsbsim.LogLevel.INFO: logging.INFO,
    jsbsim.LogLevel.WARN: logging.WARNING,
    jsbsim.LogLevel.ERROR: logging.ERROR,
    jsbsim.LogLevel.FATAL: logging.CRITICAL,
    jsbsim.LogLevel.STDOUT: logging.INFO,
}

_install_lock = threading.Lock()
_thread = threading.local()

# by thread, what is installed there: when a thread ends JSBSim releases its logger without holding
# the GIL, which kills the process if that was the last reference
_installed: dict[int, jsbsim.FGLogger] = {}


class _Console(jsbsim.FGLogger):
    """JSBSim's console of one thread: forwards messages to logging and can keep them."""

    def __init__(self) -> None:
        super().__init__()
        self.level = logging.INFO
        self.parts: list[str] = []
        self.kept: list[str] | None = None
        self.hushed = False

    def set_level(self, level: Any) -> None:
        self.level = _LEVELS.get(level, logging.INFO)
        self.parts.clear()

    def file_location(self, filename: str, line: int) -> None:
        self.parts.append(f"{filename}:{line}: ")

    def message(self, message: str) -> None:
        self.parts.append(message)

    def format(self, format: Any) -> None:
        pass

    def flush(self) -> None:
        # an exception here would reach the caller as a SystemError without its cause
        try:
            text = " ".join("".join(self.parts).split())
            if text and self.kept is not None:
                self.kept.append(text)
            if text:
                hushed = self.hushed or SEALED_PATH in text
                log.log(logging.DEBUG if hushed else self.level, text)
        except Exception:
            pass
        self.parts.clear()


def capture_console() -> _Console:
    """Route JSBSim's console of the calling thread to the logger (once per thread)."""
    console = getattr(_thread, "console", None)
    if console is None:
        console = _thread.console = _Console()
        _install(console)
        jsbsim.FGJSBBase().debug_lvl = 0
    return console


def messages(action: Callable[[], Any], *, hushed: bool = False) -> tuple[Any, list[str]]:
    """Result of ``action()`` and JSBSim's messages meanwhile; ``hushed`` logs them at DEBUG."""
    console = capture_console()
    # the logger installed last, on any thread
    previous = jsbsim.get_logger()
    if previous is not console:
        _install(console)
    console.kept = []
    console.hushed = hushed
    try:
        return action(), console.kept
    finally:
        console.kept = None
        console.hushed = False
        # another thread's console stays there
        if not isinstance(previous, _Console):
            _install(previous)


def _install(logger: jsbsim.FGLogger) -> None:
    # JSBSim aborts the process if two threads install at once
    with _install_lock:
        jsbsim.set_logger(logger)
        _installed[threading.get_ident()] = logger
