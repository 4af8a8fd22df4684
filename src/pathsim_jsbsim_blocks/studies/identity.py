"""What a study's rows depend on, part by part: kept rows are resumed for the same study only."""

from __future__ import annotations

import ast
import dis
import functools
import hashlib
import json
import sys
import types
from collections.abc import Iterable, Iterator, Mapping, Sequence
from importlib.machinery import PathFinder
from importlib.metadata import version
from importlib.util import resolve_name
from pathlib import Path
from typing import Any

from .. import __version__

# characters; a longer part, a list or a dict is represented by its checksum
_LONGEST = 40


def study_key(parts: Mapping[str, Any]) -> dict[str, str]:
    """A text for each part of a study, and for the versions of what computes it.

    ``parts`` has everything that the rows depend on, as plain data, by the user's names.
    """
    versions = {name: version(name) for name in ("jsbsim", "pathsim")}
    versions["pathsim-jsbsim-blocks"] = __version__
    return versions | {name: _text(value) for name, value in parts.items()}


def _text(value: Any) -> str:
    text = value if isinstance(value, str) else json.dumps(value, sort_keys=True)
    return _checksum(text) if isinstance(value, (list, dict)) or len(text) > _LONGEST else text


def differences(kept: Mapping[str, str], wanted: Mapping[str, str]) -> str:
    """The parts that differ, in words; nothing where the keys are those of unlike studies."""
    if set(kept) != set(wanted):
        return ""
    found = []
    for name, now in wanted.items():
        values = "" if "sha256" in kept[name] + now else f" (kept {kept[name]}, now {now})"
        found += [name + values] if kept[name] != now else []
    return ", ".join(found)


def code(function: Any) -> str:
    """Checksum of what a function does.

    That is its byte code and constants, the values of its defaults, its closure and the global
    variables it uses, and the same of the functions and classes among them. The user's modules
    count by their files, installed ones by their names.
    """
    return _checksum(_Walk().form(function))


def imported(file: Path) -> dict[str, str]:
    """Checksums of the user's modules that a script imports, and of those that they import."""
    return _modules(_imports(file, ""), [str(file.parent), *sys.path])


def _modules(names: Iterable[str], path: Sequence[str]) -> dict[str, str]:
    found: dict[str, str] = {}
    todo = list(names)
    for name in todo:
        parent = name.rpartition(".")[0]
        if parent and parent not in todo:
            todo.append(parent)
        file = _find(name, path)
        if file and name not in found:
            found[name] = hashlib.sha256(file.read_bytes()).hexdigest()
            package = name if file.stem == "__init__" else parent
            todo += _imports(file, package)
    return found


def _imports(file: Path, package: str) -> list[str]:
    """Names that a file may import as modules: of ``from a import b``, a and a.b."""
    if file.suffix != ".py":
        return []
    try:
        nodes = list(ast.walk(ast.parse(file.read_bytes())))
    except (SyntaxError, ValueError):
        return []
    names = [alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names]
    for node in nodes:
        if isinstance(node, ast.ImportFrom) and (package or not node.level):
            try:
                module = resolve_name("." * node.level + (node.module or ""), package)
            except ImportError:  # above the package
                continue
            names += [module, *(f"{module}.{alias.name}" for alias in node.names)]
    return names


def _find(name: str, path: Sequence[str] | None) -> Path | None:
    """The file of a module of the user's."""
    top, *rest = name.split(".")
    if _is_known(top):
        return None
    spec = PathFinder.find_spec(top, path)
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return None
        spec = PathFinder.find_spec(f"{spec.name}.{part}", list(spec.submodule_search_locations))
    origin = spec.origin if spec else None
    return Path(origin) if origin and not _is_installed(origin) else None


def _checksum(text: str) -> str:
    return f"sha256 {hashlib.sha256(text.encode()).hexdigest()}"


# what makes a value, by its type; co_exceptiontable is there from Python 3.11 on
_INSIDE: dict[type, tuple[str, ...]] = {
    types.CodeType: ("co_code", "co_names", "co_consts", "co_exceptiontable"),
    functools.partial: ("func", "args", "keywords"),
    types.MethodType: ("__func__", "__self__"),
    staticmethod: ("__func__",),
    classmethod: ("__func__",),
    property: ("fget", "fset"),
}


class _Walk:
    """Texts of values: the same in any process for functions that do the same."""

    def __init__(self) -> None:
        # by id; kept, so that no later value gets the same one
        self._met: dict[int, Any] = {}

    def form(self, value: Any) -> str:
        if value is None or isinstance(value, (bool, int, float, complex, str, bytes)):
            return repr(value)
        if id(value) in self._met:
            return "..."
        # equal constants may or may not be one object
        if not isinstance(value, (tuple, frozenset, types.CodeType)):
            self._met[id(value)] = value
        return f"{type(value).__name__}({', '.join(self._parts(value))})"

    def _parts(self, value: Any) -> Iterator[str]:
        if names := next((n for kind, n in _INSIDE.items() if isinstance(value, kind)), ()):
            yield from (self.form(getattr(value, name, None)) for name in names)
        elif isinstance(value, (list, tuple)):
            yield from map(self.form, value)
        elif isinstance(value, (set, frozenset)):
            yield from sorted(map(self.form, value))
        elif isinstance(value, Mapping):
            yield from (f"{self.form(k)}: {self.form(x)}" for k, x in value.items())
        elif isinstance(value, types.ModuleType):
            yield value.__name__
            yield repr(_modules([value.__name__], sys.path))
        elif isinstance(value, types.FunctionType) and _is_users(value):
            yield from map(self.form, (value.__code__, value.__defaults__, value.__kwdefaults__))
            yield from map(self.form, _closure(value))
            yield from map(self.form, _globals(value))
            yield repr(_modules(_reads(value.__code__, "IMPORT_NAME"), sys.path))
        elif isinstance(value, type) and _is_users(value):
            yield from map(self.form, value.__bases__)
            own = set(vars(value)) - set(vars(_Empty))
            yield from (f"{name}: {self.form(vars(value)[name])}" for name in sorted(own))
        elif hasattr(value, "__qualname__"):
            yield f"{getattr(value, '__module__', '')}.{value.__qualname__}"
        elif _is_users(type(value)) and hasattr(value, "__dict__"):
            yield from map(self.form, (type(value), vars(value)))
        else:
            yield _content(value)


class _Empty:
    pass


def _is_users(value: Any) -> bool:
    """Whether a function or class is the user's, whose code no version stands for."""
    name = value.__module__ or "__main__"
    file = getattr(sys.modules.get(name), "__file__", None) or ""
    return not _is_known(name.partition(".")[0]) and not _is_installed(file)


def _is_known(top: str) -> bool:
    return top in sys.stdlib_module_names or top == __package__.partition(".")[0]


def _is_installed(file: str) -> bool:
    return "site-packages" in file or "dist-packages" in file


def _closure(function: types.FunctionType) -> Iterator[Any]:
    for cell in function.__closure__ or ():
        try:
            yield cell.cell_contents
        except ValueError:  # not assigned yet
            yield None


def _globals(function: types.FunctionType) -> Iterator[Any]:
    """Values of the global variables that a function reads, those of functions inside it too."""
    names = _reads(function.__code__, "LOAD_GLOBAL", "LOAD_NAME")
    return (function.__globals__[name] for name in names if name in function.__globals__)


def _reads(code: types.CodeType, *operations: str) -> list[str]:
    """Names that operations of a function take, those of functions inside it too."""
    names: dict[str, None] = {}
    codes = [code]
    for code in codes:
        codes += [x for x in code.co_consts if isinstance(x, types.CodeType)]
        instructions = (i for i in dis.get_instructions(code) if i.opname in operations)
        names |= dict.fromkeys(i.argval for i in instructions)
    return list(names)


def _content(value: Any) -> str:
    """Checksum of an object of an installed class."""
    import joblib

    try:
        return joblib.hash(value)
    except Exception:  # it cannot be pickled
        return ""
