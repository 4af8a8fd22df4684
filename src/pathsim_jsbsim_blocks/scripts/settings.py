"""Values that a script is built with instead of its own.

The script's source is not evaluated twice, and nothing is changed after the fact: what the script
derives from a value that is set, it derives from the new one.
"""

from __future__ import annotations

import ast
import inspect
import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from typing import Any, NoReturn

from pathsim import Connection, Simulation
from pathsim.blocks import Block
from pathsim.events import Event

from .._core.checks import did_you_mean, nearest, refuse
from ..errors import ParameterError
from .names import assignments, bound, own, used

_NAME = re.compile(r"([A-Za-z_]\w*)(?:\.([A-Za-z_]\w*))?")
_NUMBER = (ast.Expression, ast.Constant, ast.UnaryOp, ast.BinOp, ast.operator, ast.unaryop)
_ASSIGNING = (ast.Assign, ast.AnnAssign, ast.NamedExpr)
_BINDING = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef, ast.alias)
_LITERAL = (*_NUMBER, ast.List, ast.Tuple, ast.Dict, ast.expr_context)


class SettingError(ParameterError):
    """A setting that the script does not offer, whatever its value."""


class Text(str):
    """A value as typed on the command line; the value that it replaces decides how to read it."""

    def read(self, name: str, original: Any) -> Any:
        """The value: a number, list, ... in Python's notation, such as ``1/120``, or the text."""
        text = str(self)
        try:
            tree = ast.parse(text.strip(), mode="eval")
            # 9**9**9**9 would never end
            if any(not isinstance(n, _LITERAL) or isinstance(n, ast.Pow) for n in ast.walk(tree)):
                raise ValueError
            value = eval(compile(tree, "<setting>", "eval"), {"__builtins__": {}})
        except (SyntaxError, ValueError, TypeError, ArithmeticError, MemoryError, RecursionError):
            value = ...
        if isinstance(original, str):
            # "737" is an aircraft
            return value if isinstance(value, (str, dict, list, tuple)) else text
        if value is ...:
            if original is None or original is inspect.Parameter.empty:
                return text
            why = f"{text!r} is not a Python value such as 3.5, 1/120, True or [1, 2]"
            refuse(name, text, f"cannot set {name!r}: {why}; it replaces {original!r}")
        return value


class Settings:
    """Values by name, and their places in a script.

    ``"NAME"`` is a constant that the script assigns once, at its top level; ``"BLOCK.PARAMETER"``
    is an argument of the call from which it assigns a block to the variable BLOCK, at any level,
    whether the script gives it or leaves it at its default. A `SettingError` for anything else
    lists what can be set.
    """

    def __init__(self, script: str, tree: ast.Module, values: Mapping[str, Any]):
        self._script, self._values, self._waiting = script, dict(values), set(values)
        constants = _constants(tree)
        self.assigned = constants.keys()
        calls = _calls(tree)
        for name in values:
            if reason := self._misplaced(name, tree, constants, calls):
                self._refuse(name, reason)
        # names of constants by the expressions that they are assigned
        self.constants = {constants[name]: name for name in values if name in constants}
        self._parameters: dict[str, list[str]] = {}  # by block
        for block, dot, parameter in (name.rpartition(".") for name in values):
            if dot:
                self._parameters.setdefault(block, []).append(parameter)
        # names of blocks by the calls that make them
        self.calls = {call: name for name in self._parameters for call in calls[name]}
        # calls with a seed that follows from the values
        self.seeding = {c for c, block in self.calls.items() if "seed" in self._parameters[block]}
        following = _following(self.constants.values(), tree)
        for call in (n for n in ast.walk(tree) if isinstance(n, ast.Call)):
            if any(k.arg == "seed" and _names(k.value) & following for k in call.keywords):
                self.seeding.add(call)

    def _refuse(self, name: Any, reason: str) -> NoReturn:
        raise SettingError(
            f"cannot set {name!r}: {reason}", parameter=name, value=self._values[name]
        )

    def _misplaced(
        self, name: Any, tree: ast.Module, constants: Collection[str], calls: Mapping[str, Any]
    ) -> str:
        """Reason why the script does not offer a setting; empty if it does."""
        match = _NAME.fullmatch(name) if isinstance(name, str) else None
        if match is None:
            return "a name is NAME or BLOCK.PARAMETER"
        variable, parameter = match.groups()
        if parameter is None:
            if variable not in constants:
                candidates = [
                    f"{block}.{variable}"
                    for block, nodes in calls.items()
                    if any(k.arg == variable for call in nodes for k in call.keywords)
                ]
                reason = f"{self._script} has no constant {variable!r} that it assigns once"
                names = [name for name in constants if name not in calls]
                return reason + (did_you_mean(candidates) or _listed(variable, names, calls))
            return "" if variable in used(tree) else f"{self._script} never uses it"
        if not calls.get(variable):
            reason = f"{self._script} assigns no block to {variable!r}"
            return reason + _listed(variable, calls)
        stores = (n for n in ast.walk(tree) if isinstance(n, ast.Attribute) and _is_stored(n))
        lines = [node.lineno for node in stores if ast.unparse(node) == name]
        return f"{self._script} sets it itself, in line {lines[0]}" if lines else ""

    def constant(self, name: str, original: Any) -> Any:
        """The value of a constant, instead of the script's."""
        if isinstance(original, (Block, Connection, Event, Simulation)):
            parameters = _named(inspect.signature(type(original)))
            example = f", such as {name}.{next(iter(parameters))}" if parameters else ""
            kind = type(original).__name__
            self._refuse(name, f"it is of class {kind}: set one of its parameters{example}")
        return self._taken(name, original)

    def arguments(
        self, variable: str, make: Callable[..., Any], args: tuple[Any, ...], kwargs: dict[str, Any]
    ) -> tuple[tuple[Any, ...], dict[str, Any]]:
        """The arguments of the call that makes a block, with the values set."""
        names = self._parameters[variable]
        try:
            signature = inspect.signature(make)
        except (TypeError, ValueError):
            self._refuse(f"{variable}.{names[0]}", f"{make!r} does not tell its parameters")
        try:
            bound = signature.bind_partial(*args, **kwargs)
        except TypeError:
            return args, kwargs  # the call itself raises the better error
        parameters = _named(signature)
        # a function may pass further keywords on
        catch_all = [n for n, p in signature.parameters.items() if p.kind is p.VAR_KEYWORD]
        options: dict[str, Any] = bound.arguments.get(catch_all[0], {}) if catch_all else {}
        for parameter in names:
            name = f"{variable}.{parameter}"
            if parameter in parameters:
                original = bound.arguments.get(parameter, parameters[parameter].default)
                bound.arguments[parameter] = self._taken(name, original)
            elif parameter in options:
                options[parameter] = self._taken(name, options[parameter])
            else:
                what = getattr(make, "__name__", repr(make))
                reason = f"{what} has no parameter {parameter!r}"
                self._refuse(name, reason + _listed(parameter, [*parameters, *options]))
        return bound.args, bound.kwargs

    def _taken(self, name: str, original: Any) -> Any:
        self._waiting.discard(name)
        value = self._values[name]
        return value.read(name, original) if isinstance(value, Text) else value

    def refuse_unused(self) -> None:
        """Raise for a setting whose line the script did not execute."""
        for name in sorted(self._waiting):
            self._refuse(name, f"{self._script} did not execute the line that uses it")


def _constants(tree: ast.Module) -> dict[str, ast.expr]:
    """The expression assigned to each name that is bound exactly once, at the top level."""
    nodes = own(tree.body)
    times = Counter([n.id for n in nodes if isinstance(n, ast.Name) and _is_stored(n)])
    bindings = {name for n in ast.walk(tree) if isinstance(n, ast.Global) for name in n.names}
    bindings |= {name for n in nodes if isinstance(n, _BINDING) for name in bound([n])}
    return {
        target.id: value
        for node in nodes
        if isinstance(node, _ASSIGNING) and len(getattr(node, "targets", (1,))) == 1
        for target, value in assignments(node)
        if times[target.id] == 1 and target.id not in bindings
    }


def _calls(tree: ast.Module) -> dict[str, list[ast.Call]]:
    """The calls from which each variable is assigned, at any level."""
    calls: dict[str, list[ast.Call]] = {}
    for node in ast.walk(tree):
        if isinstance(node, _ASSIGNING):
            for target, value in assignments(node):
                if isinstance(value, ast.Call):
                    calls.setdefault(target.id, []).append(value)
    return calls


def _listed(name: str, names: Iterable[str], blocks: Collection[str] = ()) -> str:
    """A hint: the nearest names, or all."""
    names, close = [*names], did_you_mean(nearest(name, [*names]))
    lists = [", ".join(names)] if names else []
    lists += [f"parameters of {', '.join(blocks)}"] if blocks else []
    return close or (f"; available: {' and '.join(lists)}" if lists else "")


def _is_stored(node: ast.Name | ast.Attribute) -> bool:
    return not isinstance(node.ctx, ast.Load)


def _named(signature: inspect.Signature) -> dict[str, inspect.Parameter]:
    """Parameters that can be passed by name."""
    kinds = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    return {n: p for n, p in signature.parameters.items() if p.kind in kinds}


def _following(names: Iterable[str], tree: ast.AST) -> set[str]:
    """The variables whose values depend on those of ``names``, these included."""
    variables, previous = set(names), set[str]()
    while variables != previous:
        previous = set(variables)
        for node in ast.walk(tree):
            value = getattr(node, "value", None) or getattr(node, "iter", None)
            if isinstance(value, ast.AST) and _names(value) & previous:
                targets = getattr(node, "targets", None) or [getattr(node, "target", None)]
                inner = (n for t in targets if t for n in ast.walk(t))
                variables |= {n.id for n in inner if isinstance(n, ast.Name)}
    return variables


def _names(expression: ast.AST) -> set[str]:
    """The names that an expression reads."""
    nodes = (n for n in ast.walk(expression) if isinstance(n, ast.Name))
    return {n.id for n in nodes if not _is_stored(n)}
