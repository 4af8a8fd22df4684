"""Messages that several commands share."""

from __future__ import annotations

import os

GONE = "the working directory no longer exists: change to another one"


def directory_is_gone() -> bool:
    try:
        os.getcwd()
    except OSError:
        return True
    return False
