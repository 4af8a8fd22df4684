"""Locate the user's code from which a call comes."""

from __future__ import annotations

import logging
import traceback
import warnings
import weakref
from collections.abc import Iterator
from types import FrameType
from typing import Any

_OURS = (__name__.partition(".")[0], "pathsim")


def warn_user(message: str, *, once: bool = False) -> None:
    """Warn at the calling line of the user's code; ``once`` per line."""
    keep_warnings_visible()
    callers = list(frames())
    user = next(filter(is_users, callers), callers[-1])
    registry = user.f_globals.setdefault("__warningregistry__", {}) if once else None
    warnings.warn_explicit(
        message, RuntimeWarning, user.f_code.co_filename, user.f_lineno, registry=registry
    )


def frames() -> Iterator[FrameType]:
    """Frames of the callers, the innermost first, which contain the user's variables."""
    return (frame for frame, _ in traceback.walk_stack(None))


def is_users(frame: FrameType) -> bool:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0] not in _OURS


def depth_in_subsystems() -> int:
    """Number of subsystems around a block whose ``set_solver`` PathSim is calling.

    PathSim does not pass it to a block: only the call stack shows the subsystems.
    """
    from pathsim import Simulation, Subsystem  # a trim does without PathSim

    subsystems: set[int] = set()
    for frame in frames():
        variables = list(frame.f_locals.values())
        subsystems |= {id(x) for x in variables if isinstance(x, Subsystem)}
        if any(isinstance(x, Simulation) for x in variables):
            break
    return len(subsystems)


# by the engine, once found
_simulations: weakref.WeakKeyDictionary[Any, Any] = weakref.WeakKeyDictionary()


def calling_simulation(engine: Any) -> Any:
    """The simulation with this engine, which is calling an event of a block; None without one."""
    from pathsim import Simulation

    sim = _simulations.get(engine, lambda: None)()
    if sim is None:
        variables = (x for frame in frames() for x in frame.f_locals.values())
        sims = (x for x in variables if isinstance(x, Simulation) and x.engine is engine)
        if (sim := next(sims, None)) is not None:
            _simulations[engine] = weakref.ref(sim)
    return sim


def _captured() -> bool:
    """Whether warnings go to `logging`."""
    return warnings.showwarning.__module__ == logging.__name__


# evaluated before PathSim's first `Simulation`, which captures warnings itself
_CAPTURED_BY_APPLICATION = _captured() and logging.getLogger("pathsim").propagate


def keep_warnings_visible() -> None:
    """Undo PathSim's capture of warnings if no handler shows them.

    The first `Simulation` of a process redirects all warnings to `logging`.
    """
    if _captured() and not _CAPTURED_BY_APPLICATION:
        loggers = (logging.getLogger("py.warnings"), logging.root)
        handlers = [handler for logger in loggers for handler in logger.handlers]
        if all(isinstance(handler, logging.NullHandler) for handler in handlers):
            logging.captureWarnings(False)
