"""Python's warnings stay visible beside PathSim.

The first `Simulation` redirects all warnings into `logging`, where nobody listens by default.
"""

from __future__ import annotations

import functools
import logging
import warnings

from pathsim.utils.logger import LoggerManager


def keep_warnings_visible() -> None:
    """Have PathSim leave Python's warnings as the user has set them up."""
    redirect = getattr(LoggerManager, "_setup_root_logger", None)
    if redirect is None or hasattr(redirect, "__wrapped__"):
        return
    if LoggerManager._initialized and _lost():
        logging.captureWarnings(False)

    @functools.wraps(redirect)
    def without_redirection(self: LoggerManager) -> None:
        shown = warnings.showwarning
        redirect(self)
        if warnings.showwarning is not shown:
            logging.captureWarnings(False)

    LoggerManager._setup_root_logger = without_redirection


def _lost() -> bool:
    """Whether warnings go into `logging`, and nobody listens there."""
    loggers = (logging.Logger.manager.loggerDict.get("py.warnings"), logging.root)
    return warnings.showwarning.__module__ == logging.__name__ and all(
        isinstance(handler, logging.NullHandler)
        for logger in loggers for handler in getattr(logger, "handlers", ()))
