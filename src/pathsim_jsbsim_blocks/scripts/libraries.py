"""What a script changes in the libraries that its diagram uses."""

from __future__ import annotations

import ast
import contextlib
import importlib
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import Any

_OURS = __name__.partition(".")[0]
_OF_DIAGRAMS = {_OURS, "builtins", "jsbsim", "math", "numpy", "pathsim", "random", "scipy"}


class Libraries:
    """Modules and classes of PathSim, its toolboxes and numpy, as they are before a script.

    Toolboxes that the script imports are imported before it, so that changes to them can be seen.
    """

    def __init__(self, tree: ast.Module):
        for node in ast.walk(tree):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            for name in filter(_of_diagrams, names):
                with contextlib.suppress(ImportError):
                    # a package may load its parts when it is asked for a name
                    dir(importlib.import_module(name))
        self._before = {name: (holder, dict(vars(holder))) for name, holder in _holders()}

    def __enter__(self) -> Libraries:
        return self

    def __exit__(self, *_: Any) -> None:
        """Undo the changes: the process may go on to other scripts."""
        for where, name, value in self._changes():
            if value is ...:
                delattr(self._before[where][0], name)
            else:
                setattr(self._before[where][0], name, value)

    def changed(self) -> list[str]:
        """Names of functions, classes and values that are others now, ``module.name``."""
        return [f"{where}.{name}" for where, name, _ in self._changes()]

    def _changes(self) -> list[tuple[str, str, Any]]:
        return [
            (where, name, value)
            for where, (holder, before) in self._before.items()
            for name, now in {**dict.fromkeys(before, ...), **vars(holder)}.items()
            if now is not (value := before.get(name, ...))
            and not (value is ... and isinstance(holder, ModuleType) and _is_loaded(now))
            # caches and flags are private
            and (not name.startswith("_") or callable(now) or callable(value))
        ]


def _of_diagrams(module: str) -> bool:
    package = module.partition(".")[0]
    return package in _OF_DIAGRAMS or package.startswith("pathsim_")


def _is_loaded(value: Any) -> bool:
    """Whether a module may have got a value by an import, as it may at any time."""
    return isinstance(value, ModuleType) or _of_diagrams(getattr(value, "__module__", None) or "")


def _holders() -> Iterator[tuple[str, Any]]:
    """Modules and their classes, by name."""
    for name, module in list(sys.modules.items()):
        if _of_diagrams(name) and module is not None:
            yield name, module
            for key, value in list(vars(module).items()):
                if isinstance(value, type) and value.__module__ == name:
                    yield f"{name}.{key}", value
