"""JSBSim's console in all threads, forwarded to the logger ``pathsim_jsbsim_blocks.jsbsim``."""

from __future__ import annotations

import ctypes
import logging
import os
import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeAlias

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

# JSBSim holds references to the logger and to the members of two enumerations for each thread. It
# drops them without the GIL when the thread ends, so two threads may corrupt a reference count
# (measured: one in 20,000 threads). With spare references no object is freed while in use.
_SPARE_REFERENCES = 100
_kept: set[int] = set()

# characters of an error's text
_LONGEST = 1000

# a message of JSBSim, with its level in `logging`
Message: TypeAlias = tuple[int, str]


class _Console(threading.local, jsbsim.FGLogger):
    """JSBSim's console: forwards messages to logging and can keep them; attributes by thread."""

    def __init__(self) -> None:
        super().__init__()
        self.installed = False
        self.level = logging.INFO
        self.parts: list[str] = []
        self.kept: list[Message] | None = None
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
                self.kept.append((self.level, text))
            if text:
                hushed = self.hushed or SEALED_PATH in text
                log.log(logging.DEBUG if hushed else self.level, text)
        except Exception:
            pass
        self.parts.clear()


console = _Console()


def capture_console() -> _Console:
    """Route JSBSim's console in the calling thread to the logger (once per thread)."""
    if not console.installed:
        _install(console)
        console.installed = True
        jsbsim.FGJSBBase().debug_lvl = 0
    return console


def messages(action: Callable[[], Any], *, hushed: bool = False) -> tuple[Any, list[Message]]:
    """Result of ``action()`` and JSBSim's messages meanwhile; ``hushed`` logs them at DEBUG."""
    capture_console()
    # the logger installed last, on any thread
    previous = jsbsim.get_logger()
    _install(console)
    console.kept = []
    console.hushed = hushed
    try:
        return action(), console.kept
    finally:
        console.kept = None
        console.hushed = False
        if previous is not console:
            _install(previous)


def failure_of(action: Callable[[], bool]) -> str:
    """The reason why an action of JSBSim failed, in one line; empty if it succeeded."""

    def attempt() -> str:
        try:
            return "" if action() else "no"
        except Exception as error:
            return " ".join(str(error).split())

    failure, records = messages(attempt)
    if not failure:
        return ""
    text = " ".join(_errors(records)) or failure
    # JSBSim reports the cause last
    return text if len(text) <= _LONGEST else f"... {text[-_LONGEST:]}"


def _errors(records: Sequence[Message]) -> list[str]:
    """Texts of the errors, except those explained by a warning for the same line of XML."""
    texts, warning = [], ""
    for level, text in records:
        place = text.partition(": ")[0]
        if level >= logging.ERROR and place != warning:
            texts.append(text)
        warning = place if level == logging.WARNING else ""
    return texts


def _install(logger: jsbsim.FGLogger) -> None:
    never_free(logger)
    # JSBSim aborts the process if two threads install at once
    with _install_lock:
        jsbsim.set_logger(logger)


def never_free(*things: object) -> None:
    """Keep these objects alive until the end of the process."""
    for thing in things:
        if id(thing) not in _kept:
            _kept.add(id(thing))
            for _ in range(_SPARE_REFERENCES):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))


never_free(*jsbsim.LogLevel, *jsbsim.LogFormat)
