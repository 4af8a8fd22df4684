"""Scripts as templates: constants and parameters of blocks are set before the script builds them.

The script's source is not evaluated twice, and nothing is changed after the fact: what the script
derives from a value that is set, it derives from the new one.
"""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import sys
import types
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from ..errors import ParameterError
from .checks import did_you_mean, nearest, refuse

_NAME = re.compile(r"([A-Za-z_]\w*)(?:\.([A-Za-z_]\w*))?")
_SET, _BUILD, _SEEDED = "__set__", "__build__", "__seeded__"
_SCOPES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.Lambda)
_LITERAL = (
    ast.Expression,
    ast.Constant,
    ast.UnaryOp,
    ast.BinOp,
    ast.operator,
    ast.unaryop,
    ast.List,
    ast.Tuple,
    ast.Dict,
    ast.expr_context,
)


class SettingError(ParameterError):
    """A setting that the script has no place for, whatever its value."""


def _no_place(name: str, reason: str, value: Any) -> SettingError:
    return SettingError(f"cannot set {name!r}: {reason}", parameter=name, value=value)


class Text(str):
    """A value as it is typed on the command line; what it replaces tells how to read it."""

    def read(self, name: str, replaced: Any) -> Any:
        """The value: a number, list, ... in Python's notation, such as ``1/120``, or the text.

        Raises
        ------
        ParameterError
            for a text where the script has a value of another kind
        """
        text = str(self)
        try:
            tree = ast.parse(text.strip(), mode="eval")
            # 9**9**9**9 would never end
            if any(not isinstance(n, _LITERAL) or isinstance(n, ast.Pow) for n in ast.walk(tree)):
                raise ValueError
            value = eval(compile(tree, "<setting>", "eval"), {"__builtins__": {}})
        except (SyntaxError, ValueError, TypeError, ArithmeticError, MemoryError, RecursionError):
            value = ...
        if isinstance(replaced, str):
            # "737" is an aircraft
            return value if isinstance(value, (str, dict, list, tuple)) else text
        if value is ...:
            if replaced is None or replaced is inspect.Parameter.empty:
                return text
            refuse(
                name,
                text,
                f"cannot set {name!r}: {text!r} is not a Python value such as 3.5, 1/120, True or "
                f"[1, 2]; it replaces {replaced!r}",
            )
        return value


class Template:
    """A script, with settings that take effect when it runs.

    Parameters
    ----------
    path : Path
        the script; shown in tracebacks
    settings : mapping
        values by name: ``"NAME"`` is a variable that the script assigns at its top level,
        ``"NAME.PARAMETER"`` an argument of the call from which it assigns a block (or anything
        else) to NAME, at any level, whether the script gives it or leaves it at its default
    source : str, optional
        the script's text; default is the file's

    Attributes
    ----------
    seeded : list
        what the script has built with a ``seed`` that follows from the settings

    Raises
    ------
    SettingError
        for a variable that the script does not have, naming the nearest, or never reads
    SyntaxError, OSError
        if the script is not Python or cannot be read
    """

    def __init__(self, path: Path, settings: Mapping[str, Any] = {}, source: str | None = None):
        self.path = path
        if source is None:
            source = importlib.util.decode_source(path.read_bytes())
        tree = ast.parse(source, str(path))
        self._top = _assigned(_top_level(tree.body))
        self._anywhere = _assigned(ast.walk(tree))
        self._constants: dict[str, Any] = {}
        self._parameters: dict[str, dict[str, Any]] = {}
        for name, value in settings.items():
            self._place(name, value, tree)
        self._settings, self._waiting = dict(settings), set(settings)
        self.seeded: list[Any] = []
        if settings:
            tree = ast.fix_missing_locations(
                _Rewriter(self._constants, self._parameters).apply(tree)
            )
        self._code = compile(tree, str(path), "exec", dont_inherit=True)

    def has_constant(self, name: str) -> bool:
        """Whether the script assigns a variable at its top level."""
        return name in self._top

    def _place(self, name: str, value: Any, tree: ast.Module) -> None:
        match = _NAME.fullmatch(name) if isinstance(name, str) else None
        if match is None:
            raise _no_place(name, "a name is NAME or BLOCK.PARAMETER", value)
        variable, parameter = match.groups()
        if parameter is not None:
            if not self._anywhere.get(variable):
                blocks = [n for n, calls in self._anywhere.items() if calls]
                reason = f"{self.path.name} assigns no block to {variable!r}"
                if variable in self._anywhere:
                    reason = f"{variable!r} is not the result of one call in {self.path.name}"
                raise _no_place(name, reason + _nearest_of(variable, blocks), value)
            for node in ast.walk(tree):
                if (
                    isinstance(node, ast.Attribute)
                    and isinstance(node.ctx, ast.Store)
                    and node.attr == parameter
                    and isinstance(node.value, ast.Name)
                    and node.value.id == variable
                ):
                    raise _no_place(
                        name, f"{self.path.name} sets it itself, in line {node.lineno}", value
                    )
            self._parameters.setdefault(variable, {})[parameter] = value
            return
        if variable not in self._top:
            reason = f"{self.path.name} assigns no {variable!r} at its top level"
            blocks = [
                f"{block}.{variable}"
                for block, calls in self._anywhere.items()
                if any(keyword.arg == variable for call in calls for keyword in call.keywords)
            ]
            raise _no_place(
                name, reason + (did_you_mean(blocks) or _nearest_of(variable, self._top)), value
            )
        if not any(isinstance(n.ctx, ast.Load) for n in _uses(variable, ast.walk(tree))):
            raise _no_place(name, f"{self.path.name} never uses it", value)
        for node in ast.walk(tree):
            if isinstance(node, ast.Global) and variable in node.names:
                reason = f"a function of {self.path.name} changes it (line {node.lineno})"
                raise _no_place(name, reason, value)
        plain = {id(n) for a in ast.walk(tree) for n in _targets(a)}
        for node in _uses(variable, _top_level(tree.body)):
            if not isinstance(node.ctx, ast.Load) and id(node) not in plain:
                raise _no_place(name, f"{self.path.name} changes it in line {node.lineno}", value)
        self._constants[variable] = value

    def load(self) -> types.ModuleType:
        """Import the script as a module of its own; errors are those of `run`."""
        spec = importlib.util.spec_from_file_location(self.path.stem, self.path)
        assert spec is not None
        module = importlib.util.module_from_spec(spec)
        self.run(module)
        return module

    def run(self, module: types.ModuleType) -> None:
        """Execute the script in a module.

        Raises
        ------
        SettingError
            for a parameter that the call does not have, naming the nearest, and for a setting that
            the script has not come across
        Exception
            whatever the script raises
        """
        setattr(module, _SET, self._set)
        setattr(module, _BUILD, self._build)
        setattr(module, _SEEDED, self._seeded)
        exec(self._code, vars(module))
        for name in sorted(self._waiting):
            raise _no_place(
                name, f"{self.path.name} has not come to the line that has it", self._settings[name]
            )

    def _set(self, name: str, replaced: Any) -> Any:
        value = self._constants[name]
        if isinstance(replaced, (Block, Connection, Event, Simulation)):
            kind = type(replaced)
            parameters = _named(inspect.signature(kind))
            example = f", such as {name}.{next(iter(parameters))}" if parameters else ""
            raise _no_place(
                name, f"it is of class {kind.__name__}: set a parameter of it{example}", value
            )
        self._waiting.discard(name)
        return _read(name, value, replaced)

    def _build(self, variable: str, make: Callable[..., Any], *args: Any, **kwargs: Any) -> Any:
        given = self._parameters[variable]
        first = next(iter(given))
        try:
            signature = inspect.signature(make)
        except (TypeError, ValueError):
            raise _no_place(
                f"{variable}.{first}", f"the parameters of {make!r} are not known", given[first]
            ) from None
        known = _named(signature)
        try:
            bound = signature.bind_partial(*args, **kwargs)
        except TypeError:
            return make(*args, **kwargs)  # which says what is wrong
        # a function may pass further keywords on
        passed: dict[str, Any] = next(
            (
                bound.arguments.get(n, {})
                for n, p in signature.parameters.items()
                if p.kind is p.VAR_KEYWORD
            ),
            {},
        )
        for parameter, value in given.items():
            name = f"{variable}.{parameter}"
            if parameter in known:
                replaced = bound.arguments.get(parameter, known[parameter].default)
                bound.arguments[parameter] = _read(name, value, replaced)
            elif parameter in passed:
                passed[parameter] = _read(name, value, passed[parameter])
            else:
                what = getattr(make, "__name__", repr(make))
                reason = f"{what} has no parameter {parameter!r}"
                raise _no_place(name, reason + _nearest_of(parameter, [*known, *passed]), value)
            self._waiting.discard(name)
        made = make(*bound.args, **bound.kwargs)
        return self._seeded(made) if "seed" in given else made

    def _seeded(self, made: Any) -> Any:
        self.seeded.append(made)
        return made


def _read(name: str, value: Any, replaced: Any) -> Any:
    return value.read(name, replaced) if isinstance(value, Text) else value


def _nearest_of(name: str, names: Iterable[str]) -> str:
    names = list(names)
    close = nearest(name, names)
    return did_you_mean(close) if close or not names else f"; there is {', '.join(names)}"


def _uses(variable: str, nodes: Iterable[ast.AST]) -> list[ast.Name]:
    return [n for n in nodes if isinstance(n, ast.Name) and n.id == variable]


def _named(signature: inspect.Signature) -> dict[str, inspect.Parameter]:
    """Parameters that have a name for the caller."""
    return {
        n: p
        for n, p in signature.parameters.items()
        if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)
    }


def _top_level(body: Iterable[ast.AST]) -> Iterator[ast.AST]:
    """Statements and expressions outside functions and classes."""
    for node in body:
        yield node
        if not isinstance(node, _SCOPES):
            yield from _top_level(ast.iter_child_nodes(node))


def _assigned(nodes: Iterable[ast.AST]) -> dict[str, list[ast.Call]]:
    """Variables that are assigned, with the calls whose results they are."""
    found: dict[str, list[ast.Call]] = {}
    for node in nodes:
        for target, value in _pairs(node):
            calls = found.setdefault(target.id, [])
            if isinstance(value, ast.Call):
                calls.append(value)
    return found


def _targets(node: ast.AST) -> list[ast.Name]:
    """The variables that a plain assignment sets."""
    return [target for target, _ in _pairs(node)]


def _pairs(node: ast.AST) -> Iterator[tuple[ast.Name, ast.expr]]:
    """Variables and expressions of an assignment, those of ``a, b = 1, 2`` one by one."""
    if isinstance(node, ast.Assign):
        for target in node.targets:
            yield from _matched(target, node.value)
    elif isinstance(node, (ast.AnnAssign, ast.NamedExpr)) and node.value is not None:
        yield from _matched(node.target, node.value)


def _matched(target: ast.expr, value: ast.expr) -> Iterator[tuple[ast.Name, ast.expr]]:
    if isinstance(target, ast.Name):
        yield target, value
    elif (
        isinstance(target, (ast.Tuple, ast.List))
        and isinstance(value, (ast.Tuple, ast.List))
        and len(target.elts) == len(value.elts)
    ):
        for inner, part in zip(target.elts, value.elts, strict=True):
            yield from _matched(inner, part)


def _following(names: Iterable[str], tree: ast.AST) -> set[str]:
    """The variables whose values follow from those of ``names``, these included."""
    found = set(names)
    while True:
        more = set(found)
        for node in ast.walk(tree):
            value = getattr(node, "value", None) or getattr(node, "iter", None)
            targets = getattr(node, "targets", None) or [getattr(node, "target", None)]
            if isinstance(value, ast.AST) and _reads(found, value):
                more |= {n.id for t in targets if t for n in ast.walk(t) if isinstance(n, ast.Name)}
        if more == found:
            return found
        found = more


def _reads(names: Container[str], expression: ast.AST) -> bool:
    return any(isinstance(n, ast.Name) and n.id in names for n in ast.walk(expression))


class _Rewriter(ast.NodeTransformer):
    """``NAME = x`` becomes ``NAME = __set__("NAME", x)``, ``f(x)`` ``__build__("NAME", f, x)``.

    A call with a ``seed`` that follows from a constant that is set becomes ``__seeded__(f(x))``.
    """

    def __init__(self, constants: Mapping[str, Any], parameters: Mapping[str, Any]):
        self._constants, self._parameters = constants, parameters
        self._of: dict[ast.expr, tuple[str, str]] = {}

    def apply(self, tree: ast.Module) -> ast.Module:
        for node in _top_level(tree.body):
            for target, value in _pairs(node):
                if target.id in self._constants:
                    self._of[value] = _SET, target.id
        for node in ast.walk(tree):
            for target, value in _pairs(node):
                if target.id in self._parameters and isinstance(value, ast.Call):
                    self._of[value] = _BUILD, target.id
        following = _following(self._constants, tree)
        self._seeded = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.Call)
            and any(k.arg == "seed" and _reads(following, k.value) for k in node.keywords)
        ]
        return self.visit(tree)

    def visit(self, node: ast.AST) -> Any:
        new = self._rewritten(node)
        if node in self._seeded:
            new = ast.copy_location(ast.Call(ast.Name(_SEEDED, ast.Load()), [new], []), new)
        return new

    def _rewritten(self, node: ast.AST) -> Any:
        self.generic_visit(node)
        function, variable = self._of.get(node, ("", ""))  # type: ignore[call-overload]
        if not function:
            return node
        called, name = ast.Name(function, ast.Load()), ast.Constant(variable)
        if function == _BUILD:
            new = ast.Call(called, [name, node.func, *node.args], node.keywords)  # type: ignore
        else:
            new = ast.Call(called, [name, node], [])  # type: ignore[list-item]
        return ast.copy_location(new, node)


def main_program(template: Template) -> dict[str, Any]:
    """Run a script as the main program; returns its variables."""
    module = types.ModuleType("__main__")
    module.__file__ = str(template.path)
    before = sys.modules["__main__"]
    # classes that the script defines look up their module by name
    sys.modules["__main__"] = module
    try:
        template.run(module)
    finally:
        sys.modules["__main__"] = before
    return vars(module)
