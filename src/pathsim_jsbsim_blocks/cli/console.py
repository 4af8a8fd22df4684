"""The command's messages on stderr, and its exit status."""

from __future__ import annotations

import os
import sys

from ..errors import BlocksError, UntrustedModelError


def tell(text: str) -> None:
    print(f"pathsim-jsbsim: {text}", file=sys.stderr)


def report(error: BaseException, more: str = "") -> int:
    """Print why the command ends; return 1 (failed), 2 (not trusted) or 130 (interrupted)."""
    status, message = 1, str(error)
    if isinstance(error, UntrustedModelError):
        status, message = 2, f"{error}, then pass --trust"
    elif isinstance(error, KeyboardInterrupt):
        status, message = 130, ": ".join(filter(None, ["interrupted", message]))
    elif directory_is_gone():
        message = "the working directory no longer exists: change to another one"
    elif isinstance(error, OSError) and not isinstance(error, BlocksError) and error.strerror:
        message = f"{error.filename or 'the output'}: {error.strerror}"
    tell(message + more)
    return status


def directory_is_gone() -> bool:
    try:
        os.getcwd()
    except OSError:
        return True
    return False
