"""A file that keeps the finished parts of a study, and the key that identifies the study."""

from __future__ import annotations

import contextlib
import functools
import hashlib
import inspect
import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, NoReturn

from .. import __version__
from .._core.checks import refuse
from .._core.extras import required
from .._core.files import as_path
from ..errors import FileError

_TITLE = "pathsim-jsbsim study, file format 5"
_MOST_FILES = 2000  # a home folder or an installation has more


class Journal:
    """Finished parts, one line each with its checksum; the first line has the key of the study.

    Floats are read back bit for bit. The file is locked while open. A ParameterError refuses a file
    that cannot be opened, is damaged or in use, or has another key.
    """

    def __init__(self, path: str | Path, key: Mapping[str, str]):
        lock = required("filelock", "studies").lock_descriptor
        self.path = as_path("resume", path)
        if os.path.exists(self.path) and not os.path.isfile(self.path):  # e.g. an endless device
            self._refuse("is not a file")
        try:  # unbuffered, so that finished lines survive a kill of this process
            self.file = self.path.open("a+b", buffering=0)
        except OSError as error:
            self._refuse(f"cannot be opened: {error.strerror}")
        try:
            with contextlib.suppress(OSError):  # a file system without locks
                if not lock(self.file.fileno(), blocking=False):
                    self._refuse("is in use: another process runs this study")
            self.file.seek(0)
            self.finished = self._parts(self.file.read(), {_TITLE: dict(key)})
        except BaseException:
            self.file.close()
            raise

    def _refuse(self, why: str) -> NoReturn:
        refuse("resume", str(self.path), f"{str(self.path)!r} {why}")

    def _parts(self, content: bytes, header: dict[str, Any]) -> dict[int, list]:
        if _line(header).startswith(content):  # new, or killed before the first line was complete
            self.file.truncate(0)
            self.write(header)
            return {}
        first, *lines = content.split(b"\n")
        if not content.startswith(_line(header)):
            why = "was not written by this version of this package"
            with contextlib.suppress(ValueError, KeyError, TypeError):
                why = f"is of another study: {_differences(_data(first)[_TITLE], header[_TITLE])}"
            self._refuse(f"{why}; name another file or delete it")
        parts = []
        for number, line in enumerate(lines[:-1], 2):  # the last one may be incomplete after a kill
            try:
                parts.append(_data(line))
            except ValueError:
                self._refuse(f"is damaged: delete line {number} and it is computed again")
        self.file.truncate(content.rindex(b"\n") + 1)
        return dict(parts)

    def write(self, data: Any) -> None:
        """Write a line: the key, or number and rows of a finished part."""
        line = _line(data)
        try:
            # a full disk may accept part of the line before it refuses the rest
            while line:
                line = line[self.file.write(line) :]
        except OSError as error:
            raise FileError("write", self.path, error, "; it keeps the finished parts") from None


def _line(data: Any) -> bytes:
    text = json.dumps(data).encode()
    return _checksum(text).encode() + b" " + text + b"\n"


def _data(line: bytes) -> Any:
    """Data of a line; ValueError if it does not match its checksum."""
    checksum, _, text = line.partition(b" ")
    if checksum.decode() != _checksum(text):
        raise ValueError
    return json.loads(text)


def _checksum(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _differences(old: Mapping[str, str], new: Mapping[str, str]) -> str:
    names = sorted(x for x in {*old, *new} if old.get(x) != new.get(x))
    kinds = ("new" if x not in old else "missing" if x not in new else "changed" for x in names)
    return ", ".join(f"{name} is {kind}" for name, kind in zip(names[:10], kinds, strict=False))


def study_key(parts: Mapping[str, Any]) -> dict[str, str]:
    """The key of a study: checksums of its parts, which are plain data, and versions."""
    versions = {"Python": sys.version, "pathsim-jsbsim-blocks": __version__}
    versions |= {name: version(name) for name in ("jsbsim", "pathsim")}
    sums = {name: _checksum(json.dumps(value).encode()) for name, value in parts.items()}
    return sums | {f"version of {name}": text for name, text in versions.items()}


def of_files(ending: str, folders: Iterable[Path]) -> dict[str, str]:
    """Checksums of all files below folders by their names, imported or not."""
    sums: dict[str, str] = {}
    try:
        for folder in folders:
            for count, file in enumerate(_files(ending, folder)):
                if count == _MOST_FILES:
                    why = f"{folder} has more than {count:,} {ending} files to compare"
                    refuse("resume", str(folder), f"{why}: move the study to a folder of its own")
                name = file.relative_to(folder.parent).as_posix()  # two folders may share it
                sums[name] = sums.get(name, "") + _checksum(file.read_bytes())
    except OSError as error:  # also for a module in a zip file
        raise FileError("read", error.filename, error) from None
    return sums


def _files(ending: str, folder: Path, parents: tuple[Path, ...] = ()) -> Iterator[Path]:
    """Files below a folder, in order, without hidden folders and virtual environments."""
    parents = (*parents, folder.resolve())  # following a link to one would never end
    for path in sorted(folder.iterdir()):
        if path.name.endswith(ending) and path.is_file():
            yield path
        elif path.is_dir() and path.name[0] != "." and path.resolve() not in parents:
            yield from () if (path / "pyvenv.cfg").exists() else _files(ending, path, parents)


def of_models(values: Iterable[Any]) -> dict[str, str]:
    """Checksums of the XML files below the JSBSim roots among ``values``."""
    texts = (x for x in values if isinstance(x, (str, Path)))
    roots = {Path(x).absolute() for x in texts if os.path.isdir(f"{x}/aircraft")}
    return of_files(".xml", sorted(roots))


def of_function(label: str, function: Any, folders: Any = (), values: Any = ()) -> dict[str, Any]:
    """Parts of a key for a function of a file, with further folders of code and arguments."""
    partial = function if isinstance(function, functools.partial) else functools.partial(function)
    target: Any = partial.func
    scope, name = getattr(target, "__globals__", {}), getattr(target, "__qualname__", "")
    plain = inspect.isfunction(target) and not target.__closure__ and scope.get(name) is target
    if not plain or target.__code__.co_filename != scope.get("__file__"):
        why = "not a lambda, method, closure, or function of a notebook"
        refuse("resume", function, f"with resume, {label} must be a function of a file, {why}")
    joblib = required("joblib", "studies")
    try:
        bound = inspect.signature(target).bind_partial(*partial.args, **partial.keywords)
        parts = {f"argument {n}": joblib.hash(x) for n, x in bound.arguments.items()}
    except Exception as error:
        refuse("resume", function, f"the arguments of {label} cannot be compared: {error}")
    bound.apply_defaults()
    code = of_files(".py", sorted({*folders, _folder(scope)}))
    return {label: name, **parts, **code, **of_models([*values, *bound.arguments.values()])}


def _folder(scope: Mapping[str, Any]) -> Path:
    """The folder of a module's top package, also if it is run by -m; a script's own folder."""
    file, spec = Path(scope["__file__"]).absolute(), scope.get("__spec__")
    top = (spec.name if spec else scope["__name__"]).partition(".")[0]
    packages = map(Path, getattr(sys.modules.get(top), "__path__", ()))
    return next((x for x in packages if file.is_relative_to(x)), file.parent)
