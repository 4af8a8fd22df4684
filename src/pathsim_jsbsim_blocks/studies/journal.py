"""A file that keeps the finished parts of a study, so that a killed one can resume."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn

from .._core.checks import as_path, refuse
from .._core.extras import required
from ..errors import FileError
from .kept import differences

_FORMAT = "pathsim-jsbsim study"
_VERSION = 4

# what reading a line raises that is not as it was written
_DAMAGED = (ValueError, TypeError, KeyError, AttributeError, RecursionError)


class Journal:
    """Finished parts, one JSON line each; the first line says which study they belong to.

    Every line carries a checksum. A line that a kill cut off is dropped. Floats are written so that
    they are read back bit for bit. The file is locked while it is open. ``title`` is the study in
    words, ``key`` everything that the results depend on (`study_key`), ``finished`` the rows of
    each finished part.

    Raises
    ------
    ParameterError
        if the file cannot be opened, is damaged, holds something else, or is in use by another
        process
    FileError
        if reading or writing fails, here and in `add`, such as on a full disk
    """

    def __init__(self, path: str | Path, title: str, key: Mapping[str, str]):
        self.path = as_path("resume", path)
        header = {"format": _FORMAT, "version": _VERSION, "study": title, "key": dict(key)}
        self.finished: dict[int, list] = {}
        lock = required("filelock", "studies").lock_descriptor
        if os.path.exists(self.path) and not os.path.isfile(self.path):
            self._refuse(f"cannot write {str(path)!r}: it is not a file")
        try:
            # unbuffered, so that finished lines survive a kill of this process
            self._file = self.path.open("a+b", buffering=0)
        except OSError as error:
            self._refuse(f"cannot write {str(path)!r}: {error.strerror}")
        try:
            self._lock(lock)
            self._file.seek(0)
            self._read(self._file.read(), header)
        except BaseException as error:
            self._file.close()
            if isinstance(error, OSError) and not isinstance(error, FileError):
                raise FileError("read", path, error) from None
            raise

    def _lock(self, lock: Callable[..., bool]) -> None:
        free = True
        with contextlib.suppress(OSError):  # a file system without locks
            free = lock(self._file.fileno(), blocking=False)
        if not free:
            why = "is in use: another process runs this study. Wait for it or name another file"
            self._refuse(f"{str(self.path)!r} {why}")

    def _refuse(self, why: str) -> NoReturn:
        refuse("resume", str(self.path), why)

    def _read(self, content: bytes, header: dict[str, Any]) -> None:
        if _line(header).startswith(content):  # new, or killed before the first line was complete
            self._file.truncate(0)
            self._write(_line(header))
            return
        # text after the last newline was cut off by a kill
        first, *lines = content.split(b"\n")[:-1] or [content]
        if first + b"\n" != _line(header):
            holds = _holds(first, header)
            self._refuse(f"{str(self.path)!r} holds {holds}; name another file or delete it")
        for number, line in enumerate(lines, 2):
            try:
                part = _checked(line)
                self.finished[part["part"]] = part["rows"]
            except _DAMAGED:
                why = "is damaged: delete the line and it is computed again"
                self._refuse(f"line {number} of {str(self.path)!r} {why}")
        self._file.truncate(content.rindex(b"\n") + 1)

    def add(self, part: int, rows: list) -> None:
        """Keep the rows of a finished part."""
        self._write(_line({"part": part, "rows": rows}))

    def close(self) -> None:
        """Close the file and keep it."""
        self._file.close()

    def _write(self, line: bytes) -> None:
        try:
            # a full disk may accept part of the line before it refuses the rest
            while line:
                line = line[self._file.write(line) :]
        except OSError as error:
            kept = "; the parts finished before are kept in it"
            raise FileError("write", self.path, error, kept) from None


def _line(data: dict[str, Any]) -> bytes:
    return (json.dumps({**data, "check": _check(data)}) + "\n").encode()


def _check(data: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(data).encode()).hexdigest()[:16]


def _checked(line: bytes) -> dict[str, Any]:
    """Data of a line; ValueError if it is not what was written."""
    data = json.loads(line)
    if data.pop("check") != _check(data):
        raise ValueError
    return data


def _holds(first: bytes, wanted: dict[str, Any]) -> str:
    """What a file holds whose first line is not the wanted one."""
    try:
        found = json.loads(first)
        if not found["format"].startswith(_FORMAT):
            return "other data"
        if found.get("version") != _VERSION:
            return "a study written by another version"
        found = _checked(first)
        alike = found["study"].split()[:1] == wanted["study"].split()[:1]
        parts = differences(found["key"], wanted["key"]) if alike else ""
        differs = f". What differs: {parts}" if parts else ""
        return f"another study ({found['study']}), not this one ({wanted['study']}){differs}"
    except _DAMAGED:
        return "other data"
