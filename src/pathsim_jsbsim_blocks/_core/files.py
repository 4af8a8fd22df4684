"""Paths of files that can be written; files written completely or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ..errors import FileError
from .checks import did_you_mean, must_be, nearest, refuse


def as_path(parameter: str, value: Any) -> Path:
    try:
        path = Path(value)
        if "\0" in str(path):  # not allowed by any system
            raise TypeError
        return path
    except TypeError:
        must_be(parameter, value, "a path")


def writable(parameter: str, value: Any) -> Path:
    """``value`` as the path of a file that can be written, tried by opening it."""
    path = as_path(parameter, value)
    # os.path, because Path raises for a name that is too long for the system
    if os.path.isdir(path):
        refuse(parameter, str(path), f"{parameter} must be a file, {str(path)!r} is a directory")
    if not os.path.isdir(path.parent):
        refuse(parameter, str(path), f"no directory {str(path.parent)!r} to write {path.name!r} in")
    new = not os.path.lexists(path)
    if new or os.path.isfile(path):  # opening and closing a pipe would end its data
        try:
            path.open("ab").close()
            if new:
                path.unlink()
        except OSError as error:
            refuse(parameter, str(path), f"cannot write {str(path)!r}: {error.strerror}")
    return path


def ending(parameter: str, path: Path, *endings: str) -> Path:
    """``path`` if it has one of ``endings``; the error suggests it with the nearest of them."""
    if path.suffix.lower() not in endings:
        text = " or ".join(x for x in endings if x)
        close = nearest(path.suffix, endings, 1) or endings
        hint = did_you_mean([os.path.splitext(path)[0] + close[0]])
        refuse(parameter, str(path), f"{parameter} must end in {text}, not {path.name!r}{hint}")
    return path


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
