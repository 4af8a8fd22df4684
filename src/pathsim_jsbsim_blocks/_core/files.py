"""Write files completely or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from ..errors import FileError


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file beside ``path``, with its ending, to write to; it replaces ``path`` at the end.

    After an exception an existing file is unchanged; an OSError becomes a `FileError`. A link
    remains a link. A device such as /dev/stdout is written directly, as is a file in a folder
    without permission to create files.
    """
    try:
        yield from _beside(path)
    except OSError as error:
        raise FileError("write", path, error) from None


def _beside(path: Path) -> Iterator[Path]:
    if path.exists() and not path.is_file():
        yield path
        return
    target = path.resolve()
    # shortened, because the name may have the maximum length already
    temporary = target.with_name(f".{path.stem[-50:]}.{os.getpid()}{path.suffix[-20:]}")
    try:
        temporary.open("x").close()
    except PermissionError:
        if not path.exists():
            raise
        yield path
        return
    try:
        yield temporary
        if target.exists():
            shutil.copymode(target, temporary)
        temporary.replace(target)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def write_whole(path: Path, content: str) -> None:
    """Write a text file completely or not at all, by `replacing`."""
    with replacing(path) as file:
        file.write_text(content, encoding="utf-8", newline="\n")
