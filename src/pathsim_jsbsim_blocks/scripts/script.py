"""A script, loaded as a module or run as the main program, with values and calls of interest."""

from __future__ import annotations

import ast
import importlib.util
import sys
import threading
import types
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest.mock import patch

from .names import used
from .settings import Settings

# stay in the script's namespace: its functions also call them later; not names of methods, which
# would hide them in a class
FOLLOWING = _CALL, _SET = "__script_call__", "__script_set__"
_LOADING = threading.RLock()  # `main_program` replaces values of the whole process
_SCOPE_READERS = {"globals", "locals", "vars", "dir", "eval", "exec", "super"}


class Script:
    """A script's text, with settings that take effect when it runs; see `Settings`.

    ``source`` is its text instead of the file's; with ``followed`` all its calls go through
    `_call`, which a subclass extends. ``tree`` is its syntax tree; ``seeded`` are the objects that
    it has built with a ``seed`` that depends on the settings.
    """

    def __init__(
        self,
        path: Path,
        settings: Mapping[str, Any] = {},
        source: str | None = None,
        followed: bool = False,
    ):
        self.path = path
        self.source = importlib.util.decode_source(path.read_bytes()) if source is None else source
        self.tree = ast.parse(self.source, str(path))
        self.seeded: list[Any] = []
        self._settings = Settings(path.name, self.tree, settings)
        tree = ast.parse(self.source)
        originals = dict(zip(ast.walk(tree), ast.walk(self.tree), strict=True))
        rewriter = _Rewriter(originals, self._settings, followed)
        if settings or followed:
            tree = ast.fix_missing_locations(rewriter.visit(tree))
        self._calls = rewriter.calls
        self._code = compile(tree, str(path), "exec", dont_inherit=True)

    def has_constant(self, name: str) -> bool:
        """Whether the script assigns a variable at its top level, and reads it."""
        return name in self._settings.assigned and name in used(self.tree)

    def load(self) -> types.ModuleType:
        """Import the script as a separate module; errors are those of `run`."""
        with _LOADING, main_program(self.path, self.path.stem) as module:
            self.run(module)
        return module

    def run(self, module: types.ModuleType) -> None:
        """Execute the script in a module; a `SettingError` names a setting that was not used."""
        setattr(module, _CALL, self._call)
        setattr(module, _SET, self._settings.constant)
        exec(self._code, vars(module))
        self._settings.refuse_unused()

    def _call(self, index: bytes, make: Any, /, *args: Any, **kwargs: Any) -> Any:
        """Make a call of the script: of the expression ``_calls[index]``."""
        node, settings = self._calls[int(index)], self._settings
        if node in settings.calls:
            args, kwargs = settings.arguments(settings.calls[node], make, args, kwargs)
        part = make(*args, **kwargs)
        if node in settings.seeding:
            self.seeded.append(part)
        return part


class _Rewriter(ast.NodeTransformer):
    """Makes ``_CALL(i, f, x)`` of ``f(x)``, and ``NAME = _SET("NAME", x)`` of ``NAME = x``.

    With ``every``, all calls are passed on.
    """

    def __init__(self, originals: Mapping[ast.AST, ast.AST], settings: Settings, every: bool):
        self._originals, self._settings, self._every = originals, settings, every
        self.calls: list[ast.Call] = []  # those passed on, by number

    def visit(self, node: ast.AST) -> Any:
        original: Any = self._originals[node]
        new = self.generic_visit(node)
        if isinstance(new, ast.Call) and self._is_followed(original):
            number = self._number(original)
            new = _call(_CALL, number, new.func, *new.args, keywords=new.keywords)
        if original in self._settings.constants:
            new = _call(_SET, ast.Constant(self._settings.constants[original]), new)
        return ast.copy_location(new, node)

    def _is_followed(self, call: Any) -> bool:
        if self._every:
            return getattr(call.func, "id", "") not in _SCOPE_READERS
        return call in self._settings.calls or call in self._settings.seeding

    def _number(self, call: Any) -> ast.Constant:
        self.calls.append(call)
        # as bytes, so that the numbers among a function's constants stay the script's own
        return ast.Constant(b"%d" % (len(self.calls) - 1))


def _call(name: str, *args: Any, keywords: Sequence[ast.keyword] = ()) -> ast.Call:
    return ast.Call(ast.Name(name, ast.Load()), list(args), list(keywords))


@contextmanager
def main_program(path: Path, name: str = "__main__") -> Iterator[types.ModuleType]:
    """A module that is the main program: no arguments, its folder first in ``sys.path``."""
    module = types.ModuleType(name)
    module.__file__ = str(path)
    folder = path.resolve().parent
    modules = dict(sys.modules)
    with (
        patch.object(sys, "argv", [str(path)]),
        patch.object(sys, "path", [str(folder), *sys.path]),
    ):
        # classes that a script defines look up their module by name
        if name == "__main__" or name not in modules:
            sys.modules[name] = module
        try:
            yield module
        finally:
            sys.modules.pop(name, None)
            # unload them: another script's folder may have other modules of the same names
            for entry in list(sys.modules):
                if entry.partition(".")[0] not in modules and is_beside(folder, entry):
                    del sys.modules[entry]
            if name in modules:
                sys.modules[name] = modules[name]


def is_beside(folder: Path, module: str) -> bool:
    """Whether a loaded module is a file or package in the folder of a script."""
    package = module.partition(".")[0]
    file = Path(getattr(sys.modules.get(module), "__file__", "") or "")
    # below the folder there may also be an environment with its libraries
    return folder / package in (file.parent / file.stem, *file.parents)
