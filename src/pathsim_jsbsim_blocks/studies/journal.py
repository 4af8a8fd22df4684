"""A file that keeps the finished parts of a study, so that a killed one can go on."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from ..errors import ParameterError

_FORMAT = "pathsim-jsbsim study 1"


class Journal:
    """Finished parts, one JSON line each; the first line says which study they belong to.

    A line that a kill cut off is dropped. Floats are written so that they come back bit for bit.

    Parameters
    ----------
    path : str or Path
        the file; made if it does not exist
    title : str
        the study in words
    job : object
        all that the results depend on, as plain data

    Attributes
    ----------
    finished : dict[int, list]
        rows of each finished part

    Raises
    ------
    ParameterError
        if the file cannot be written, is damaged, or holds something else
    """

    def __init__(self, path: str | Path, title: str, job: Any):
        self.path = Path(path)
        digest = hashlib.sha256(json.dumps(job, sort_keys=True).encode()).hexdigest()
        header = _line({"format": _FORMAT, "study": title, "key": digest})
        self.finished: dict[int, list] = {}
        try:
            self._file = self.path.open("a+b")
        except OSError as error:
            raise ParameterError(f"cannot write {str(path)!r}: {error.strerror}",
                                 parameter="resume", value=str(path)) from None
        try:
            self._file.seek(0)
            self._read(self._file.read(), header, title)
        except BaseException:
            self._file.close()
            raise

    def _read(self, content: bytes, header: bytes, title: str) -> None:
        if header.startswith(content):  # new, or killed before the first line was out
            self._file.truncate(0)
            self._write(header)
            return
        first, *lines = content.splitlines(keepends=True)
        if first != header:
            raise ParameterError(
                f"{str(self.path)!r} holds {_holds(first)}, not this one ({title}); name another "
                "file or delete it", parameter="resume", value=str(self.path))
        size = len(first)
        for number, line in enumerate(lines, 2):
            if not line.endswith(b"\n"):
                break
            try:
                part = json.loads(line)
                self.finished[int(part["part"])] = list(part["rows"])
            except (ValueError, TypeError, KeyError):
                raise ParameterError(
                    f"line {number} of {str(self.path)!r} is damaged: delete the line and it is "
                    "computed again", parameter="resume", value=str(self.path)) from None
            size += len(line)
        self._file.truncate(size)

    def add(self, part: int, rows: list) -> None:
        """Keep the rows of a finished part."""
        self._write(_line({"part": part, "rows": rows}))

    def close(self) -> None:
        """Close the file; it stays."""
        self._file.close()

    def _write(self, line: bytes) -> None:
        # past Python's buffer it survives the end of this process
        self._file.write(line)
        self._file.flush()


def _line(data: dict[str, Any]) -> bytes:
    return (json.dumps(data) + "\n").encode()


def _holds(first: bytes) -> str:
    try:
        header = json.loads(first)
        return f"another study ({header['study']})" if header["format"] == _FORMAT else "other data"
    except (ValueError, TypeError, KeyError):
        return "other data"
