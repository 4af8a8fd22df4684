"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
from pathlib import Path


def write_whole(path: Path, content: str) -> None:
    """Write a whole text file or nothing. A link stays, and so does a device such as /dev/stdout.

    Raises
    ------
    OSError
        if it cannot be written; an existing file is left unchanged, unless it is in a folder that
        cannot be written
    """
    if path.exists() and not path.is_file():
        path.write_text(content, encoding="utf-8")
        return
    path = path.resolve()
    # cut, because the longest name has no room for more
    temporary = path.with_name(f".{path.name[:50]}.{os.getpid()}")
    try:
        with temporary.open("x", encoding="utf-8", newline="\n") as file:
            file.write(content)
        if path.exists():
            shutil.copymode(path, temporary)
        temporary.replace(path)
    except PermissionError:
        # a file that can be written in a folder that cannot
        if not path.exists():
            raise
        path.write_text(content, encoding="utf-8", newline="\n")
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()
