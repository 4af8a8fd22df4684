"""What the kept rows of a study belong to: texts and values. Code is not analysed."""

from __future__ import annotations

import dis
import functools
import hashlib
import inspect
import json
import os
import platform
import re
import sysconfig
import types
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from .. import __version__
from .._core.checks import refuse

# characters; a longer value, a list or a dict is represented by its checksum
_LONGEST = 40

_SUM = "checksum"

# where decorators keep the function that they stand for: functools, np.vectorize
_WRAPPED = ("__wrapped__", "pyfunc")


def study_key(parts: Mapping[str, Any]) -> dict[str, str]:
    """A text for each part of a study, and for the versions of what computes it.

    ``parts`` has everything that the rows depend on, as plain data, by the user's names.
    """
    versions = {name: version(name) for name in ("jsbsim", "pathsim")}
    versions |= {"pathsim-jsbsim-blocks": __version__, "Python": platform.python_version()}
    return versions | {name: _short(value) for name, value in parts.items()}


def _short(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
    is_long = isinstance(value, (list, dict)) or len(text) > _LONGEST
    return _checksum(text.encode()) if is_long else text


def _checksum(content: bytes) -> str:
    return f"{_SUM} {hashlib.sha256(content).hexdigest()}"


def differences(kept: Mapping[str, str], wanted: Mapping[str, str]) -> str:
    """The parts that differ, in words."""
    found = []
    for name in {**wanted, **kept}:
        before, now = kept.get(name, "nothing"), wanted.get(name, "nothing")
        if before != now:
            found.append(name if _SUM in before + now else f"{name} (kept {before}, now {now})")
    return ", ".join(found)


def texts(file: Path, folder: Path) -> dict[str, str]:
    """Checksum of a file, and of the modules below a folder that its import lines name."""
    found, todo = {}, [file]
    for path in todo:
        content = path.read_bytes()
        shown = path.relative_to(folder) if path.is_relative_to(folder) else path
        found[f"text of {shown.as_posix()}"] = _checksum(content)
        lines = re.findall(rb"^\s*(?:import|from)\s.*", content, re.MULTILINE)
        near = [parent for parent in path.parents if parent.is_relative_to(folder)]
        for word in {
            word.decode() for line in lines for word in re.findall(rb"[a-zA-Z_]\w*", line)
        }:
            for base in near:
                modules = [base / f"{word}.py", *sorted((base / word).rglob("*.py"))]
                todo += [x for x in modules if x.is_file() and x not in todo]
    return dict(sorted(found.items()))


def of_models(root: Any, aircraft: str = "") -> dict[str, str]:
    """Checksums of the XML files of a JSBSim root: of one aircraft, of engines and systems.

    Of what is no root there are none.
    """
    if not (isinstance(root, (str, os.PathLike)) and root and os.path.isdir(f"{root}/aircraft")):
        return {}
    folders = (Path(root, *names) for names in (("aircraft", aircraft), ("engine",), ("systems",)))
    files = [file for folder in folders for file in sorted(folder.rglob("*.xml")) if file.is_file()]
    return {f"text of {x.relative_to(root).as_posix()}": _checksum(x.read_bytes()) for x in files}


def of_function(name: str, function: Any) -> dict[str, str]:
    """Parts of a key for a function: its text, and the values that it brings along.

    These are the arguments of a partial, defaults, captured and global variables; the folder of a
    JSBSim root brings the texts of its models along. The text of a function is that of its file and
    of modules beside it, in a notebook its own.

    Raises
    ------
    ParameterError
        for a function without a text, and for a value that cannot be pickled
    """
    found: dict[str, str] = {}
    met: list[Any] = []
    todo = [(name, function)]
    for label, value in todo:
        wrapped = next((getattr(value, x) for x in _WRAPPED if hasattr(value, x)), None)
        if isinstance(value, (types.FunctionType, type)):
            if value not in met and (value is function or not _is_installed(value)):
                met.append(value)
                found |= _text(label, value)
                todo += _brought(label, value)
        elif isinstance(value, functools.partial):
            arguments: dict[Any, Any] = {**dict(enumerate(value.args)), **value.keywords}
            todo += [(label, value.func), *((f"{label}: {k}", x) for k, x in arguments.items())]
        elif inspect.ismethod(value):
            todo += [(label, value.__func__), (f"{label}: self", value.__self__)]
        elif wrapped is not None:
            todo.append((label, wrapped))
        elif not isinstance(value, (types.ModuleType, types.BuiltinFunctionType)):
            found |= {label: _shown(label, value), **of_models(value)}
            if callable(value):
                todo.append((label + "'s class", type(value)))
    return found


def _is_installed(function: Any) -> bool:
    """Whether a function or class has a version of its own, as those of libraries have."""
    top = (function.__module__ or "").partition(".")[0]
    try:
        file = inspect.getfile(function)
    except (TypeError, OSError):  # built in, or a class of a notebook
        return top != "__main__"
    libraries = (sysconfig.get_path("stdlib"), "site-packages", "dist-packages")
    return top == __package__.partition(".")[0] or any(x in file for x in libraries)


def _text(label: str, function: Any) -> dict[str, str]:
    try:
        file = Path(inspect.getfile(function)).absolute()
        if file.is_file():
            return texts(file, file.parents[function.__module__.count(".")])
        return {f"text of {label}": _checksum(inspect.getsource(function).encode())}
    except (TypeError, OSError):
        why = f"{label} has no text to compare: with resume it must be in a file or a notebook"
        refuse("resume", function, why)


def _brought(label: str, function: Any) -> Iterator[tuple[str, Any]]:
    """Values that come with a function: defaults, captured variables, global variables."""
    if isinstance(function, type):
        return
    for name, parameter in inspect.signature(function, follow_wrapped=False).parameters.items():
        if parameter.default is not parameter.empty:
            yield f"{label}: default of {name}", parameter.default
    captured = zip(function.__code__.co_freevars, function.__closure__ or (), strict=True)
    for name, cell in captured:
        try:
            yield f"{label}: {name}", cell.cell_contents
        except ValueError:  # not assigned yet
            continue
    codes = [function.__code__]
    for code in codes:
        codes += [x for x in code.co_consts if isinstance(x, types.CodeType)]
        for step in dis.get_instructions(code):
            if step.opname == "LOAD_GLOBAL" and step.argval in function.__globals__:
                yield f"{label}: {step.argval}", function.__globals__[step.argval]


def _shown(label: str, value: Any) -> str:
    """A number or a short text as it is, any other value by its checksum."""
    import joblib

    if value is None or isinstance(value, (bool, int, float, str)):
        return _short(repr(value))
    try:
        return f"{_SUM} {joblib.hash(value)}"
    except Exception as error:
        refuse("resume", value, f"{label} cannot be compared with resume: {error}")
